"""Interconnections.

Wired by names, differentiated by autograd or by given Jacobians, explicit and implicit.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import BATCHES, normal
from torch import Tensor, nn

from aicon_torch import Affine, GraphError, Interconnection
from aicon_torch.interconnections import wiring


def residual(p: Tensor, z: Tensor) -> Tensor:
    """Implicit: zero when the two agree; two components of three."""
    return torch.stack(
        (p[..., 0] * p[..., 1] - z[..., 0], torch.sin(p[..., 2]) + p[..., 0] ** 2 * z[..., 1]),
        dim=-1,
    )


def by_hand(p: Tensor, z: Tensor) -> Tensor:
    zero = torch.zeros_like(p[..., 0])
    first = torch.stack((p[..., 1], p[..., 0], zero), dim=-1)
    second = torch.stack((2 * p[..., 0] * z[..., 1], zero, torch.cos(p[..., 2])), dim=-1)
    return torch.stack((first, second), dim=-2)


class Learned(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.layer = nn.Linear(2, 2, dtype=torch.float64)

    def forward(self, x: Tensor) -> Tensor:
        out: Tensor = self.layer(x)
        return out


def test_parameter_names_are_the_wiring() -> None:
    def relation(b: Tensor, a: Tensor, scale: float = 1.0) -> Tensor:
        return a + scale * b

    assert wiring(relation) == ("b", "a")
    assert wiring(Learned()) == ("x",)
    assert Interconnection(relation).inputs == ("b", "a")
    assert (
        Interconnection(relation)({"a": torch.tensor(1.0), "b": torch.tensor(3.0), "c": 7.0}) == 4.0
    )


def test_inputs_may_have_other_names() -> None:
    def minus(x: Tensor, y: Tensor) -> Tensor:
        return x - y

    relation = Interconnection(minus, inputs=("hand", "object"))
    values = {"hand": torch.tensor([3.0]), "object": torch.tensor([1.0]), "x": torch.tensor([9.0])}
    assert relation(values) == 2.0
    assert relation.linearize(values, "object", 1)[1].item() == -1.0


def test_a_parameter_after_a_star_is_refused() -> None:
    def late(x: Tensor, *, y: Tensor) -> Tensor:
        return x + y

    with pytest.raises(GraphError, match="'y' may be given by name only"):
        Interconnection.of(late)


@pytest.mark.parametrize("function", [lambda *x: x, lambda a, **rest: a])
def test_a_variadic_parameter_names_nothing(function: Callable[..., Any]) -> None:
    with pytest.raises(GraphError, match="names no quantity"):
        Interconnection(function)


@pytest.mark.parametrize(
    ("function", "inputs"),
    [(lambda *, x: x, ["x"]), (lambda x: x, ["x", "y"]), (lambda x, y: x + y, ["x"])],
)
def test_other_names_are_as_many_as_the_parameters(
    function: Callable[..., Any], inputs: list[str]
) -> None:
    with pytest.raises(GraphError, match="expected one name for each parameter"):
        Interconnection(function, inputs=inputs)


def test_functions_that_do_not_say_what_they_take_are_wired_as_told() -> None:
    assert Interconnection(torch.sin, inputs=["x"]).inputs == ("x",)


def test_a_jacobian_by_something_unread_is_named() -> None:
    with pytest.raises(GraphError, match=r"'q'.*'p', 'z'"):
        Interconnection(residual, q=by_hand)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize(
    "relation", [Interconnection(residual), Interconnection(residual, p=by_hand)]
)
def test_jacobians_are_the_derivatives(batch: tuple[int, ...], relation: Interconnection) -> None:
    values = {"p": normal(*batch, 3, seed=1), "z": normal(*batch, 2, seed=2)}
    for differentiable in (False, True):
        value, jacobian = relation.linearize(values, "p", 2, differentiable)
        torch.testing.assert_close(value, residual(**values))
        torch.testing.assert_close(jacobian, by_hand(**values))


def test_the_jacobian_by_something_unread_is_zero() -> None:
    values = {"p": normal(4, 3), "z": normal(4, 2), "q": normal(4, 5)}
    _, jacobian = Interconnection(residual).linearize(values, "q", 2)
    assert jacobian.shape == (4, 2, 5)
    assert not jacobian.any()


@pytest.mark.parametrize("rows", [1, 2])
def test_a_differentiable_jacobian_can_be_differentiated_again(rows: int) -> None:
    """By the point itself and by everything else that the relation reads."""
    inputs = {"p": normal(2, 3, seed=1), "z": normal(2, 2, seed=2)}

    def relation(p: Tensor, z: Tensor) -> Tensor:
        return residual(p, z)[..., :rows]

    def jacobian(p: Tensor, z: Tensor) -> Tensor:
        values = {"p": p, "z": z}
        return Interconnection(relation).linearize(values, "p", rows, differentiable=True)[1]

    leaves = tuple(value.requires_grad_() for value in inputs.values())
    assert torch.autograd.gradcheck(jacobian, leaves)


def test_a_plain_jacobian_keeps_no_graph() -> None:
    values = {"p": normal(3).requires_grad_(), "z": normal(2)}
    _, jacobian = Interconnection(residual).linearize(values, "p", 2)
    assert not jacobian.requires_grad


def test_a_module_may_be_the_function() -> None:
    learned = Learned()
    relation = Interconnection(learned)
    value, jacobian = relation.linearize({"x": normal(3, 2)}, "x", 2)

    torch.testing.assert_close(value, learned(normal(3, 2)))
    torch.testing.assert_close(jacobian, learned.layer.weight.expand(3, 2, 2).detach())
    assert len(list(relation.parameters())) == 2


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_affine_is_the_sum_of_products(batch: tuple[int, ...]) -> None:
    matrix = normal(2, 3, seed=5)
    values = {
        "x": normal(*batch, 2, seed=1),
        "u": normal(*batch, 3, seed=2),
        "z": normal(*batch, 2, seed=3),
    }
    relation = Affine(x=0.5, u=matrix, z=-1.0)
    moved = torch.einsum("ij,...j->...i", matrix, values["u"])
    expected = 0.5 * values["x"] + moved - values["z"]
    torch.testing.assert_close(relation(values), expected)

    def function(x: Tensor, u: Tensor, z: Tensor) -> Tensor:
        return relation({"x": x, "u": u, "z": z})

    identity = torch.eye(2, dtype=torch.float64)
    for name, factor in (("x", 0.5 * identity), ("u", matrix), ("z", -identity)):
        value, jacobian = relation.linearize(values, name, 2)
        jacobian = jacobian.expand(*batch, 2, -1)
        torch.testing.assert_close(value, expected)
        torch.testing.assert_close(jacobian, factor.expand(*batch, 2, -1))

        _, by_autograd = Interconnection(function).linearize(values, name, 2)
        torch.testing.assert_close(by_autograd, jacobian)

    _, by_unread = relation.linearize({**values, "q": normal(*batch, 4)}, "q", 2)
    assert not by_unread.any()


def test_affine_matrices_follow_the_precision() -> None:
    relation = Affine(x=torch.tensor([[1, 2]])).to(torch.float32)
    assert relation({"x": torch.ones(2)}).dtype == torch.float32


@pytest.mark.parametrize("dt", [0.1, [[0.1], [0.3]]])
def test_a_multiple_may_be_the_time_step(dt: Any) -> None:
    dt = torch.tensor(dt, dtype=torch.float64)
    motion, start, velocity = Affine(x=1.0, a="dt"), normal(2, 3), normal(2, 3, seed=1)
    values = {"x": start, "a": velocity, "dt": dt}
    assert motion.inputs == ("x", "a", "dt")
    torch.testing.assert_close(motion(values), start + dt * velocity)
    for name in ("x", "a"):
        _, given = motion.linearize(values, name, 3)
        _, expected = motion.differentiate(values, name, 3, differentiable=False)
        torch.testing.assert_close(given.expand_as(expected), expected)


@pytest.mark.parametrize("function", [torch.add, max, int])
def test_a_function_that_does_not_say_what_it_takes_is_wired_by_names(function: Any) -> None:
    with pytest.raises(GraphError, match=r"expected Interconnection\(function, inputs="):
        Interconnection(function)


@pytest.mark.parametrize("factor", [None, [[1.0]], np.eye(2), math.nan, True], ids=str)
def test_what_is_no_factor_of_a_linear_relation_is_named(factor: Any) -> None:
    with pytest.raises(GraphError, match=r"(?s)Affine\(x=.*: expected a finite number, a matrix"):
        Affine(x=factor)
    with pytest.raises(GraphError, match=r"Affine\(\): expected"):
        Affine()
