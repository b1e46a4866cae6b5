"""How an episode starts: what `reset` draws and what its options ask for."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from aicon_envs.checks import check_integer, given_options
from aicon_envs.pusht.geometry import Pose
from aicon_envs.pusht.goal import Jump, draw_goal, draw_jumps
from aicon_envs.pusht.objects import PushObject
from aicon_envs.pusht.settings import (
    JUMP_INTERVAL,
    State,
    TaskSettings,
    check_pose,
    check_state,
    is_random,
)
from aicon_envs.pusht.simulation import Simulation

_OPTION_KEYS = ("reset_to_state", "goal_pose", "noise_seed")

_PUSHER_BOUNDS = (50, 450)
"""Between which gym-pusht draws x and y of the pusher, px."""

_OBJECT_BOUNDS = (100, 400)
"""Between which it draws those of the object, px."""


class EpisodeStart(NamedTuple):
    """What is fixed at a reset.

    Attributes:
        simulation: The world at the start.
        goal: The first goal, px and rad.
        jumps: Later goals.
        noise: Source of what is random during the episode.
    """

    simulation: Simulation
    goal: Pose
    jumps: list[Jump]
    noise: np.random.Generator


def draw_episode(
    object: PushObject,
    settings: TaskSettings,
    options: Mapping[str, Any] | None,
    generator: np.random.Generator,
) -> EpisodeStart:
    """Draw an episode: the start first, then a random goal, then its jumps.

    The noise comes from a child of the generator, which takes nothing from its stream.

    Args:
        object: What is pushed.
        settings: Settings of the task.
        options: `reset_to_state`, `goal_pose` and `noise_seed`, all optional.
        generator: The environment's `np_random`.

    Raises:
        ValueError: If a key is unknown or a value is not usable; the message names it.
    """
    options = given_options(options, _OPTION_KEYS)

    # This order is part of the contract: settings that draw more leave the start as it is.
    simulation = _start_simulation(object, options, generator)
    given = options.get("goal_pose", settings.goal_pose)
    goal = draw_goal(object, generator) if is_random(given) else check_pose("goal_pose", given)
    jumps = draw_jumps(object, settings.goal_jumps, JUMP_INTERVAL, generator)

    # Spawned in any case, such that the option changes nothing but the noise.
    (noise,) = generator.spawn(1)
    if "noise_seed" in options:
        noise = np.random.default_rng(check_integer("noise_seed", options["noise_seed"], 0))

    return EpisodeStart(simulation, goal, jumps, noise)


def _start_simulation(
    object: PushObject, options: Mapping[str, Any], generator: np.random.Generator
) -> Simulation:
    """Put pusher and object where the options say, or where gym-pusht would."""
    if "reset_to_state" in options:
        state = check_state("reset_to_state", options["reset_to_state"])
        return Simulation(object, state[:2], state[2:])

    state = _draw_state(generator)
    return Simulation.legacy(object, state[:2], state[2:])


def _draw_state(generator: np.random.Generator) -> State:
    """Draw a state as gym-pusht 0.1.8 does: with the same seed, the same numbers."""
    pusher_x = float(generator.integers(*_PUSHER_BOUNDS))
    pusher_y = float(generator.integers(*_PUSHER_BOUNDS))
    object_x = float(generator.integers(*_OBJECT_BOUNDS))
    object_y = float(generator.integers(*_OBJECT_BOUNDS))
    angle = float(generator.uniform(-math.pi, math.pi))
    return pusher_x, pusher_y, object_x, object_y, angle
