"""The bound on what roundings may change lets nothing else through."""

import pytest
import torch
from _asserts import assert_same_but_for_roundings, rollout
from _asserts.roundings import assert_equal_but_for_roundings
from _inputs import drifting

from aicon_torch import make_policy

POLICY = make_policy("nav2d")
RECORDED = drifting(12, (2,))
BEFORE, AFTER = rollout(POLICY, RECORDED)[-2:]


def test_the_step_itself_passes() -> None:
    assert_equal_but_for_roundings(POLICY, RECORDED[-1], BEFORE, AFTER)


@pytest.mark.parametrize("name", ["a", "p_tar", "P_tar", "x_obs"])
def test_a_share_of_a_billionth_is_seen(name: str) -> None:
    """A step of twelve gradients makes of roundings of 1e-13 at most 1e-10."""
    with pytest.raises(AssertionError, match=name):
        wrong = AFTER | {name: AFTER[name] * (1 + 1e-9)}
        assert_equal_but_for_roundings(POLICY, RECORDED[-1], BEFORE, wrong)


def test_a_count_that_is_wrong_is_seen() -> None:
    wrong = AFTER | {"z_tar.missed": AFTER["z_tar.missed"] + 1}
    with pytest.raises(AssertionError, match="missed"):
        assert_equal_but_for_roundings(POLICY, RECORDED[-1], BEFORE, wrong)


def test_a_function_may_amplify_what_is_rounded_and_no_more() -> None:
    def difference(x: torch.Tensor) -> torch.Tensor:
        return 1e6 * (x[..., 0] - x[..., 1])

    near = torch.tensor([0.1 + 1e-7, 0.1], dtype=torch.float64)
    assert_same_but_for_roundings(difference, near, difference(near) + 1e-9)
    with pytest.raises(AssertionError):
        assert_same_but_for_roundings(difference, near, difference(near) + 1e-5)
