"""A tip that goes straight, and a board in its way: no world of others is needed for that."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch

BOARD = np.array([[0.0, 0.0, 1.0, 0.0, 0.2]])  # across x, 0.2 m high
TARGET = np.array([[0.2, 0.0, 0.05]])


@pytest.fixture
def picking(world_of: Callable[[str], Any]) -> Any:
    return world_of("shielded_picking")


class Straight:
    """Goes to the target at up to the full speed; the fourth number is a jaw's."""

    def predict(self, observation: Any, *_: Any, **__: Any) -> tuple[Any, Any]:
        way = np.clip((TARGET - observation["z_tip"]) / 0.025, -1.0, 1.0)
        return np.concatenate([way, [[0.5]]], -1), None


def moved(picking: Any, policy: Any) -> tuple[Any, float]:
    """Where the tip comes to in 20 s, and how near to the board."""
    tip, memory, least = np.array([[-0.2, 0.0, 0.05]]), None, np.inf
    for _ in range(200):
        action, memory = policy.predict({"z_tip": tip, "z_board": BOARD}, memory)
        assert action[0, 3] == 0.5
        tip = tip + 0.025 * action[:, :3]
        least = min(least, float(picking.gap(torch.tensor(tip), torch.tensor(BOARD))))
    return tip, least


def test_only_a_shield_comes_around_the_board(picking: Any) -> None:
    shield = picking.shielded(picking.JAW, Straight())
    bounds = picking.shielded(picking.JAW, Straight(), goes_around=False)
    clamp = picking.clamped(picking.JAW, Straight())

    tip, least = moved(picking, shield)
    assert tip == pytest.approx(TARGET, abs=0.01)
    assert least > 0.02
    for guard in (bounds, clamp):
        tip, least = moved(picking, guard)
        assert tip[0, 0] < 0
        assert least > 0.02


@pytest.mark.parametrize(
    ("tip", "expected"),
    [
        ([0.1, 0.0, 0.1], 0.08),
        ([0.0, 0.16, 0.1], 0.08),
        ([0.0, 0.0, 0.3], 0.08),
        ([0.03, 0.1, 0.0], 0.03),
        ([0.0, 0.0, 0.1], -0.02),
    ],
)
def test_a_gap_is_that_to_the_rounded_board(
    picking: Any, tip: list[float], expected: float
) -> None:
    gap = picking.gap(torch.tensor([tip]), torch.tensor(BOARD, dtype=torch.float32))
    assert gap.item() == pytest.approx(expected, abs=1e-3)
