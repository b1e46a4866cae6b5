"""A film of `two_arms.py`: two arms that reach across a table, each into the other's half.

Example: python scripts/two_arms_film.py ur5 ur5 --seed 1004 --out runs/two_arms/two_arms.webp
"""

import argparse
from collections.abc import Iterator, Sequence
from functools import partial

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.figures.rendering import Frame, camera, mark
from aicon_envs.reach import ROBOTS
from aicon_envs.reach.pair import ArmPair
from film import add_film, beside_each_other, labelled, save_film
from two_arms import DISTANCE, DT, Arm, drawn, episode, policies_of

Array = NDArray[np.float64]

SHOWN = ("without_escape", "aicon")
WIDTH, HEIGHT, EVERY = 420, 320, 5
"""Of a picture, px, and so many steps from a frame to the next."""

GREEN = "#1a7a33"
"""Of what is told of an episode."""

SECONDS, STAYS = 14.0, 14
"""How long the film is at most, s, and so many frames of the end."""

COLOURS = ((0.1, 0.6, 0.25, 0.9), (0.15, 0.3, 0.8, 0.9))
"""Of the targets of both arms."""

BALL = 0.02
"""Radius of a target, m."""


def run(arguments: argparse.Namespace) -> None:
    """Run the episode without the escape and with it, and film them beside each other."""
    first, second = arguments.robots
    pair, arms = ArmPair(ROBOTS[first], ROBOTS[second], DISTANCE), (Arm(first), Arm(second))
    targets = target_places(arms, drawn(pair, arms, arguments.seed))
    films = []
    for name in SHOWN:
        states: list[Array] = []
        watch = partial(_keep, pair, states)
        policies = policies_of(arms, name)
        found = episode(pair, arms, policies, arguments.seed, watch)
        print(f"{name}: {found}")
        states = states[: round(SECONDS / DT)]
        films.append(list(filmed(name, pair, targets, states, found.time)))

    save_film(beside_each_other(films, STAYS), arguments.out, DT * EVERY)


def _keep(pair: ArmPair, states: list[Array]) -> None:
    """Note where both arms are."""
    states.append(pair.data.qpos.copy())


def target_places(arms: Sequence[Arm], postures: Sequence[Array]) -> list[Array]:
    """Where both targets are in the frame of the first arm, m."""
    first, second = (arm.x_ee(q)[:3].numpy() for arm, q in zip(arms, postures, strict=True))
    return [first, second * (-1.0, -1.0, 1.0) + (DISTANCE, 0.0, 0.0)]


def filmed(
    name: str, pair: ArmPair, targets: Sequence[Array], states: Sequence[Array], time: float
) -> Iterator[Frame]:
    """The frames of an episode, with the policy's name, and when both arms were there."""
    view = camera((DISTANCE / 2, 0.0, 0.3), distance=2.2, azimuth=60.0, elevation=-22.0)
    data = mujoco.MjData(pair.model)
    with mujoco.Renderer(pair.model, HEIGHT, WIDTH) as renderer:
        for step in [*range(0, len(states), EVERY), len(states) - 1]:
            data.qpos[:] = states[step]
            mujoco.mj_forward(pair.model, data)

            renderer.update_scene(data, view)
            for place, colour in zip(targets, COLOURS, strict=True):
                mark(renderer.scene, place, BALL, colour)
            told = f"both are there, {time:.1f} s" if step * DT >= time else ""
            yield labelled(renderer.render(), name, told, GREEN)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is shown, and where it is saved."""
    parser.add_argument("robots", nargs=2, choices=sorted(ROBOTS), help="the two arms")
    add_option(parser, "--seed", 1004, "of the episode", type=at_least(0))
    add_film(parser, "runs/two_arms/two_arms.webp")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
