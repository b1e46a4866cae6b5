"""The operations that run while a function does are noted below autograd, those that matter."""

import pytest
import torch
from torch import Tensor

from aicon_torch.export.codegen.operations import Operations


def noted(function, *inputs: Tensor) -> list[str]:
    """The names of the operations that what a function returns needs."""
    operations = Operations(inputs, {})
    with operations:
        result = function(*inputs)
    return [str(operation.operator) for operation in operations.needed_for([result])]


def test_those_of_a_gradient_are_among_them() -> None:
    def slope(x: Tensor) -> Tensor:
        leaf = x.detach().requires_grad_()
        return torch.autograd.grad(leaf.sin(), leaf, torch.ones(3))[0]

    names = noted(slope, torch.ones(3))
    assert "aten.cos.default" in names and "aten.mul.Tensor" in names
    assert "aten.sin.default" not in names  # of the value itself nothing is needed


def test_what_nothing_needs_is_left_out_unless_it_changes_something() -> None:
    def half_in_vain(x: Tensor) -> Tensor:
        x.exp()
        found = x + 1
        found[0] = 2.0
        return found

    names = noted(half_in_vain, torch.ones(3))
    assert "aten.exp.default" not in names
    assert {"aten.add.Tensor", "aten.copy_.default"} <= set(names)


def test_operators_are_taken_apart() -> None:
    x, y = torch.ones(2), torch.ones(2)
    parts = {torch.ops.aten.addcmul.default: lambda a, b, c: a + b * c}
    operations = Operations((x, y), parts)
    with operations:
        result = torch.addcmul(x, x, y)
    kept = [str(operation.operator) for operation in operations.needed_for([result])]
    assert kept == ["aten.mul.Tensor", "aten.add.Tensor"]


def test_the_course_must_not_depend_on_an_input() -> None:
    constant = torch.tensor(2.0)
    assert noted(lambda x: x * constant.item(), torch.ones(2)) == ["aten.mul.Tensor"]
    with pytest.raises(RuntimeError, match="asks for the value of a tensor"):
        noted(lambda x: x if x.sum() > 0 else -x, torch.ones(2))
