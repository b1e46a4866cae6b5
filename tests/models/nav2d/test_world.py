"""The navigation policy in the world: it arrives, gets out of traps, and triangulates."""

from typing import Any

import gymnasium as gym
import pytest
import torch
from _inputs import driven

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_torch import Policy, SteepestPath

BACK = [(1.2, -0.7), (1.4, -0.7), (1.4, 0.7), (1.2, 0.7)]
TOP = [(0.5, 0.5), (1.4, 0.5), (1.4, 0.7), (0.5, 0.7)]
BOTTOM = [(0.5, -0.7), (1.4, -0.7), (1.4, -0.5), (0.5, -0.5)]
TRAP = [BACK, TOP, BOTTOM]
"""A U that opens towards the start, 0.7 m deep."""


def drive(policy: Policy, obstacles: list[Any], steps: int) -> tuple[bool, bool]:
    """Whether it arrives at a target 2.5 m ahead, and whether it collides."""
    env = gym.make("aicon/Nav2D-v0")
    where = {"obstacles": obstacles, "start": (0.0, 0.0), "target": (2.5, 0.0)}
    (observation, info), memory = env.reset(seed=0, options=where), None
    for _ in range(steps):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, _, info = env.step(action)
        if terminated:
            break
    return info["is_success"], info["collision"]


@pytest.mark.parametrize(
    "preset",
    [
        "aicon",
        "paper_literal",
        pytest.param("steepest", marks=pytest.mark.slow),
        pytest.param("potential_field", marks=pytest.mark.slow),
    ],
)
def test_in_the_open_every_policy_arrives(preset: str) -> None:
    assert drive(driven("nav2d", preset=preset), [], 400) == (True, False)


@pytest.mark.parametrize(
    "dtype", [torch.float64, pytest.param(torch.float32, marks=pytest.mark.slow)], ids=str
)
def test_aicon_gets_out_of_a_trap(dtype: torch.dtype) -> None:
    assert drive(driven("nav2d", dtype=dtype), TRAP, 1500) == (True, False)


def test_a_potential_field_stays_in_the_trap() -> None:
    assert drive(driven("nav2d", preset="potential_field"), TRAP, 700) == (False, False)


def set_out(seed: int, **options: Any) -> tuple[float, float]:
    """How far sideways it gets in 3 s on the way to a target far ahead, m.

    And how uncertain the target then is, m².
    """
    env, policy = gym.make("aicon/Nav2D-v0"), driven("nav2d", **options)
    where = {"obstacles": [], "start": (0.0, 0.0), "target": (6.0, 0.0)}
    observation, info = env.reset(seed=seed, options=where)

    memory: Any = None
    sideways = 0.0
    for _ in range(60):
        action, memory = policy.predict(observation, memory)
        observation, _, _, _, info = env.step(action)
        sideways = max(sideways, abs(float(info["position"][1])))
    return sideways, float(memory["P_tar"].diagonal().sum())


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_it_triangulates_at_first(seed: int) -> None:
    """Panel (a) of the paper's figure: it leaves the straight line to learn the distance."""
    aside, certain = set_out(seed)
    straight, uncertain = set_out(seed, resolution=SteepestPath())
    assert aside > 0.4 and aside > straight
    assert certain < 0.5 * uncertain
