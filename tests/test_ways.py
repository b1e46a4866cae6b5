"""An arm that rehearses places comes around an obstacle sooner than the policy alone."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest
import torch
from _asserts import assert_same_memory
from _inputs.clutter import POST, START, TARGET, beaded_arm, policy
from _inputs.reaching import DT, planar_arm, reach
from torch import Tensor

from aicon_torch import OptionError, Rehearsal, make_policy
from aicon_torch.parts import reading_of
from aicon_torch.ways import OtherPlaces

NEAR = 0.01
STEPS = 250


def imagine(seen: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {**seen, "q": seen["q"] + DT * memory["a"]}


def to_go(memory: Mapping[str, Tensor]) -> Tensor:
    away: Tensor = torch.linalg.vector_norm(memory["x_target"] - memory["x_ee"], dim=-1)
    return away


def rehearsed(rounds: int = 1) -> Rehearsal:
    ways = OtherPlaces(policy(), 7)
    return Rehearsal(policy(), imagine, to_go, NEAR, STEPS, ways, rounds)


def steps_of(way: Tensor) -> int:
    """How many steps it takes to arrive, ``(steps, n)``; all of them where it does not."""
    tip = beaded_arm().chain(way)[:, :3, 3]
    arrived = (tip - TARGET).norm(dim=-1) < NEAR
    return int(arrived.int().argmax()) if arrived.any() else len(way)


def test_it_arrives_sooner_and_within_what_it_looked_ahead() -> None:
    seen = {"target_position": TARGET, "obstacles": reading_of([POST], 2)}
    alone, _ = reach(policy(), START, seconds=30, **seen)
    better, _ = reach(rehearsed(rounds=4), START, seconds=6, **seen)
    assert steps_of(better) <= STEPS + 1
    assert steps_of(better) < steps_of(alone)


def test_a_batch_is_rehearsed_row_by_row() -> None:
    starts = torch.stack((START, -START))
    seen = {"target_position": TARGET, "obstacles": reading_of([POST], 2)}
    together, _ = reach(
        rehearsed(), starts, 1, **{name: value.expand(2, -1) for name, value in seen.items()}
    )
    for row, start in enumerate(starts):
        alone, _ = reach(rehearsed(), start, 1, **seen)
        torch.testing.assert_close(alone, together[:, row])


def test_the_first_way_is_the_memory_and_each_other_one_has_a_place_of_its_own() -> None:
    ways = OtherPlaces(policy(), 7)
    seen = {"q": START, "target_position": TARGET, "obstacles": reading_of([POST], 2)}
    _, memory = policy().predict(seen)
    first, second = ways.of(memory, 0), ways.of(memory, 1)
    for name, value in memory.items():
        torch.testing.assert_close(first[name][0], value)
    places = torch.cat((first["a/escape/place"][1:], second["a/escape/place"]))
    apart = torch.cdist(places, places) + torch.eye(15, dtype=places.dtype)
    assert apart.min() > 1e-3
    assert (places.abs() <= 1.0).all()


def test_a_policy_without_places_is_refused() -> None:
    still = make_policy("reach", preset="without_escape", robot=planar_arm())
    for without in (still, make_policy("nav2d")):
        with pytest.raises(OptionError, match="no actuator goes to places"):
            OtherPlaces(without)
    with pytest.raises(OptionError, match="count=0"):
        OtherPlaces(policy(), 0)
    with pytest.raises(OptionError, match="policy=3: expected Policy"):
        OtherPlaces(3)  # type: ignore[arg-type]  # wrong on purpose


def first_step(cost: Callable[[Mapping[str, Tensor]], Any]) -> dict[str, Tensor]:
    """The memory after the first step, which rehearses three places for ten steps."""
    rehearsal = Rehearsal(policy(), imagine, cost, NEAR, 10, OtherPlaces(policy(), 3))
    seen = {"q": START, "target_position": TARGET, "obstacles": reading_of([POST], 2)}
    _, memory = rehearsal.predict(seen)
    return memory


def test_a_way_whose_cost_is_no_number_hides_no_other_one() -> None:
    def to_go_of_escapes(memory: Mapping[str, Tensor]) -> Tensor:
        return torch.where(memory["a/escape/escaping"], to_go(memory), torch.nan)

    assert first_step(to_go_of_escapes)["a/escape/escaping"]


def test_a_cost_may_be_negative() -> None:
    shift, ways = 1.7, OtherPlaces(policy(), 7)
    seen = {"q": START, "target_position": TARGET, "obstacles": reading_of([POST], 2)}
    below = Rehearsal(policy(), imagine, lambda memory: to_go(memory) - shift, -1.69, 40, ways)
    above = Rehearsal(policy(), imagine, to_go, 0.01, 40, ways)
    assert_same_memory(below.predict(seen)[1], above.predict(seen)[1], 0.0)


@pytest.mark.parametrize("cost", [lambda _: 1.0, lambda memory: memory["x_ee"]])
def test_a_cost_that_is_no_number_for_each_row_is_named(cost: Any) -> None:
    with pytest.raises(OptionError, match=r"cost: expected a number for each row, \(4, 1\)"):
        first_step(cost)


def test_ways_of_another_policy_are_named() -> None:
    navigation = make_policy("nav2d")
    rehearsal = Rehearsal(navigation, imagine, to_go, NEAR, ways=OtherPlaces(policy()))
    with pytest.raises(OptionError, match="ways: no key .* ends with '/escape/escaping'"):
        rehearsal.predict({"bearing": [0.3], "range": [2.0]})
