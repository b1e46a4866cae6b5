"""Readings that come late, and a goal that is observed."""

import math
from typing import Any

import pytest
import torch
from _asserts import assert_rows_stand_alone, rollout
from _inputs import lean
from _inputs.pushing import body_of, in_pixels, wandering

from aicon_torch.models.pusht import PIXEL, benchmark

GOAL = (200 * PIXEL, 310 * PIXEL, -2.0)


@pytest.mark.parametrize("delay", [1, 3])
@pytest.mark.parametrize("command", ["position", "velocity"])
def test_late_readings_are_moved_on_by_what_was_done_since(delay: int, command: Any) -> None:
    """In the open, without noise: where the pusher is, though readings say where it was."""
    policy, body, memory = lean("pusht", delay=delay, command=command), body_of(), None
    pose = torch.tensor([400 * PIXEL, 400 * PIXEL, 0.5], dtype=torch.float64)
    places = [torch.full((2,), 20 * PIXEL, dtype=torch.float64)]

    for step in range(8):
        late = in_pixels(body, pose, places[max(step - delay, 0)])
        _, memory = policy.predict(late, memory)
        torch.testing.assert_close(memory["x_pusher"], places[-1], rtol=0, atol=1e-9)
        torch.testing.assert_close(memory["x_pose"], pose, rtol=0, atol=1e-9)

        away = [60 * PIXEL * math.sin(step), 50 * PIXEL]  # so that it stays in the open
        memory["a"] = torch.tensor(away, dtype=torch.float64)
        places.append(places[-1] + 0.1 * memory["a"])


def test_late_readings_lead_over_the_same_paths_and_leave_no_graph() -> None:
    late, prompt = lean("pusht", delay=2), lean("pusht")
    paths, expected = ({str(path) for path in policy.model.paths()} for policy in (late, prompt))
    assert paths == expected

    for memory in rollout(late, wandering(4, 3)):
        assert all(value.isfinite().all() for value in memory.values())
        assert not any(value.requires_grad for value in memory.values())
    assert_rows_stand_alone(late, wandering(4, 3), rows=(0, 2))


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest"])
def test_an_observed_goal_is_the_fixed_one(preset: str) -> None:
    fixed = lean("pusht", preset=preset, goal_pose=GOAL)
    observed = lean("pusht", preset=preset, observe_goal=True)
    assert "z_target" in observed.model.sensors and "z_target" not in fixed.model.sensors
    shown = torch.tensor([GOAL[0] / PIXEL, GOAL[1] / PIXEL, GOAL[2]], dtype=torch.float64)

    memory = other = None
    for reading in wandering(5, 4):
        action, memory = fixed.predict(reading, memory)
        same, other = observed.predict(reading | {"goal_pose": shown.expand(4, 3)}, other)
        torch.testing.assert_close(same, action, rtol=1e-9, atol=1e-9)


def test_a_whole_turn_of_the_goal_is_none() -> None:
    x, y, _ = benchmark.GOAL_POSE
    first, second = (
        rollout(lean("pusht", goal_pose=(x, y, angle)), wandering(3, 4))[-1]
        for angle in (0.8, 0.8 + 2 * math.pi)
    )
    torch.testing.assert_close(first["a"], second["a"], rtol=1e-8, atol=1e-9)
