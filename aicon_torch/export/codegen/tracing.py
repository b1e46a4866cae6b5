"""Functions of flat tensors, traced and translated to C."""

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from typing import Any

import torch
from torch import Tensor
from torch._decomp import core_aten_decompositions, get_decompositions
from torch._guards import TracingContext
from torch._guards import tracing as tracing_in
from torch._subclasses.fake_tensor import FakeTensorMode
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.export.codegen.arrays import Writer, as_array
from aicon_torch.export.codegen.c_source import function, repeated_function
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

    def of_inputs(*values: Tensor) -> tuple[Tensor, ...]:
        return traced(*values)  # a function, where make_fx would take a method for one of a module

    given = [examples[input].clone() for input in inputs]
    # Shapes are noted in one mode for all; torch would make another one for each operation.
    shapes = TracingContext(FakeTensorMode(allow_fallback_kernels=True))
    with warnings.catch_warnings(), tracing_in(shapes):
        warnings.simplefilter("ignore")  # torch on its own future
        graph = make_fx(of_inputs, _decompositions())(*given)
    graph.graph.eliminate_dead_code()

    # Every input element is a number, and so is everything that comes of it.
    program = Program(given[0].dtype)
    numbers = []
    for input, example in zip(inputs, given, strict=True):
        elements = [program.input(input, place) for place in range(example.numel())]
        numbers.append(as_array(elements, tuple(example.shape)))

    writer = Writer(program)
    results = translate(graph, writer, numbers)
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
    }
    if _keeps_factors_of_transpose():
        found[ATEN._linalg_solve_ex.default] = _solve_with_factors
    return found


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
    is_turned = matrix.is_contiguous()
    factors, rows, success = ATEN.linalg_lu_factor_ex(matrix.mT if is_turned else matrix)

    is_vector = right.ndim == 1 or right.shape == matrix.shape[:-1]
    columns = right.unsqueeze(-1) if is_vector else right
    found = ATEN.linalg_lu_solve(factors, rows, columns, left=left, adjoint=is_turned)
    return found.squeeze(-1) if is_vector else found, factors, rows, success
