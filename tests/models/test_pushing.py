"""A hand pushes a round thing to rest at its goal, whichever side of it the hand begins on."""

import numpy as np
import pytest
import torch
from torch import Tensor

from aicon_torch import Policy
from aicon_torch.models.pushing import Hand, build_policy
from aicon_torch.parts import ContactOptions, RoundObject

HAND = Hand(time_step=0.04, stride=0.03)
PUCK = RoundObject(0.028, pusher_radius=0.015, friction=1.0, contact=ContactOptions(size=0.4))


class Table:
    """A hand and a puck, which goes as its part says."""

    def __init__(self, hand: tuple[float, float], goal: tuple[float, float]) -> None:
        self.hand = torch.tensor([*hand, 0.05], dtype=torch.float64)
        self.place, self.velocity = torch.zeros(2, 2, dtype=torch.float64)
        self.goal = torch.tensor([*goal, 0.02], dtype=torch.float64)

    def seen(self) -> dict[str, Tensor]:
        return {
            "z_hand": self.hand,
            "z_goal": self.goal,
            "z_place": self.place,
            "v_obj": self.velocity,
        }

    def step(self, action: dict[str, np.ndarray]) -> None:
        dt = torch.tensor(HAND.time_step, dtype=torch.float64)
        way = HAND.stride * torch.from_numpy(np.concatenate([action["a"], action["lift"]])).double()
        self.hand = self.hand + way
        slid = PUCK.slid(self.place, self.velocity, dt)
        place = slid + PUCK.push(slid, self.hand[:2], way[:2])
        self.place, self.velocity = place, (place - self.place) / dt

    @property
    def error(self) -> float:
        return float(torch.linalg.norm(self.place - self.goal[:2]))


@pytest.fixture(scope="module")
def compiled() -> Policy:
    return build_policy(HAND, PUCK).compile()


@pytest.mark.parametrize("hand", [(-0.1, 0.02), (0.12, 0.01), (0.03, -0.1)])
def test_the_hand_comes_to_the_far_side_and_pushes(
    hand: tuple[float, float], compiled: Policy
) -> None:
    table = Table(hand, goal=(0.2, 0.05))
    compiled.reset()
    for _ in range(60):
        table.step(compiled.act(table.seen()))
    assert table.error < 0.05
    assert float(table.hand[2]) == pytest.approx(0.02, abs=0.005)


def test_a_hand_that_is_told_less_far_is_slower() -> None:
    slow = Hand(time_step=0.04, stride=0.01)
    assert slow.actuator("a", 2).limit == pytest.approx(0.25)
