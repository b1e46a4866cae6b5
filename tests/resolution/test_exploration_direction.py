"""Exploration: where it leads."""

import pytest
import torch
from _inputs import (
    BATCHES,
    DTYPES,
    conflict,
    direction,
    exploring_memory,
    fresh,
    lengths,
    literal,
    normal,
    pair,
    pursuit,
    resolve,
)

from aicon_torch import TrapEscape


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("size", [2, 3, 4])
def test_exploration_moves_in_the_nullspace_of_the_dominant_gradient_along_the_average(
    batch: tuple[int, ...], size: int
) -> None:
    gradients = conflict(*batch, size=size)
    memory = exploring_memory(gradients, literal(), average=normal(*batch, size, seed=7))
    total, state = resolve(literal(), gradients, memory)
    assert state["exploring"].all()

    top = direction(gradients[..., 0, :])
    none = torch.zeros(batch, dtype=torch.float64)
    torch.testing.assert_close((total * top).sum(-1), none, rtol=0, atol=1e-9)
    torch.testing.assert_close(lengths(total), torch.ones(batch, dtype=torch.float64))

    # The descent directions count a millionth.
    average = state["average"]
    free = average - (average * top).sum(-1, keepdim=True) * top
    torch.testing.assert_close(-total, direction(free), rtol=0, atol=1e-4)
    assert ((-total * average).sum(-1) >= 0).all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_motion_goes_on_in_the_direction_it_came_from(side: float) -> None:
    gradients = pair(-0.95)
    average = torch.tensor([0.3, side * 0.1], dtype=torch.float64)
    total, _ = resolve(
        literal(), gradients, exploring_memory(gradients, literal(), average=average)
    )

    expected = torch.tensor([0.0, side], dtype=torch.float64)
    torch.testing.assert_close(-total, expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("unit", [1e-4, 1.0, 1e4])
def test_the_unit_of_the_costs_does_not_choose_the_side(unit: float) -> None:
    """The descent counts a millionth beside the motion, whatever the slopes are measured in."""
    gradients = unit * pair(-0.95)
    for side in (1.0, -1.0):
        average = torch.tensor([0.0, side * 1e-3], dtype=torch.float64)
        memory = exploring_memory(gradients, literal(), average=average)
        total, _ = resolve(literal(), gradients, memory)
        assert -total[1] * side > 0


@pytest.mark.parametrize("time", [0.2, 1.0, 2.0])
@pytest.mark.parametrize("dt", [0.05, 0.5])
def test_the_average_is_an_exponential_moving_one(time: float, dt: float) -> None:
    """m ← m + (motion − m) dt/(dt + T), whether or not a conflict lasts."""
    rule, gradients = literal(average_time=time), pair(0.5)
    memory, expected = fresh(rule, gradients), torch.zeros(2, dtype=torch.float64)

    for motion in normal(6, 2):
        _, memory = resolve(rule, gradients, memory, motion=motion, dt=dt)
        expected = expected + (motion - expected) * dt / (dt + time)
        torch.testing.assert_close(memory["average"], expected)


# --- without an average


AVERAGES = {"none": 0.0, "along the dominant gradient": 0.3, "against it": -0.3}


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("size", [2, 3, 4])
@pytest.mark.parametrize("scale", AVERAGES.values(), ids=AVERAGES.keys())
@pytest.mark.parametrize("noise", [0.0, 1e-3], ids=["exactly opposed", "nearly opposed"])
def test_without_an_average_a_direction_in_the_nullspace_is_found(
    dtype: torch.dtype, size: int, scale: float, noise: float
) -> None:
    """Head on against a wall nothing breaks the symmetry.

    The motion is still a unit vector in the nullspace.
    """
    first = normal(5, size, seed=size, dtype=dtype)
    second = -0.9 * first + noise * normal(5, size, dtype=dtype)
    gradients = torch.stack((first, second), dim=-2)

    memory = exploring_memory(gradients, literal(), average=scale * first)
    total, state = resolve(literal(), gradients, memory)

    assert state["exploring"].all()
    torch.testing.assert_close(lengths(total), torch.ones(5, dtype=dtype))
    assert ((total * direction(first)).sum(-1).abs() < 1e-3).all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_without_an_average_the_descent_directions_decide(side: float) -> None:
    """A third gradient, too weak to end the conflict, says which way round."""
    gradients = torch.tensor([[1.0, 0.0], [-0.9, 0.0], [0.0, 0.2 * side]], dtype=torch.float64)
    total, _ = resolve(literal(), gradients, exploring_memory(gradients, literal()))

    expected = torch.tensor([0.0, -side], dtype=torch.float64)
    torch.testing.assert_close(-total, expected, rtol=0, atol=1e-2)


@pytest.mark.parametrize(
    "escape", [None, TrapEscape(hold="g0"), TrapEscape(hold="g1", along="g1")], ids=str
)
def test_on_a_line_there_is_nothing_to_explore(escape: TrapEscape | None) -> None:
    gradients = torch.tensor([[1.0], [-0.9]], dtype=torch.float64)
    total, state = resolve(literal(escape), gradients)

    downhill, _ = resolve(pursuit(), gradients)
    assert torch.equal(total, downhill)
    assert "exploring" not in state
