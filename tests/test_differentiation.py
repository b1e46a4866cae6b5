"""What is left out where nobody needs it: the results are those of a step without branches."""

from collections.abc import Mapping
from typing import Any

import pytest
import torch
from _inputs import (
    conflict,
    drifting,
    exploring_memory,
    lean,
    literal,
    pair,
    resolve,
)
from _inputs.following import passing
from torch import Tensor

from aicon_torch import NullspaceProjection, Policy, TrapEscape
from aicon_torch.differentiation import is_nowhere, recorded, through_time

RULES = {
    "as shipped": NullspaceProjection(),
    "as in the paper": NullspaceProjection.as_in_paper(),
    "held at a level": literal(TrapEscape(progress="g0", hold="g1", along="g1")),
    "onward": literal(TrapEscape(onward=True)),
}


def assert_same_bits(first: Mapping[str, Tensor], second: Mapping[str, Tensor]) -> None:
    assert first.keys() == second.keys()
    for name in first:
        assert torch.equal(first[name], second[name]), name


def test_flags_are_known_to_be_false_only_where_a_value_may_be_asked_for() -> None:
    nowhere, somewhere = torch.zeros(3, dtype=torch.bool), torch.tensor([False, True, False])
    assert is_nowhere(nowhere)
    assert not is_nowhere(somewhere)
    assert not is_nowhere(nowhere.to("meta"))

    with recorded():
        assert not is_nowhere(nowhere)
    with through_time():
        assert not is_nowhere(nowhere)
    assert is_nowhere(nowhere)


@pytest.mark.parametrize("before", [(False, False), (False, True), (True, True)], ids=str)
@pytest.mark.parametrize("now", ["nobody", "one", "all"])
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES.keys())
def test_rows_that_explore_and_rows_that_do_not_are_resolved_as_without_branches(
    rule: NullspaceProjection, now: str, before: tuple[bool, bool]
) -> None:
    agree, oppose = pair(0.3), conflict(size=2)[:2]
    rows = {"nobody": (agree, agree), "one": (agree, oppose), "all": (oppose, oppose)}[now]
    gradients = torch.stack(rows)
    memory = exploring_memory(gradients, rule, exploring=torch.tensor(before))
    motion = torch.tensor([[0.1, 0.2], [-0.3, 0.1]], dtype=torch.float64)

    total, after = resolve(rule, gradients, memory, motion=motion)
    with recorded():
        expected, expected_after = resolve(rule, gradients, memory, motion=motion)
    assert_same_bits({"total": total, **after}, {"total": expected, **expected_after})


@pytest.mark.parametrize("batch", [(), (3,)], ids=str)
@pytest.mark.parametrize(
    ("name", "readings"), [("nav2d", drifting), ("pusht", passing)], ids=["nav2d", "pusht"]
)
def test_a_step_is_the_same_as_without_branches(
    name: str, readings: Any, batch: tuple[int, ...]
) -> None:
    policy: Policy = lean(name)
    memory = None

    for observation in readings(12, batch):
        with recorded():
            expected, expected_after = policy.predict(observation, memory)
        action, memory = policy.predict(observation, memory)
        assert_same_bits({"action": action, **memory}, {"action": expected, **expected_after})


def test_what_is_done_with_an_action_does_not_change_the_memory() -> None:
    action, memory = lean("nav2d").predict(drifting(1)[0])
    remembered = memory["a"].clone()
    action.zero_()
    assert torch.equal(memory["a"], remembered)
