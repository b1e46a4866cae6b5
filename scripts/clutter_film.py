"""A film of `clutter.py`: arms that find their ways among objects, without a plan.

Example: python scripts/clutter_film.py --out runs/clutter/clutter.webp
"""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from tqdm import tqdm

from aicon_baselines.cli.command_line import Command, add_option, run_command
from aicon_baselines.palette import OBSTACLE, ROBOT, TARGET
from aicon_baselines.worlds.motion_bench_maker import Problem, problems, resources, robot_of
from aicon_torch.parts import Robot, Solid
from clutter import CACHE, DT, Array, episodes, policy_of

SHOWN = (
    ("panda", "bookshelf_thin", 3),
    ("panda", "cage", 2),
    ("ur5", "table_under_pick", 2),
    ("ur5", "bookshelf_small", 3),
)
"""Robot, set and number of each problem, all of them from those for tuning."""

WIDTH, HEIGHT = 320, 300
EVERY = 4  # steps from a frame to the next
STAYS = 20  # frames at the end
CAMERA = {"azimuth": 65.0, "elevation": -18.0, "distance": 2.2}


class Panel(NamedTuple):
    """A problem and what its robot did."""

    robot: Robot
    problem: Problem
    way: Array


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where it is saved."""
    add_option(parser, "--out", Path("runs/clutter/clutter.webp"), "the film, a webp or an mp4")


def run(arguments: argparse.Namespace) -> None:
    """Solve the problems, and film them beside each other."""
    from aicon_baselines.figures.rendering import save_video

    folder = resources(CACHE)
    robots = dict.fromkeys(robot for robot, _, _ in SHOWN)
    panels = [panel for name in robots for panel in panels_of(name, folder)]

    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    save_video(draw(panels), arguments.out, round(1.0 / (DT * EVERY)))
    print(f"saved {arguments.out}")


def panels_of(name: str, folder: Path) -> list[Panel]:
    """What a robot does in its problems."""
    robot = robot_of(name, folder)
    chosen = [
        next(problems(name, folder, robot.chain.names, [set_name], [number]))
        for robot_name, set_name, number in SHOWN
        if robot_name == name
    ]
    solved = episodes(policy_of(name, robot, {}), robot, chosen)
    return [
        Panel(robot, problem, np.array(episode.way))
        for problem, episode in zip(chosen, solved, strict=True)
    ]


def draw(panels: Sequence[Panel]) -> Iterator[Any]:
    """The panels side by side, until the last robot has arrived."""
    views = [View(panel) for panel in panels]
    steps = max(len(panel.way) for panel in panels) + STAYS * EVERY
    for step in tqdm(range(0, steps, EVERY), desc="frames", disable=None):
        pictures = [
            view.at(panel.way[min(step, len(panel.way) - 1)])
            for view, panel in zip(views, panels, strict=True)
        ]
        yield np.concatenate(pictures, axis=1)


class View:
    """A problem as MuJoCo draws it."""

    def __init__(self, panel: Panel) -> None:
        import mujoco

        assert panel.robot.shape is not None
        self.chain = panel.robot.chain
        spec = mujoco.MjSpec()
        spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
        spec.visual.headlight.ambient = (0.5, 0.5, 0.5)
        spec.worldbody.add_light(pos=(0.0, -1.0, 3.0), dir=(0.1, 0.3, -1.0))
        spec.add_texture(
            type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
            builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
            width=64,
            height=64,
            rgb1=(1.0, 1.0, 1.0),
            rgb2=(1.0, 1.0, 1.0),
        )
        for solid in panel.problem.solids:
            _add_solid(spec, solid)
        tip = self.chain(torch.from_numpy(panel.problem.goal)).numpy()
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=(0.03, 0, 0),
            pos=tip[:3, 3],
            rgba=_rgba(TARGET, 0.8),
        )

        # The links are bodies that are put where they are.
        count = len(self.chain.names) + 1  # and the tool
        links = [spec.worldbody, *(spec.worldbody.add_body(mocap=True) for _ in range(count))]
        for capsule in panel.robot.shape.capsules:
            links[capsule.link].add_geom(
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=(capsule.radius, 0, 0),
                pos=capsule.start,
                rgba=_rgba(ROBOT),
            )
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.renderer = mujoco.Renderer(self.model, HEIGHT, WIDTH)
        self.camera = mujoco.MjvCamera()
        for name, value in {**CAMERA, "lookat": self._middle(panel)}.items():
            setattr(self.camera, name, value)

    def _middle(self, panel: Panel) -> Array:
        """What the camera looks at: half way from the shoulder to the target, m."""
        frames = self.chain.frames(torch.from_numpy(panel.problem.goal)).numpy()
        middle: Array = (frames[1, :3, 3] + frames[-1, :3, 3]) / 2.0
        return middle

    def at(self, q: Array) -> Any:
        """The picture of the robot at joint angles ``(n,)``, rad."""
        import mujoco

        frames = self.chain.frames(torch.from_numpy(q)).numpy()
        for number, frame in enumerate(frames):
            self.data.mocap_pos[number] = frame[:3, 3]
            mujoco.mju_mat2Quat(self.data.mocap_quat[number], frame[:3, :3].flatten())
        mujoco.mj_forward(self.model, self.data)
        self.renderer.update_scene(self.data, self.camera)
        return self.renderer.render().copy()


def _add_solid(spec: Any, solid: Solid) -> None:
    """An object of the problem."""
    import mujoco

    if solid.kind == "box":
        kind, size = mujoco.mjtGeom.mjGEOM_BOX, np.array(solid.size) / 2.0
    else:
        length, radius = solid.size
        kind, size = mujoco.mjtGeom.mjGEOM_CYLINDER, np.array((radius, length / 2.0, 0.0))
    spec.worldbody.add_geom(
        type=kind,
        size=size,
        pos=solid.position,
        quat=solid.orientation,
        rgba=_rgba(OBSTACLE, 0.4),
    )


def _rgba(color: str, opacity: float = 1.0) -> tuple[float, ...]:
    """A colour of the palette as MuJoCo takes it."""
    from matplotlib.colors import to_rgba

    return to_rgba(color, opacity)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
