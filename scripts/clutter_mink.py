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
import numpy as np
import torch
from torch import Tensor

from aicon_baselines.agents.reach.random_places import RandomPlaces
from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command
from aicon_baselines.worlds.motion_bench_maker import SPEED, Problem
from aicon_torch.models.reach.body import OBSTACLE_DISTANCE
from aicon_torch.models.reach.options import PRESETS
from aicon_torch.parts import Robot
from clutter import (
    DT,
    ESCAPES,
    Row,
    add_problems,
    chosen_problems,
    episodes,
    report,
)
from clutter_model import model_of
from study_table import fill

AGENTS = {"mink": False, "mink_places": True}
"""Whether it goes elsewhere where it is held up."""

BRAKING, STOP = 0.1, 0.02
"""T of gaps and stops, s, and how far joints stay from their stops, rad: as the policy has them."""

OBJECT_GAP, SELF_GAP = OBSTACLE_DISTANCE.margin, PRESETS["clutter"]["self_collision"].margin
"""How far spheres stay from objects and from each other, m: as the policy has them."""

SIGHT = 0.08
"""From how far both count, m."""

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
        model = model_of(robot, problem).compile()
        object_pairs, self_pairs = pairs_of(robot, problem)
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


def pairs_of(robot: Robot, problem: Problem) -> tuple[Pairs, Pairs]:
    """Which spheres and objects are kept apart, and which spheres."""
    assert robot.shape is not None
    moving = [number for number, each in enumerate(robot.shape.capsules) if each.link > 0]
    of_objects = [
        ([f"sphere_{sphere}"], [f"object_{number}"])
        for sphere in moving
        for number in range(len(problem.solids))
    ]
    return of_objects, [([f"sphere_{a}"], [f"sphere_{b}"]) for a, b in robot.shape.pairs]


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    robot, chosen = chosen_problems(arguments)

    def measure(robot_name: str, name: str, set_name: str, number: int) -> list[Row]:
        problem = chosen[set_name, number]
        (episode,) = episodes(Mink(robot, problem, AGENTS[name]), robot, [problem])
        row = episode.row(name, robot, problem)
        return [row._replace(time=row.time - row.thought)]  # computing is granted

    for name in arguments.agents:
        wanted = [(arguments.robot, name, *key) for key in chosen]
        table = arguments.out / f"{arguments.robot}.csv"
        report(name, fill(table, Row, wanted, measure, name))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_problems(parser, Path("runs/clutter"))
    parser.add_argument("--agents", nargs="+", choices=AGENTS, default=list(AGENTS))


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
