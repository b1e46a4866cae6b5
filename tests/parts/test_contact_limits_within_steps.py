"""The limits near contact within a step: no sub-step of the servo goes too deep."""

from typing import Any

import pytest
from _inputs.contact_limits import limits_of, near_contact
from _inputs.pushing import TRIANGLE
from torch import Tensor

from aicon_envs.pusht import OBJECTS
from aicon_torch.models.pusht import PIXEL


def largest_excesses(keypoints: Any) -> tuple[Tensor, Tensor]:
    """Where the limits hold within a step, and where they hold at its end only."""
    within, end = (
        near_contact(
            limits_of(keypoints, **{"contact_limits.within_steps": bounded})
        ).largest_excess()
        for bounded in (True, False)
    )
    return within, end


def corners(name: str) -> Any:
    return (OBJECTS[name].keypoints * PIXEL).tolist()


@pytest.mark.parametrize(
    "keypoints", [TRIANGLE, corners("quadrilateral")], ids=["triangle", "quadrilateral"]
)
def test_no_sub_step_is_deeper_in_a_side_than_it_may_be(keypoints: Any) -> None:
    within, end = largest_excesses(keypoints)
    assert within.max() <= 1e-12
    assert end.max() > PIXEL


@pytest.mark.parametrize("keypoints", [None, corners("U")], ids=["T", "U"])
def test_hardly_any_sub_step_is_deeper_in_the_sides_of_a_corner(keypoints: Any) -> None:
    """A fast pusher that two sides hold back at once may be held back by one of them too little."""
    shares = [(excess > 1e-12).double().mean() for excess in largest_excesses(keypoints)]
    assert shares[0] < 0.002 < 0.008 < shares[1]
