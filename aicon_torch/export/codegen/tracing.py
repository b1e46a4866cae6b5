"""Functions of flat tensors, traced and translated to C."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any

import torch
from torch import Tensor
from torch._decomp import core_aten_decompositions, get_decompositions

from aicon_torch.export.codegen.arrays import Writer, as_array
from aicon_torch.export.codegen.c_source import function, repeated_function
from aicon_torch.export.codegen.operations import noted
from aicon_torch.export.codegen.scalars import Program
from aicon_torch.export.codegen.translation import translate

ATEN = torch.ops.aten

LAYERS = (
    *(ATEN.gelu, ATEN.elu, ATEN.leaky_relu, ATEN.hardtanh, ATEN._log_softmax),
    *(ATEN.native_layer_norm, ATEN.native_batch_norm),
)
"""Layers of networks that torch keeps whole, and that are taken apart here."""

FlatFunction = Callable[..., tuple[Tensor, ...]]
"""A function of flat tensors that returns others."""


def in_c(
    name: str,
    traced: FlatFunction,
    inputs: Sequence[str],
    outputs: Sequence[str],
    examples: Mapping[str, Tensor],
    varying: Collection[str] = (),
) -> str:
    """A function of flat tensors, in C.

    Args:
        name: Its name there.
        traced: The function. It must not branch on values of tensors.
        inputs: The names of its inputs.
        outputs: The names of its outputs.
        examples: A tensor for every input.
        varying: Of a function that is called many times, the inputs that differ from call to call:
            what depends on the others alone becomes a function of its own, to be called once.
    """
    # Copies: tensors are told apart by identity, and nothing is to change the examples.
    given = [examples[input].clone() for input in inputs]

    # What is noted lies below autograd, so that gradients are operations too.
    operations, returned = noted(traced, given, _decompositions())

    # Every input element is a number, and so is everything that comes of it.
    program = Program(given[0].dtype)
    numbers = []
    for input, example in zip(inputs, given, strict=True):
        elements = [program.input(input, place) for place in range(example.numel())]
        numbers.append((example, as_array(elements, tuple(example.shape))))

    writer = Writer(program)
    results = translate(operations.needed_for(returned), writer, numbers, returned)

    # Outputs are flat arrays of real numbers; truth values and indices become 0, 1, 2, ...
    real = [writer.cast(result, "real") for result in results]
    named = dict(zip(outputs, real, strict=True))
    if varying:
        return repeated_function(name, program, inputs, named, varying)
    return function(name, program, inputs, named)


@cache  # torch takes a quarter of a second to list its own
def _decompositions() -> dict[Any, Callable[..., Any]]:
    """What operators are taken apart into, before they are translated."""
    found: dict[Any, Callable[..., Any]] = {
        **core_aten_decompositions(),
        **get_decompositions(LAYERS),
        ATEN.nan_to_num.default: _without_nan,
        ATEN.lerp.Scalar: _mixed,
    }
    if _keeps_factors_of_transpose():
        found[ATEN._linalg_solve_ex.default] = _solve_with_factors
    return found


# What torch takes these two apart into as well, for which it would load its compiler.


def _without_nan(values: Tensor, *replacements: float | None) -> Tensor:
    """``nan_to_num``."""
    if not values.is_floating_point():
        return values.clone()
    nan, largest, smallest = (*replacements, None, None, None)[:3]

    # What torch puts in their place by default: 0, and the limits of the precision.
    limits = torch.finfo(values.dtype)
    found = torch.where(values.isnan(), 0.0 if nan is None else nan, values)
    found = torch.where(values == -math.inf, limits.min if smallest is None else smallest, found)
    return torch.where(values == math.inf, limits.max if largest is None else largest, found)


def _mixed(start: Tensor, end: Tensor, weight: float) -> Tensor:
    """``lerp``, from the nearer end."""
    if abs(weight) < 0.5:
        return weight * (end - start) + start
    return (weight - 1) * (end - start) + end


def _keeps_factors_of_transpose() -> bool:
    """Whether torch solves A X = B by factors of Aᵀ, as older ones do where A is contiguous.

    The derivative of the solution goes by the same factors, and says whose they are.
    """
    matrix = torch.tensor([[1.0, 2.0], [3.0, 5.0]])
    factors = ATEN._linalg_solve_ex(matrix, matrix[0])[1]
    return not torch.equal(factors, torch.linalg.lu_factor_ex(matrix).LU)


def _solve_with_factors(
    matrix: Tensor, right: Tensor, *, left: bool = True, check_errors: bool = False
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """X of A X = B, the factors by which older torch takes its derivative, and 0 for success."""
    # LAPACK counts by columns: to it, a contiguous A is Aᵀ, and so older torch factorizes that.
    is_turned = matrix.is_contiguous()
    factors, rows, success = ATEN.linalg_lu_factor_ex(matrix.mT if is_turned else matrix)

    # One vector for each A: a right-hand side of n numbers, or of all dimensions of A but the last.
    is_vector = right.ndim == 1 or right.shape == matrix.shape[:-1]
    columns = right.unsqueeze(-1) if is_vector else right
    found = ATEN.linalg_lu_solve(factors, rows, columns, left=left, adjoint=is_turned)
    return found.squeeze(-1) if is_vector else found, factors, rows, success
