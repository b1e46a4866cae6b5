"""How an episode starts: what `reset` draws and what its options ask for."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from aicon_envs.pusht.geometry import Pose
from aicon_envs.pusht.goal import Jump, draw_goal, draw_jumps
from aicon_envs.pusht.objects import PushObject
from aicon_envs.pusht.simulation import Simulation
from aicon_envs.pusht.variant import StartDistribution, Variant, check_pose, check_seed, check_state, is_random

OPTION_KEYS = ("reset_to_state", "goal_pose", "noise_seed")

State = tuple[float, float, float, float, float]


class Episode(NamedTuple):
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


def start_episode(
    object: PushObject,
    variant: Variant,
    options: Mapping[str, Any] | None,
    seed: int | None,
    generator: np.random.Generator,
) -> Episode:
    """Draw an episode: the start first, then a random goal, then its jumps.

    The noise comes from a child of the generator, which takes nothing from its stream.

    Args:
        object: What is pushed.
        variant: Variant of the task.
        options: `reset_to_state`, `goal_pose` and `noise_seed`, all optional.
        seed: What `reset` was called with; the starts of gym-pusht 0.1.5 are drawn from it.
        generator: The environment's `np_random`.

    Raises:
        ValueError: If a key is unknown or a value is not usable; the message names it.
    """
    options = {key: value for key, value in (options or {}).items() if value is not None}
    unknown = sorted(map(str, set(options) - set(OPTION_KEYS)))
    if unknown:
        raise ValueError(f"unknown option {', '.join(unknown)}; valid options are {', '.join(OPTION_KEYS)}")
    exact = "reset_to_state" in options and not variant.legacy_reset
    if "reset_to_state" in options:
        state = check_state("reset_to_state", options["reset_to_state"])
    else:
        state = draw_start(variant.start_distribution, seed, generator)
    place = Simulation if exact else Simulation.legacy
    simulation = place(object, state[:2], state[2:])
    goal = options.get("goal_pose", variant.goal_pose)
    goal = draw_goal(object, generator) if is_random(goal) else check_pose("goal_pose", goal)
    jumps = draw_jumps(object, variant.goal_jumps, variant.goal_jump_interval, generator)
    child = generator.spawn(1)[0]
    if "noise_seed" in options:
        child = np.random.default_rng(check_seed("noise_seed", options["noise_seed"]))
    return Episode(simulation, goal, jumps, child)


def draw_start(distribution: StartDistribution, seed: int | None, generator: np.random.Generator) -> State:
    """Draw a start as a version of gym-pusht does: with the same seed, the same numbers.

    Version 0.1.5 seeds a `numpy.random.RandomState` with the argument of `reset`, and its angle is not uniform but
    2π z - π with z normal. Without a seed, ours is seeded from `generator`, for an episode that can be repeated.
    """
    if distribution == "0.1.8":
        corner, middle = (50, 450), (100, 400)
        pusher = [float(generator.integers(*corner)) for _ in range(2)]
        block = [float(generator.integers(*middle)) for _ in range(2)]
        return pusher[0], pusher[1], block[0], block[1], float(generator.uniform(-math.pi, math.pi))
    source = int(generator.integers(2**32)) if seed is None else seed
    old = np.random.RandomState(source)  # the legacy generator, as upstream
    pusher = [float(old.randint(50, 450)) for _ in range(2)]
    block = [float(old.randint(100, 400)) for _ in range(2)]
    return pusher[0], pusher[1], block[0], block[1], float(old.randn() * 2 * math.pi - math.pi)
