"""Places that are known are a list, which the least often tried one leads."""

import torch
from torch import Tensor

from aicon_torch.safety.known_places import Known

LIMITS = torch.ones(2, dtype=torch.float64)
NONE = Known(torch.zeros(2, dtype=torch.bool), torch.zeros(2, 2).double(), torch.zeros(2).double())


def way(length: float) -> Tensor:
    """A way of this length along one component."""
    return torch.tensor([length, 0.0], dtype=torch.float64)


def known(*lengths: float) -> Known:
    """What remains of ways that become known one after the other, where there is room for two."""
    listed = NONE
    for length in lengths:
        listed = listed.with_one(way(length), torch.tensor(True), LIMITS)
    return listed


def leading(listed: Known) -> list[float]:
    """The length of the way that leads, if there is one."""
    return [float(each[0]) for each in listed.ways[listed.head(LIMITS)]]


def test_the_nearest_leads_until_it_was_tried() -> None:
    listed = known(-2.0, 1.0)
    assert leading(listed) == [1.0]
    tried = listed.tries + listed.head(LIMITS)
    assert leading(listed._replace(tries=tried)) == [-2.0]


def test_where_none_is_known_none_leads() -> None:
    assert leading(NONE) == []
    assert leading(NONE.with_one(way(1.0), torch.tensor(False), LIMITS)) == []


def test_a_place_is_listed_once() -> None:
    listed = known(1.0, 1.1)
    assert listed.is_place.sum() == 1
    assert leading(listed) == [1.0]


def test_a_place_takes_that_of_the_last_one_only_if_it_is_better() -> None:
    assert sorted(known(1.0, 3.0, -2.0).ways[:, 0].tolist()) == [-2.0, 1.0]
    assert sorted(known(1.0, -2.0, 3.0).ways[:, 0].tolist()) == [-2.0, 1.0]

    listed = known(1.0, -2.0)
    often = listed._replace(tries=torch.tensor([1.0, 0.0]).double())
    other = often.with_one(way(3.0), torch.tensor(True), LIMITS)
    assert sorted(other.ways[:, 0].tolist()) == [-2.0, 3.0]


def test_rows_of_a_batch_are_lists_of_their_own() -> None:
    ones, others = known(1.0), known(-2.0, 3.0)
    both = Known(*(torch.stack(pair, 1) for pair in zip(ones, others, strict=True)))
    assert leading(both) == [1.0, -2.0]
