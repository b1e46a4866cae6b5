"""Functions of flat tensors, traced and translated to C."""

import warnings
from collections.abc import Callable, Mapping, Sequence

from torch import Tensor
from torch._decomp import core_aten_decompositions
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.codegen.arrays import Writer, as_array
from aicon_torch.codegen.c_source import function
from aicon_torch.codegen.scalars import Program
from aicon_torch.codegen.translation import translate

FlatFunction = Callable[..., tuple[Tensor, ...]]
"""A function of flat tensors that returns others."""


def in_c(
    name: str,
    traced: FlatFunction,
    inputs: Sequence[str],
    outputs: Sequence[str],
    examples: Mapping[str, Tensor],
) -> str:
    """A function of flat tensors, in C.

    Args:
        name: Its name there.
        traced: The function. It must not branch on values of tensors.
        inputs: The names of its inputs.
        outputs: The names of its outputs.
        examples: A tensor for every input.
    """

    def of_inputs(*values: Tensor) -> tuple[Tensor, ...]:
        return traced(*values)  # a function, where make_fx would take a method for one of a module

    given = [examples[input].clone() for input in inputs]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # torch on its own future
        graph = make_fx(of_inputs, dict(core_aten_decompositions()))(*given)
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
    return function(name, program, inputs, dict(zip(outputs, real, strict=True)))
