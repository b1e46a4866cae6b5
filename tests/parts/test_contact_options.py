"""The numbers of the contact model, as shares of a size."""

import dataclasses
import math
from typing import Any

import pytest
import torch
from _inputs.pushing import body_of

from aicon_torch import OptionError
from aicon_torch.models.pusht.benchmark import PIXEL, PUSHER_RADIUS, T_WIDTH
from aicon_torch.parts import ContactOptions

CONTACT = ContactOptions(size=T_WIDTH)


def in_pixels(*lengths: float) -> tuple[float, ...]:
    return tuple(length / PIXEL for length in lengths)


def test_lengths_are_shares_of_the_size() -> None:
    """The numbers of the T that is 120 px wide, in px."""
    likelihood = CONTACT.likelihood(radius=PUSHER_RADIUS)
    lengths = (likelihood.reach, likelihood.reaction, likelihood.aim, likelihood.radius)
    assert in_pixels(*lengths) == pytest.approx((30, 10, 8, 15))

    dynamics = CONTACT.dynamics(body_of())
    assert dynamics.rotation_length == pytest.approx(1.55 * 3000**0.5 * PIXEL)
    assert dynamics.step == pytest.approx(PIXEL)


def test_a_world_twice_as_large_has_lengths_twice_as_long() -> None:
    small, large = CONTACT, dataclasses.replace(CONTACT, size=2 * T_WIDTH)
    first, second = small.likelihood(radius=0.01), large.likelihood(radius=0.02)
    pusher, side = torch.tensor([0.05, -0.04]), torch.tensor([0.0, 0.0, 0.1, 0.0])
    point = torch.tensor([0.05, 0.0])
    torch.testing.assert_close(first(pusher, point, side), second(2 * pusher, 2 * point, 2 * side))


NUMBERS = (0.0, -1.0, math.nan, math.inf, "a")
BAD: list[tuple[type, dict[str, Any]]] = [
    *((ContactOptions, {"size": value}) for value in NUMBERS),
    *(
        (ContactOptions, {"size": 0.1, name: value})
        for name in ("rotation", "reach", "reaction", "step")
        for value in NUMBERS
    ),
    *((ContactOptions, {"size": 0.1, "aim": value}) for value in NUMBERS[1:]),
    *((ContactOptions, {"size": 0.1, "intent": value}) for value in NUMBERS[1:]),
    (ContactOptions, {"size": 0.1, "effect": "best"}),
]


@pytest.mark.parametrize(("group", "options"), BAD, ids=str)
def test_a_number_that_cannot_be_is_named(group: Any, options: dict[str, Any]) -> None:
    *_, (name, value) = options.items()
    with pytest.raises(OptionError) as error:
        group(**options)
    assert f"{name}={value!r}" in str(error.value)
