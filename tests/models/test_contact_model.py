"""Both worlds in which something is pushed have the same contact model, of another size."""

import dataclasses

import pytest

from aicon_torch.models import arm_push, pusht
from aicon_torch.models.pusht import PIXEL


def test_both_worlds_have_the_same_numbers() -> None:
    arm, disc = arm_push.Options().contact, pusht.Options().contact
    assert dataclasses.replace(arm, size=disc.size, inset=disc.inset) == disc
    assert arm.size == pytest.approx(0.2)
    assert disc.size == pytest.approx(120 * PIXEL)
