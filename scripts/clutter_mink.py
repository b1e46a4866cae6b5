"""An arm in clutter by mink: the same problems and places, its own limits.

Example: python scripts/clutter_mink.py panda --indices 51 60 --out runs/clutter

Its rows come into the table of `scripts/clutter.py`.
"""

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import mink
import mujoco
import numpy as np
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor
from tqdm import tqdm

from aicon_baselines.agents.reach.random_places import RandomPlaces
from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command
from aicon_baselines.worlds.motion_bench_maker import SPEED, Problem
from aicon_torch.parts import Robot
from clutter import (
    DT,
    ESCAPES,
    Array,
    Row,
    add_problems,
    chosen_problems,
    episodes,
    report,
    rows_of_problems,
)
from study_table import read, write

AGENTS = {"mink": False, "mink_places": True}
"""Whether it goes elsewhere where it is held up."""

BRAKING, STOP = 0.1, 0.02
"""T of gaps and stops, s, and how far joints stay from their stops, rad: as the policy has them."""

OBJECT_GAP, SELF_GAP, SIGHT = 0.003, 0.0025, 0.08
"""How far spheres stay from objects and from each other, and from how far both count, m."""

GAIN, LEVER, DAMPING = 20.0, 0.2, 1e-4
"""As `aicon_baselines.agents.reach.Mink` has them."""


class Mink:
    """mink among the objects of a problem; held up, it goes to the places of `random_places`.

    Args:
        robot: The robot.
        problem: The problem.
        goes_elsewhere: Whether it goes to other places.
    """

    def __init__(self, robot: Robot, problem: Problem, goes_elsewhere: bool) -> None:
        self.goes_elsewhere = goes_elsewhere
        model, object_pairs, self_pairs = _model(robot, problem)
        self.configuration = mink.Configuration(model)
        self.reach = mink.FrameTask("tip", "site", 1.0, LEVER, gain=min(1.0, GAIN * DT))
        self.go = mink.PostureTask(model, cost=1.0)
        share = DT / BRAKING
        collision: dict[str, Any] = {
            "gain": share * DT,  # mink divides it by dt, but bounds displacements
            "collision_detection_distance": SIGHT,
        }
        self.limits = [
            mink.ConfigurationLimit(model, share, STOP),
            mink.VelocityLimit(model, dict.fromkeys(robot.chain.names, SPEED)),
            *(
                mink.CollisionAvoidanceLimit(
                    model, pairs, minimum_distance_from_collisions=gap, **collision
                )
                for pairs, gap in ((object_pairs, OBJECT_GAP), (self_pairs, SELF_GAP))
                if pairs
            ),
        ]

        self.elsewhere = RandomPlaces(robot.chain.low.numpy(), robot.chain.high.numpy(), DT)

    def predict(self, seen: Mapping[str, Tensor], memory: Any) -> tuple[Tensor, dict[str, Tensor]]:
        """The joints' velocities ``(1, n)``, rad/s, and how often it went elsewhere."""
        q = seen["q"][0].numpy()
        self.configuration.update(q)
        target = mink.SE3.from_rotation_and_translation(
            mink.SO3(seen["target_orientation"][0].numpy()), seen["target_position"][0].numpy()
        )
        self.reach.set_target(target)

        # Toward the target, or where it is held up to another place.
        task: mink.Task = self.reach
        if self.goes_elsewhere:
            error = self.reach.compute_error(self.configuration)
            cost = math.hypot(np.linalg.norm(error[:3]), LEVER * np.linalg.norm(error[3:]))
            way = self.elsewhere.way(q, cost)
            if way is not None:
                self.go.set_target(q + DT * SPEED * way / np.abs(way).max())
                task = self.go

        try:
            velocity = mink.solve_ik(
                self.configuration, [task], DT, "daqp", damping=DAMPING, limits=self.limits
            )
        except mink.NoSolutionFound:
            velocity = np.zeros(len(q))
        self.elsewhere.moved(float(np.abs(velocity).max()) / SPEED)
        return torch.from_numpy(velocity[None]), {ESCAPES: torch.tensor([self.elsewhere.number])}


Pairs = list[tuple[list[str], list[str]]]
"""Of shapes, each named."""


def _model(robot: Robot, problem: Problem) -> tuple[mujoco.MjModel, Pairs, Pairs]:
    """The robot as spheres among the objects; the pairs of both, and of spheres alone."""
    assert robot.shape is not None
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    links, site = _add_chain(spec, robot)
    links[-1].add_site(name="tip", pos=site[:3, 3], quat=_quaternion(site[:3, :3]))

    for number, capsule in enumerate(robot.shape.capsules):
        _add_shape(links[capsule.link], f"sphere_{number}", "sphere", (capsule.radius, 0.0, 0.0))
        spec.geom(f"sphere_{number}").pos = capsule.start
    for number, solid in enumerate(problem.solids):
        if solid.kind == "box":
            _add_shape(spec.worldbody, f"object_{number}", "box", np.array(solid.size) / 2)
        else:
            length, radius = solid.size
            size = (radius, length / 2, 0.0)
            _add_shape(spec.worldbody, f"object_{number}", "cylinder", size)
        spec.geom(f"object_{number}").pos = solid.position
        spec.geom(f"object_{number}").quat = solid.orientation

    moving = [number for number, each in enumerate(robot.shape.capsules) if each.link > 0]
    of_objects = [
        ([f"sphere_{sphere}"], [f"object_{number}"])
        for sphere in moving
        for number in range(len(problem.solids))
    ]
    of_itself = [([f"sphere_{a}"], [f"sphere_{b}"]) for a, b in robot.shape.pairs]
    return spec.compile(), of_objects, of_itself


def _add_chain(spec: mujoco.MjSpec, robot: Robot) -> tuple[list[Any], Array]:
    """The links, the base first, and where the tip is on the last one, ``(4, 4)``."""
    chain = robot.chain
    frames = chain.frames(torch.zeros(len(chain.names), dtype=torch.float64)).numpy()
    links, before = [spec.worldbody], np.eye(4)
    for number, name in enumerate(chain.names):
        # A body where the joint is while all are at 0.
        own = np.linalg.inv(before) @ frames[number]
        link = links[-1].add_body(pos=own[:3, 3], quat=_quaternion(own[:3, :3]))
        joint = link.add_joint(name=name, axis=chain.axes[number].tolist())
        low, high = float(chain.low[number]), float(chain.high[number])
        if math.isfinite(low) and math.isfinite(high):
            joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, [low, high]

        # MuJoCo wants a mass, and kinematics do not.
        link.mass, link.inertia = 1.0, [0.01, 0.01, 0.01]
        link.explicitinertial = True
        links.append(link)
        before = frames[number]
    return links, np.linalg.inv(before) @ frames[-1]


def _add_shape(body: Any, name: str, kind: str, size: Any) -> None:
    """A shape on a body."""
    body.add_geom(name=name, type=getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}"), size=size)


def _quaternion(rotation: Array) -> Array:
    """The quaternion (w, x, y, z) of a rotation."""
    quaternion: Array = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    return quaternion


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    robot, to_run = chosen_problems(arguments)
    arguments.out.mkdir(parents=True, exist_ok=True)
    table = arguments.out / f"{arguments.robot}.csv"
    known = {(row.policy, row.set, row.number) for row in read(table, Row)}
    for name in arguments.agents:
        missing = [each for each in to_run if (name, each.set, each.index) not in known]
        for problem in tqdm(missing, desc=name, disable=None):
            (episode,) = episodes(Mink(robot, problem, AGENTS[name]), robot, [problem])
            row = episode.row(name, robot, problem)
            write(table, row._replace(time=row.time - row.thought))  # computing is granted

    rows = rows_of_problems(table, to_run)
    for name in arguments.agents:
        report(name, [row for row in rows if row.policy == name])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_problems(parser, Path("runs/clutter"))
    parser.add_argument("--agents", nargs="+", choices=AGENTS, default=list(AGENTS))


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
