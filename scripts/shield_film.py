"""A film of `shield.py arm`: joints that go straight where they shall be, and a ball in the way.

Example: python scripts/shield_film.py --seed 1002 --out runs/shield/shield.webp
"""

import argparse
from collections.abc import Iterator
from typing import Any

import numpy as np
from tqdm import tqdm

from aicon_baselines.agents.shields import arm
from aicon_baselines.agents.shields.world import Guard, guards
from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.figures.rendering import Frame
from aicon_baselines.palette import TARGET
from aicon_envs.reach.simulation import CONTROL_STEP
from film import add_film, beside_each_other, labelled, save_film

SIZE = (300, 300)
"""Of each picture, px."""

SECONDS, EVERY = 8.0, 5
"""How long the film is, s, and so many steps from a frame to the next."""

STAYS = 15
"""So many frames of the end."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is shown, and where it is saved."""
    add_option(parser, "--seed", 1002, "of the episode", type=at_least(0))
    add_film(parser, "runs/shield/shield.webp")


def run(arguments: argparse.Namespace) -> None:
    """Run the episode under each guard, and film them beside each other."""
    films = []
    for name, guard in tqdm(guards(arm.clamped, arm.shielded).items(), disable=None):
        films.append(list(filmed(name, guard, arguments.seed)))
    save_film(beside_each_other(films, STAYS), arguments.out, CONTROL_STEP * EVERY)


def filmed(name: str, guard: Guard, seed: int) -> Iterator[Frame]:
    """The frames of an episode, each with the guard's name and what has become of it."""
    env, state = arm.Posture(), None
    scene: Any = env.unwrapped
    policy: Any = guard(arm.Straight())
    observation, _ = env.reset(seed=seed)

    touched, arrived = False, False
    for step in range(round(SECONDS / CONTROL_STEP)):
        if step % EVERY == 0:
            told = "has touched" if touched else "has arrived" if arrived else ""
            yield labelled(scene.picture("outside", SIZE), name, told, TARGET)
        if arrived:
            continue

        seen = {name: np.asarray(value)[None] for name, value in observation.items()}
        action, state = policy.predict(seen, state)
        observation, _, arrived, _, info = env.step(np.asarray(action)[0])
        touched |= bool(info["collision"])
    env.close()


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
