"""A film of `clutter.py`: arms that find their ways among objects, without a plan.

Example: python scripts/clutter_film.py --out runs/clutter/clutter.webp
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import torch
from matplotlib.colors import to_rgba

from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.rendering import Frame, camera
from aicon_baselines.palette import OBSTACLE, ROBOT, TARGET
from aicon_baselines.worlds.motion_bench_maker import Problem, problems, resources, robot_of
from aicon_torch.parts import Robot
from clutter import CACHE, DT, Array, episodes, policy_of
from clutter_model import model_of
from film import add_film, beside_each_other, save_film

SHOWN = (
    ("panda", "bookshelf_thin", 3),
    ("panda", "cage", 2),
    ("ur5", "table_under_pick", 2),
    ("ur5", "bookshelf_small", 3),
)
"""Robot, set and number of each problem, all of them from those for tuning."""

WIDTH, HEIGHT = 320, 300
EVERY = 4  # steps from a frame to the next
STAYS = 19  # frames at the end


class Panel(NamedTuple):
    """A problem and what its robot did."""

    robot: Robot
    problem: Problem
    way: Array


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where it is saved."""
    add_film(parser, "runs/clutter/clutter.webp")


def run(arguments: argparse.Namespace) -> None:
    """Solve the problems, and film them beside each other."""
    folder = resources(CACHE)
    robots = dict.fromkeys(robot for robot, _, _ in SHOWN)
    panels = [panel for name in robots for panel in panels_of(name, folder)]
    films = [list(filmed(panel)) for panel in track(panels, "films")]

    save_film(beside_each_other(films, STAYS), arguments.out, DT * EVERY)


def panels_of(name: str, folder: Path) -> list[Panel]:
    """What a robot does in its problems."""
    robot = robot_of(name, folder)
    chosen = [
        next(problems(name, folder, robot.chain.names, [set_name], [number]))
        for robot_name, set_name, number in SHOWN
        if robot_name == name
    ]
    solved = episodes(policy_of(name, robot, "aicon").compile(), robot, chosen)
    return [
        Panel(robot, problem, np.array(episode.way))
        for problem, episode in zip(chosen, solved, strict=True)
    ]


def filmed(panel: Panel) -> Iterator[Frame]:
    """The frames of a panel, as MuJoCo draws them."""
    chain, goal = panel.robot.chain, torch.from_numpy(panel.problem.goal)
    frames = chain.frames(goal).numpy()
    half_way = (frames[1, :3, 3] + frames[-1, :3, 3]) / 2.0  # from the shoulder to the target
    view = camera(half_way, distance=2.2, azimuth=65.0, elevation=-18.0)

    model = coloured(panel, target=chain(goal).numpy()[:3, 3])
    data = mujoco.MjData(model)
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        for q in [*panel.way[::EVERY], panel.way[-1]]:
            data.qpos[:] = q
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, view)
            yield renderer.render()


def coloured(panel: Panel, target: Array) -> mujoco.MjModel:
    """The problem and a ball at its target, in colours, before a white sky."""
    spec = model_of(panel.robot, panel.problem)

    # Light, and a sky.
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

    # The robot and what is around it, and where it shall go.
    for geom in spec.geoms:
        geom.rgba = to_rgba(ROBOT) if geom.name.startswith("sphere") else to_rgba(OBSTACLE, 0.4)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=(0.03, 0.0, 0.0),
        pos=target,
        rgba=to_rgba(TARGET, 0.8),
    )

    return spec.compile()


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
