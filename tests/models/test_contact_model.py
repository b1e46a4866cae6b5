"""Both worlds in which something is pushed have the same contact model, of another size."""

import dataclasses

import pytest

from aicon_torch.models import panda_push, pusht
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import ContactLimitOptions


def test_both_worlds_have_the_same_numbers() -> None:
    arm, disc = panda_push.Options().contact, pusht.Options().contact
    assert dataclasses.replace(arm, size=disc.size) == disc
    assert arm.size == pytest.approx(0.2)
    assert disc.size == pytest.approx(120 * PIXEL)


def test_the_limits_differ_in_how_far_a_contact_is_pushed() -> None:
    """The arm's step is shorter."""
    arm, disc = panda_push.Options().contact_limits, pusht.Options().contact_limits
    assert disc == ContactLimitOptions(push=(1 / 240, 1 / 3), harm=1 / 60)
    assert arm == ContactLimitOptions(push=(1 / 240, 1 / 24), harm=1 / 120)
