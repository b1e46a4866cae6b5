"""A table under an arm: links that can rise keep off it."""

import pytest
import torch
from _inputs.arm import HOME, panda_chain

from aicon_torch.errors import OptionError
from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts import Robot, SquaredHinge, Table
from aicon_torch.parts.self_collision import CapsuleSegments

COST = SquaredHinge(margin=0.01, weight=1.0)


def test_a_link_is_as_high_as_its_lowest_point() -> None:
    table = Table(0.2, (0, 2), (0.1, 0.05), COST)
    segments = torch.zeros(3, 6, dtype=torch.float64)
    segments[0, 2], segments[0, 5] = 0.5, 0.4
    segments[2, 2], segments[2, 5] = 0.2, 0.9
    assert table.distances(segments).tolist() == pytest.approx([0.1, -0.05])
    assert table.gaps(segments).tolist() == pytest.approx([0.09, -0.06])
    assert table(segments) == pytest.approx(COST(torch.tensor([0.1, -0.05])))


def test_links_that_only_turn_about_an_upright_axis_do_not_count() -> None:
    arm = Robot(panda_chain(), PANDA.shape)
    table = Table.under(arm, -0.2, COST)
    moved = {arm.shape.capsules[link].link for link in table.links}
    assert moved and min(moved) > 1
    assert (table.distances(CapsuleSegments(arm.chain, arm.shape.capsules)(HOME)) > 0).all()


def test_a_table_that_nothing_can_keep_off_is_an_error() -> None:
    with pytest.raises(OptionError, match=r"height=3\.0: .* gets no higher than"):
        Table.under(Robot(panda_chain(), PANDA.shape), 3.0, COST)
    with pytest.raises(OptionError, match="it has no shape"):
        Table.under(Robot(panda_chain()), 0.0, COST)
