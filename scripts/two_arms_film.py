"""A film of `two_arms.py`: two arms that reach across a table, each into the other's half.

Example: python scripts/two_arms_film.py ur5 ur5 --seed 1004 --out runs/two_arms/two_arms.webp
"""

import argparse
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, add_option, run_command
from aicon_envs.reach import ROBOTS
from aicon_envs.reach.pair import ArmPair
from shield_film import labelled
from two_arms import DISTANCE, DT, POLICIES, Arm, drawn, episode, policy_of

Picture = NDArray[np.uint8]
Array = NDArray[np.float64]

SHOWN = ("without_escape", "aicon")
WIDTH, HEIGHT, EVERY = 420, 320, 5
"""Of a picture, px, and so many steps from a frame to the next."""

GREEN = "#1a7a33"
"""Of what is told of an episode."""

SECONDS, STAYS = 14.0, 15
"""How long the film is at most, s, and so many frames of the end."""

COLOURS = ((0.1, 0.6, 0.25, 0.9), (0.15, 0.3, 0.8, 0.9))
"""Of the targets of both arms."""

BALL = 0.02
"""Radius of a target, m."""


def run(arguments: argparse.Namespace) -> None:
    """Run the episode without the escape and with it, and film them beside each other."""
    from aicon_baselines.figures.rendering import save_video

    first, second = arguments.robots
    pair, arms = ArmPair(ROBOTS[first], ROBOTS[second], DISTANCE), [Arm(first), Arm(second)]
    films = []
    for name in SHOWN:
        options = POLICIES[name]
        policies = [policy_of(arms[0], arms[1], options), policy_of(arms[1], arms[0], options)]
        states: list[Array] = []
        watch = partial(_keep, pair, states)
        found = episode(pair, arms, policies, arguments.robots, arguments.seed, watch)
        print(f"{name}: {found}")
        films.append((name, states[: round(SECONDS / DT)], found.time))

    targets = target_places(arms, drawn(pair, arms, arguments.seed))
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    frames = beside_each_other(pair, targets, films)
    save_video(frames, arguments.out, round(1.0 / (DT * EVERY)))
    print(f"saved {arguments.out}")


def _keep(pair: ArmPair, states: list[Array]) -> None:
    """Note where both arms are."""
    states.append(pair.data.qpos.copy())


def target_places(arms: Sequence[Arm], postures: Sequence[Array]) -> list[Array]:
    """Where both targets are in the frame of the first arm, m."""
    first, second = (arm.x_ee(q)[:3].numpy() for arm, q in zip(arms, postures, strict=True))
    return [first, second * (-1.0, -1.0, 1.0) + (DISTANCE, 0.0, 0.0)]


def beside_each_other(
    pair: ArmPair, targets: Sequence[Array], films: Sequence[tuple[str, list[Array], float]]
) -> Iterator[Picture]:
    """Frames with a panel for each policy."""
    from aicon_baselines.figures.rendering import mark

    longest = max(len(states) for _, states, _ in films)
    data = mujoco.MjData(pair.model)
    with mujoco.Renderer(pair.model, HEIGHT, WIDTH) as renderer:
        for step in [*range(0, longest, EVERY), *[longest] * STAYS]:
            panels = []
            for name, states, time in films:
                data.qpos[:] = states[min(step, len(states) - 1)]
                mujoco.mj_forward(pair.model, data)

                renderer.update_scene(data, camera())
                for place, colour in zip(targets, COLOURS, strict=True):
                    mark(renderer.scene, place, BALL, colour)
                told = f"both are there, {time:.1f} s" if step * DT >= time else ""
                panels.append(labelled(renderer.render(), name, told, GREEN))
            yield np.concatenate(panels, axis=1)


def camera() -> mujoco.MjvCamera:
    """It looks at the middle of the table from the side."""
    found = mujoco.MjvCamera()
    found.lookat[:] = (DISTANCE / 2, 0.0, 0.3)
    found.distance, found.azimuth, found.elevation = 2.2, 60.0, -22.0
    return found


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is shown, and where it is saved."""
    parser.add_argument("robots", nargs=2, choices=sorted(ROBOTS), help="the two arms")
    add_option(parser, "--seed", 1004, "of the episode")
    add_option(parser, "--out", Path("runs/two_arms/two_arms.webp"), "the film, a webp or an mp4")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
