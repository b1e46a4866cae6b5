"""The navigation model: the paper's three paths, their closed forms, what they lead to, and a fourth goal."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from _asserts import along, rollout
from _inputs import drifting, normal, with_goal
from torch import Tensor

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_torch import Goal, Policy, make_policy
from aicon_torch.models import nav2d as navigation

MODEL = make_policy("nav2d").model


def values_at(memory: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name: value for name, value in memory.items() if name in MODEL.quantities}


# --- the paper's graph


def test_the_paths_are_the_paper_s() -> None:
    paths = {str(path) for path in MODEL.paths()}
    assert paths == {"reach → p_tar → x_rob → a", "reach → P_tar → x_rob → a", "avoid → x_obs → x_rob → a"}
    assert len(MODEL.paths()) == 3
    both = make_policy("nav2d", sensing="range_bearing").model
    assert {str(path) for path in both.paths()} == paths


def test_the_drawing_lists_every_node() -> None:
    drawn = MODEL.to_mermaid()
    for name in ("z_tar", "z_obs", "a", "x_rob", "p_tar", "P_tar", "x_obs", "P_obs", "reach", "avoid"):
        assert name in drawn


def test_the_gradients_have_the_closed_forms_of_the_paper() -> None:
    """p₁ = −μ/‖μ‖, p₃ = ∇exp(−d/ℓ) = −exp(−d/ℓ)/ℓ·∇d, and p₂ by finite differences of tr Σ⁺; all times dt at a."""
    for memory in rollout(make_policy("nav2d"), drifting(120))[::20]:
        start = values_at(memory)
        tapes = MODEL.record(start)
        slopes = {str(path): along(path, MODEL, tapes) for path in MODEL.paths()}
        p1 = -start["p_tar"] / start["p_tar"].norm()
        torch.testing.assert_close(slopes["reach → p_tar → x_rob → a"], 0.05 * p1)
        p3 = -torch.exp(-start["x_obs"][:1] / 0.04) / 0.04 * start["x_obs"][1:]
        torch.testing.assert_close(slopes["avoid → x_obs → x_rob → a"], 0.05 * p3)

        def uncertainty(action: Tensor, start: dict[str, Tensor] = start) -> Tensor:
            mean = start["p_tar"] - start["x_rob"] - 0.05 * (action - start["a"])
            prior = start["P_tar"] + (0.02 * 0.05) ** 2 * torch.eye(2, dtype=torch.float64)
            h = torch.stack((-mean[1], mean[0])) / (mean @ mean)
            posterior = prior - torch.outer(prior @ h, prior @ h) / (h @ prior @ h + 0.03**2)
            return posterior.trace()

        steps = 1e-6 * torch.eye(2, dtype=torch.float64)
        numeric = [(uncertainty(start["a"] + s) - uncertainty(start["a"] - s)) / 2e-6 for s in steps]
        torch.testing.assert_close(slopes["reach → P_tar → x_rob → a"], torch.stack(numeric), rtol=1e-4, atol=1e-8)


def test_costs_are_the_paper_s() -> None:
    p, cov = normal(3, 2), torch.diag_embed(normal(3, 2) ** 2)
    expected = p.norm(dim=-1) + cov.diagonal(dim1=-2, dim2=-1).sum(-1)
    torch.testing.assert_close(navigation.expected_distance(p, cov), expected)
    d = torch.tensor([[0.04, 1.0, 0.0], [0.0, 0.0, 1.0]], dtype=torch.float64)
    assert navigation.collision_likelihood(d).tolist() == pytest.approx([math.exp(-1.0), 1.0])


def test_the_obstacle_s_direction_is_learned_from_motion() -> None:
    """A wall at x = 2: the readings are one number, its direction comes from how it changes."""
    policy, position, memory = make_policy("nav2d"), torch.zeros(2, dtype=torch.float64), None
    for step in range(60):
        reading = {"bearing": torch.zeros(1).double(), "range": (2.0 - position[:1])}
        memory = policy.estimate(
            reading, memory, {"a": torch.tensor([0.4 * math.cos(step / 9), 0.4 * math.sin(step / 9)]).double()}
        )
        position = position + memory["x_rob"]
    assert memory is not None
    torch.testing.assert_close(memory["x_obs"][1:], torch.tensor([-1.0, 0.0]).double(), rtol=0, atol=0.25)
    torch.testing.assert_close(memory["x_obs"][:1], 2.0 - position[:1] + memory["x_rob"][:1], rtol=0, atol=0.02)


def test_angles_wrap() -> None:
    angles = torch.tensor([0.0, 3.0, 4.0, -4.0, 7.0, math.pi], dtype=torch.float64)
    expected = torch.atan2(torch.sin(angles), torch.cos(angles))
    torch.testing.assert_close(navigation.wrap(angles)[:-1], expected[:-1])
    assert (navigation.wrap(angles).abs() <= math.pi).all()


# --- in the world


def arrives(policy: Policy, obstacles: list[Any], steps: int, seed: int = 0, **options: Any) -> tuple[bool, bool]:
    env = gym.make("aicon/Nav2D-v0", **options)
    where = {"obstacles": obstacles, "start": (0.0, 0.0), "target": (2.5, 0.0)}
    (observation, info), memory = env.reset(seed=seed, options=where), None
    for _ in range(steps):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, _, info = env.step(action)
        if terminated:
            break
    return info["is_success"], info["collision"]


TRAP = [[(1.2, -0.7), (1.4, -0.7), (1.4, 0.7), (1.2, 0.7)], [(0.5, 0.5), (1.4, 0.5), (1.4, 0.7), (0.5, 0.7)],
        [(0.5, -0.7), (1.4, -0.7), (1.4, -0.5), (0.5, -0.5)]]  # fmt: skip
"""A U that opens towards the start, 0.7 m deep."""


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest", "potential_field"])
def test_in_the_open_every_policy_arrives(preset: str) -> None:
    assert arrives(make_policy("nav2d", preset=preset), [], 400) == (True, False)


@pytest.mark.parametrize("dtype", [torch.float64, torch.float32], ids=str)
def test_only_aicon_gets_out_of_a_trap(dtype: torch.dtype) -> None:
    assert arrives(make_policy("nav2d", dtype=dtype), TRAP, 1500) == (True, False)
    if dtype is torch.float64:
        assert arrives(make_policy("nav2d", preset="potential_field"), TRAP, 700) == (False, False)


def approach(seed: int, **options: Any) -> tuple[float, float]:
    """How far sideways it gets in 3 s on the way to a target far ahead, m, and how uncertain it then is, m²."""
    env, policy = gym.make("aicon/Nav2D-v0"), make_policy("nav2d", **options)
    observation, info = env.reset(seed=seed, options={"obstacles": [], "start": (0.0, 0.0), "target": (6.0, 0.0)})
    memory: Any = None
    sideways = 0.0
    for _ in range(60):
        action, memory = policy.predict(observation, memory)
        observation, _, _, _, info = env.step(action)
        sideways = max(sideways, abs(float(info["position"][1])))
    return sideways, float(memory["P_tar"].diagonal().sum())


@pytest.mark.parametrize("seed", [1, 2])
def test_it_triangulates_at_first(seed: int) -> None:
    """Panel (a) of the paper's figure: it leaves the straight line to learn how far the target is."""
    (aside, certain), (straight, uncertain) = approach(seed), approach(seed, resolution="steepest")
    assert aside > 0.4 and aside > straight
    assert certain < 0.5 * uncertain


# --- a fourth goal, without touching a module


def beside(p_tar: Tensor) -> Tensor:
    """Stay in a lane 1 m wide along the x axis through the target."""
    return torch.nn.functional.softplus(8.0 * (p_tar[..., 1].abs() - 0.5))


def extended() -> Policy:
    return with_goal(Goal("lane", beside))


def test_a_fourth_goal_is_one_more_path() -> None:
    policy = extended()
    assert {str(path) for path in policy.model.paths()} == {
        *(str(path) for path in MODEL.paths()),
        "lane → p_tar → x_rob → a",
    }
    _, memory = policy.predict(drifting(1)[0])
    assert memory["p_tar/gradients"].shape == (2, 2)  # reach and lane meet at the target's estimate
    assert memory["x_rob/gradients"].shape == (3, 2)
    assert set(policy.explain(memory).meetings) == {"p_tar", "x_rob", "a"}


def drive(lane: bool, steps: int) -> tuple[Policy, dict[str, Tensor], dict[str, Any], Any]:
    """Through an open world without noise towards (6, 3): policy, memory, the next reading, and where it got to."""
    policy, position = extended(), np.zeros(2)
    memory: Any = None
    for step in range(steps + 1):
        ahead = np.array([6.0, 3.0]) - position
        reading = {"bearing": np.array([math.atan2(ahead[1], ahead[0])]), "range": np.array([20.0])}
        if memory is not None:
            memory = policy.switch(memory, lane=lane)
        action, after = policy.predict(reading, memory)
        if step < steps:
            position, memory = position + 0.05 * action, after
    return policy, memory, reading, position


def test_a_fourth_goal_acts() -> None:
    """Outside the lane it pulls the robot in, alone and among the others."""
    policy, memory, reading, _ = drive(lane=False, steps=100)
    assert memory["p_tar"][1] > 0.5
    alone = policy.predict(reading, policy.switch(memory, reach=False, avoid=False, lane=True))[1]
    wish = alone["a"] - memory["a"] * 2 / 3  # the low-pass keeps two thirds
    assert wish[1] > 0.1 and abs(float(wish[0])) < 1e-9
    on, off = (policy.predict(reading, policy.switch(memory, lane=lane))[1] for lane in (True, False))
    changes = [policy.explain(after).goals["lane"].predicted_change for after in (on, off)]
    assert changes[0] < changes[1] - 1e-3


def test_a_fourth_goal_keeps_the_robot_in_its_lane_on_the_way() -> None:
    heights = {lane: abs(drive(lane, 130)[3][1] - 3.0) for lane in (True, False)}
    assert heights[True] < 0.5 < heights[False]
