"""Where constraints bring an actuator to rest short of its goal, the mechanism finds a way out."""

import math

import pytest
import torch
from _inputs.hand import DT, STOP, hand, turn
from _inputs.walls import place

from aicon_torch.dampers import PlaceEscape
from aicon_torch.safety import places


def test_behind_a_stop_it_goes_the_other_way_round() -> None:
    way, escaping = turn(hand(PlaceEscape()), start=2.5, target=-2.8, steps=200)
    assert way.abs().max() < STOP
    assert way[-1] == pytest.approx(-2.8, abs=0.05)
    assert escaping.any()
    assert not escaping[-1]


def test_a_detour_leads_to_no_target_and_is_slowed_by_none() -> None:
    way, escaping = turn(hand(PlaceEscape(), slowed=True), start=2.5, target=-2.8, steps=200)
    speeds = (way.diff() / DT).abs()
    was, now = escaping[:-1], escaping[1:]  # what a step decides is done in the next one
    assert speeds[1:][was & now].amax() == pytest.approx(1.0)
    assert speeds[1:][~was & ~now].amax() < 0.6


@pytest.mark.parametrize("first", [0.5, -2.8])
def test_the_next_target_is_judged_by_itself(first: float) -> None:
    """What the last one cost, or how often it was escaped from, says nothing about it."""
    policy = hand(PlaceEscape())
    q, memory = place(2.5), None
    for _ in range(300):
        action, memory = policy.predict({"z": q, "z_target": place(first)}, memory)
        q = q + DT * action

    for _ in range(150):
        action, memory = policy.predict({"z": q, "z_target": place(-0.5)}, memory)
        assert not memory["a/escape/escaping"]
        q = q + DT * action
        if abs(float(q) + 0.5) < 0.05:
            break
    else:
        pytest.fail(f"It is still at {float(q):.2f} rad.")


def test_without_an_escape_it_stays_at_the_stop() -> None:
    way, _ = turn(hand(None), start=2.5, target=-2.8, steps=200)
    assert way[-1] == pytest.approx(STOP, abs=0.05)


def test_where_the_way_is_free_it_never_escapes() -> None:
    _, escaping = turn(hand(PlaceEscape()), start=0.5, target=-1.0, steps=200)
    assert not escaping.any()


def test_noise_at_the_target_is_no_stalemate() -> None:
    noise = torch.randn(600, 1, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    policy, q, memory = hand(PlaceEscape()), place(0.5), None

    for disturbance in 0.05 * noise:  # five times what counts as near enough to stay
        action, memory = policy.predict({"z": q, "z_target": place(-1.0) + disturbance}, memory)
        q = q + DT * action
        assert not memory["a/escape/escaping"]
    assert q.item() == pytest.approx(-1.0, abs=0.2)


def test_every_detour_goes_to_a_place_in_the_middle_half_away_from_the_stop() -> None:
    """Between two stops of one joint, each of which is nearest to the target."""
    policy, memory, q = hand(PlaceEscape()), None, place(2.5)
    found: list[float] = []
    for _ in range(400):
        was = memory is not None and bool(memory["a/escape/escaping"])
        action, memory = policy.predict({"z": q, "z_target": place(math.pi)}, memory)
        if bool(memory["a/escape/escaping"]) and not was:
            assert float(q) * float(memory["a/escape/place"]) < 0
            found.append(float(q + memory["a/escape/direction"]))
        q = q + DT * action

    assert len(found) > 1
    assert all(abs(each) <= STOP / 2 for each in found)


@pytest.mark.parametrize("factor", [2, 4])
def test_a_robot_as_many_times_as_fast_escapes_alike(factor: int) -> None:
    slow, fast = hand(PlaceEscape()), hand(PlaceEscape(), float(factor), DT / factor)
    ways = [turn(policy, start=2.5, target=-2.8, steps=200)[0] for policy in (slow, fast)]
    torch.testing.assert_close(*ways, rtol=0, atol=1e-6)


def test_it_gives_up_a_blind_detour_after_its_largest_duration(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(places, "LONGEST", 1.0)
    own = PlaceEscape(near=0.006, seeks=False)  # no other test shares this policy
    _, escaping = turn(hand(own), start=2.5, target=-2.8, steps=60)
    started = int(escaping.nonzero()[0])
    duration = int((~escaping[started:]).nonzero()[0]) * DT
    assert duration == pytest.approx(1.0, abs=2 * DT)  # at 1 rad/s


def test_each_row_of_a_batch_escapes_by_itself() -> None:
    policy, memory = hand(PlaceEscape()), None
    q, target = torch.tensor([[2.5], [0.5]], dtype=torch.float64), torch.tensor([[-2.8], [1.0]])
    for _ in range(200):
        action, memory = policy.predict({"z": q, "z_target": target.double()}, memory)
        q = q + DT * action
    torch.testing.assert_close(q, target.double(), rtol=0, atol=0.05)
    assert memory is not None
    assert memory["a/escape/escapes"].tolist() == [1, 0]


def test_the_trace_tells_that_it_escapes() -> None:
    policy, memory, q = hand(PlaceEscape()), None, place(2.5)
    explored: list[bool] = []
    escaped: list[bool] = []
    for _ in range(60):
        action, memory = policy.predict({"z": q, "z_target": place(-2.8)}, memory)
        q = q + DT * action
        explored.append(bool(policy.trace(memory).quantities["a"].exploring))
        escaped.append(bool(memory["a/escape/escaping"]))
    assert explored == escaped
    assert any(explored)
