"""What is rare is translated as it is in torch: no numbers at all, zeros of either sign, views."""

from pathlib import Path

import pytest
import torch
from _inputs import normal
from _inputs.translated import SIZE, Function, translated
from torch import Tensor

from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

SPECIAL = [0.0, -0.0, 1.0, -1.0, torch.nan, torch.inf, -torch.inf, 2.5, -2.5, 0.5, -0.5, 3.0]
FAR = torch.arange(300.0).where(torch.arange(300) % 3 > 0, -torch.inf)


def of_nothing(x: Tensor) -> Tensor:
    """Sums and the like along no numbers, and of no rows."""
    none, no_rows = x[:0].reshape(3, 0), x[:0].reshape(0, 3)
    found = [none.sum(-1), none.prod(-1), none.mean(-1), none.logsumexp(-1), none.norm(dim=-1)]
    found += [(none > 0).any(-1), (none > 0).all(-1), none @ none.mT, x[[]], none.softmax(-1)]
    found += [no_rows.sum(-1), no_rows.amax(-1), no_rows.argmax(-1), no_rows.sort(-1).values]
    found += [none.sort(-1).values, torch.cat((x[:0], x[:0])), x]
    return torch.cat([each.to(x.dtype).flatten() for each in found])


def of_one_number(x: Tensor) -> Tensor:
    """Of a tensor without dimensions."""
    zero = torch.tensor(0)
    found = [*x[0].sort(), x[0].cumsum(0), x[0].sum(0), x[0].gather(0, zero), x[0].argmax()]
    found += [x[0].scatter(0, zero, x[1])]
    return torch.stack([each.to(x.dtype).reshape(()) for each in found])


def of_truth_values(x: Tensor) -> Tensor:
    """True and true is true, not 2."""
    is_positive, is_large = x > 0, x > 1
    both = (is_positive + is_large).to(x.dtype)
    changed = is_positive.clone()
    changed += is_large
    return torch.cat((both, changed.to(x.dtype), (is_positive + True).to(x.dtype)))


def signs_of_zero(x: Tensor) -> Tensor:
    """Minus zero turns an angle of π into one of −π; what is added to it is not zero."""
    angles = torch.atan2(torch.stack((x, x - 0.0, -x, 0.0 * x)), torch.tensor(-1.0))
    return torch.cat((angles.flatten(), x.abs() ** -0.5, 1 / (0.0 * x)))


def singular(x: Tensor) -> Tensor:
    """Factors of a matrix with a column of zeros, which pivot is zero, and what is made of it."""
    matrix = x[:9].reshape(3, 3) * torch.tensor([1.0, 0.0, 1.0], dtype=x.dtype)
    factors = torch.linalg.lu_factor_ex(matrix)
    solved = torch.linalg.solve_ex(x[:9].reshape(3, 3), x[9:])
    kept = torch.where(solved.info == 0, solved.result, 7.0)
    which = torch.stack((factors.info, solved.info)).to(x.dtype)
    return torch.cat((factors.LU.flatten(), which, kept))


def solved_for_many(x: Tensor) -> Tensor:
    """One matrix, and a batch of right-hand sides."""
    return torch.linalg.solve_ex(x[:4].reshape(2, 2), x[4:].reshape(2, 2, 2)).result.flatten()


def written_beside(x: Tensor) -> Tensor:
    """What torch copies does not change with what it was copied from, nor the other way round."""
    first = x.clone()
    turned = first.flip(0)
    turned[0] = 9.0
    first[1] = 8.0
    return torch.cat((first, turned))


def written_through(x: Tensor) -> Tensor:
    """Views of results that do not lie in storage as they are read, a diagonal, unsqueeze_()."""
    taken = x.reshape(3, 4).index_select(1, x[:4].argsort())
    taken.view(-1)[0] = 9.0
    square = x[:9].reshape(3, 3).clone()
    square.diagonal().add_(3.0)
    part = square[1:]
    part.unsqueeze_(0)[0, 0] = 1.0
    same = x.clone().expand(SIZE)
    same[0] = 2.0
    return torch.cat((taken.flatten(), square.flatten(), same))


def scattered(x: Tensor) -> Tensor:
    """From a source that is larger than the index."""
    grid = x.reshape(3, 4)
    index = grid[:2].argmax(1, keepdim=True)
    return torch.cat((grid.scatter(1, index, 2 * grid), grid.scatter_add(1, index, grid))).flatten()


def beside_infinity(x: Tensor) -> Tensor:
    """So many constants that they are a table, some of them infinite."""
    return x.unsqueeze(-1) * x.square()[:1] + FAR.to(x.dtype)


def rounded_down(x: Tensor) -> Tensor:
    """By infinity, a number of the other sign is −1 times; by nothing it is infinite."""
    return torch.cat((x // torch.inf, x // -torch.inf, x // 0.0, x // x.flip(0)))


def of_large_integers(x: Tensor) -> Tensor:
    """Of those between real numbers, too: only what is left of each is looked at as one."""
    places, large = x.argsort(), 2**53 + 1
    numbers = places * large
    about = torch.stack((numbers.abs(), numbers.maximum(places), -numbers.neg().minimum(places)))
    found = [about - places * 2**53, (-numbers).remainder(7), numbers // 3 - places * (large // 3)]
    found += [-numbers // places.clamp(min=1), places**35 % 1000]
    return torch.cat([each.flatten() % 1000 for each in found]).to(x.dtype)


FUNCTIONS = [
    *(of_nothing, of_one_number, of_truth_values, signs_of_zero, singular, solved_for_many),
    *(written_beside, written_through, scattered, beside_infinity),
    *(rounded_down, of_large_integers),
]


@pytest.mark.parametrize("function", FUNCTIONS)
def test_it_computes_what_torch_computes(function: Function, tmp_path: Path) -> None:
    run = translated(function, torch.float64, tmp_path)
    special = torch.tensor(SPECIAL, dtype=torch.float64)
    for x in (normal(SIZE, seed=1), special, special.flip(0), torch.zeros_like(special)):
        expected = function(x).flatten()
        torch.testing.assert_close(run(x), expected, rtol=1e-12, atol=1e-12, equal_nan=True)
