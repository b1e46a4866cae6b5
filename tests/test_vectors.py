"""Small vector operations."""

import pytest
import torch
from _inputs import BATCHES, DTYPES, normal

from aicon_torch.vectors import reject, select, unit


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_units_have_length_one_and_the_direction(
    batch: tuple[int, ...], dtype: torch.dtype
) -> None:
    for scale in (1e-15, 1.0, 1e15):
        vectors = scale * normal(*batch, 3, dtype=dtype)

        torch.testing.assert_close(unit(vectors).norm(dim=-1), torch.ones(batch, dtype=dtype))
        torch.testing.assert_close(unit(vectors) * vectors.norm(dim=-1, keepdim=True), vectors)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("length", [0.0, 1e-320, 1e-200, 1e-160, 1e-44, 1e-30, 1e-20])
def test_no_vector_becomes_longer_than_one(length: float, dtype: torch.dtype) -> None:
    directions = torch.tensor([[3.0, 4.0], [-1.0, 0.0]], dtype=torch.float64)
    vectors = (length * directions).to(dtype)

    assert (unit(vectors).norm(dim=-1) <= 1.0 + 1e-6).all()
    assert (unit(vectors) * vectors >= 0).all()


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_what_is_left_is_orthogonal(batch: tuple[int, ...]) -> None:
    vectors, direction = normal(*batch, 3), unit(normal(*batch, 3, seed=1))
    left = reject(vectors, direction)

    none = torch.zeros(batch, dtype=torch.float64)
    torch.testing.assert_close((left * direction).sum(-1), none, rtol=0, atol=1e-12)
    torch.testing.assert_close(reject(left, direction), left)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_row_is_selected_in_each_stack(batch: tuple[int, ...]) -> None:
    stack = normal(*batch, 4, 3)
    index = torch.randint(0, 4, (*batch, 1), generator=torch.Generator().manual_seed(0))

    selected = select(stack, index).reshape(-1, 3)
    stacks, indices = stack.reshape(-1, 4, 3), index.flatten()
    for row, (rows, i) in enumerate(zip(stacks, indices, strict=True)):
        assert torch.equal(selected[row], rows[i])
