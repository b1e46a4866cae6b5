"""What cannot be reached: an actuator comes as near as it can, says so, and rests."""

import pytest
import torch
from _inputs.hand import DT, STOP, hand, turn
from _inputs.reaching import planar_arm, reach
from _inputs.walls import place
from torch import Tensor

from aicon_torch import make_policy
from aicon_torch.dampers import PlaceEscape
from aicon_torch.errors import OptionError

BEHIND_THE_STOPS = 3.14
FAR = torch.tensor([2.0, 1.5, 0.0], dtype=torch.float64)


def far_from(escape: PlaceEscape) -> tuple[Tensor, dict[str, Tensor]]:
    """The way of an arm to a target beyond its reach, and the memory at the end."""
    policy = make_policy("reach", robot=planar_arm(), **{"dampers.escape": escape}).compile()
    start = torch.tensor([0.3, 0.5, -0.2], dtype=torch.float64)
    return reach(policy, start, seconds=60, target_position=FAR)


def test_it_comes_as_near_as_it_can_and_rests() -> None:
    way, memory = far_from(PlaceEscape(gives_up=3))
    tips = planar_arm().chain(way)[..., :3, 3]
    farthest = torch.linalg.vector_norm(tips, dim=-1).amax()
    missing = torch.linalg.vector_norm(tips - FAR, dim=-1)
    assert missing[-1] < FAR.norm() - farthest + 0.01
    assert way[-50:].diff(dim=0).abs().max() < 1e-4
    assert memory["a/escape/gave_up"]
    assert int(memory["a/escape/escapes"]) in (3, 4)


def test_it_says_so() -> None:
    policy, q, memory = hand(PlaceEscape(gives_up=2)), place(2.5), None
    for _ in range(600):
        action, memory = policy.predict({"z": q, "z_target": place(BEHIND_THE_STOPS)}, memory)
        q = q + DT * action
    assert "a has given up: wherever it went, the goals cost 0.1" in str(policy.explain(memory))
    assert abs(q.item()) == pytest.approx(STOP, abs=0.05)

    # Another target is a new one.
    for _ in range(200):
        action, memory = policy.predict({"z": q, "z_target": place(1.0)}, memory)
        q = q + DT * action
    assert not memory["a/escape/gave_up"]
    assert q.item() == pytest.approx(1.0, abs=0.05)


def test_it_never_gives_up_unless_it_is_told_to() -> None:
    _, escaping = turn(hand(PlaceEscape()), start=2.5, target=BEHIND_THE_STOPS, steps=600)
    assert escaping[-200:].any()


def test_a_stretched_arm_does_not_go_to_and_fro() -> None:
    way, _ = far_from(PlaceEscape(patience=1e6))
    assert way[-50:].diff(dim=0).abs().max() < 1e-4


def test_to_give_up_before_the_first_place_is_refused() -> None:
    with pytest.raises(OptionError, match="gives_up=0"):
        PlaceEscape(gives_up=0)
