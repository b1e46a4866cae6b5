"""From a traced graph of tensor operations to a program of numbers."""

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from inspect import Signature, signature
from typing import Any

import numpy as np
import torch
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.export.codegen.arrays import Array, Writer, kind_of
from aicon_torch.export.codegen.creation import CREATION
from aicon_torch.export.codegen.indexing import INDEXING
from aicon_torch.export.codegen.networks import NETWORKS
from aicon_torch.export.codegen.operations import Operation
from aicon_torch.export.codegen.operators import ELEMENTWISE, Translation
from aicon_torch.export.codegen.programmes import PROGRAMMES
from aicon_torch.export.codegen.scalars import CONSTANT, Kind, Program
from aicon_torch.export.codegen.selection import SELECTION
from aicon_torch.export.codegen.solving import SOLVING

TRANSLATIONS: dict[str, Translation] = {
    **ELEMENTWISE,
    **INDEXING,
    **SELECTION,
    **SOLVING,
    **PROGRAMMES,
    **CREATION,
    **NETWORKS,
}
"""The translation of each operator, by its name without the overload, and without ``aten::``."""


def translate(
    operations: Iterable[Operation],
    writer: Writer,
    inputs: Iterable[tuple[Tensor, Array]],
    outputs: Sequence[Tensor],
) -> list[Array]:
    """Write what operations do into a program.

    Args:
        operations: Operations on tensors, in order.
        writer: Writes into the program.
        inputs: The tensors that the first operations were given, and the numbers of each; any other
            tensor is a constant.
        outputs: The tensors that are wanted.

    Returns:
        The numbers of each output.

    Raises:
        GraphError: If there is no translation of an operation.
    """
    known: dict[int, Any] = {id(tensor): numbers for tensor, numbers in inputs}

    def numbers_of(tensor: Tensor) -> Any:
        # A tensor that was there before the function ran, such as a parameter, is a constant.
        if id(tensor) not in known:
            known[id(tensor)] = writer.array(tensor)
            known[id(tensor)].flags.writeable = False
        if isinstance(known[id(tensor)], Operation):
            raise _refused(known[id(tensor)], "what is read of it has no translation to C")
        return known[id(tensor)]

    # Tensors are told apart by identity: the operations were recorded while all of them lived.
    for operation in operations:
        arguments = [_replaced(value, numbers_of) for value in operation.args]
        named = {key: _replaced(value, numbers_of) for key, value in operation.kwargs.items()}
        found = _apply(operation, writer, arguments, named)
        if isinstance(operation.result, Tensor):
            found = (found,)

        # What is no view shares its numbers with nothing, and views of it are as torch's are.
        is_view = any(declared.alias_info for declared in operation.operator._schema.returns)
        for tensor, numbers in zip(operation.returned, found, strict=False):
            if numbers is None:
                known[id(tensor)] = operation  # of which nobody may ask for this
                continue
            _check_type(operation, tensor, numbers, writer.program)
            known[id(tensor)] = numbers if is_view else _stored_alike(tensor, numbers)
    return [writer.array(numbers_of(output)) for output in outputs]


def _stored_alike(tensor: Tensor, numbers: Array) -> Array:
    """A copy of numbers whose dimensions lie in storage in the order of a tensor's."""
    if tensor.shape != numbers.shape:  # unsqueeze_() or the like has changed the tensor since
        return numbers.copy()
    order = sorted(range(tensor.ndim), key=tensor.stride, reverse=True)
    stored = np.empty([tensor.shape[dim] for dim in order], dtype=object)
    copied: Array = stored.transpose(np.argsort(order))
    copied[...] = numbers
    return copied


def _replaced(value: Any, numbers_of: Callable[[Tensor], Any]) -> Any:
    """An argument with the numbers of tensors instead of tensors, also in a list."""
    if isinstance(value, Tensor):
        return numbers_of(value)
    if isinstance(value, list | tuple):
        return [_replaced(each, numbers_of) for each in value]
    return value


def _apply(operation: Operation, writer: Writer, args: Any, kwargs: Any) -> Any:
    """What one operation makes of its arguments."""
    name = _name_of(operation)

    # `add_` has no translation of its own: it is `add`, written into its first argument.
    changes_in_place = name.endswith("_")
    translation = TRANSLATIONS.get(name.removesuffix("_") if changes_in_place else name)
    if translation is None:
        raise _refused(operation, "it has no translation to C")
    if changes_in_place and not args[0].flags.writeable:
        raise _refused(operation, "it changes a tensor that was there before the step")
    if operation.operator._schema.is_mutable and not changes_in_place:
        raise _refused(operation, "it writes into a tensor that is given as out=...")

    try:
        _signature(translation).bind(writer, _kind(operation), *args, **kwargs)
    except TypeError as error:  # an argument that its translation does not know
        raise _refused(operation, str(error)) from error
    try:
        result = translation(writer, _kind(operation), *args, **kwargs)
    except NotImplementedError as error:
        raise GraphError(f"{_what(operation)} cannot be exported {error}.") from error

    # Slices of this array share its numbers, and see the change as views of a tensor do.
    if changes_in_place and torch.Tag.inplace_view not in operation.operator.tags:
        args[0][...] = result
        return args[0]
    return result


@cache
def _signature(translation: Translation) -> Signature:
    """What a translation takes, looked at once."""
    return signature(translation)


def _check_type(operation: Operation, tensor: Tensor, numbers: Array, program: Program) -> None:
    """Check that numbers of a result's type are computed in C as they are in torch."""
    # The precision of the program, or a lower one, and integers of 64 bits; places are any integer.
    moves_only = tensor.dtype == torch.int32 and _name_of(operation) not in ELEMENTWISE
    if moves_only or tensor.dtype in (torch.bool, torch.int64, torch.float32, program.dtype):
        return
    if any(number.operation != CONSTANT for number in numbers.reshape(-1)):
        raise _refused(
            operation,
            f"it computes in {tensor.dtype}, and in C there are {program.dtype}, torch.int64 and "
            "torch.bool",
        )


def _name_of(operation: Operation) -> str:
    """``add`` of ``aten::add.Tensor``."""
    return str(operation.operator._schema.name).removeprefix("aten::")


def _kind(operation: Operation) -> Kind:
    """The kind of the (first) result."""
    return kind_of(next(operation.returned).dtype)


def _what(operation: Operation) -> str:
    """The operation and the size of its result, for an error."""
    result = operation.result
    shape = f" of shape {tuple(result.shape)}" if isinstance(result, Tensor) else ""
    return f"The operation {_name_of(operation)!r}{shape}"


def _refused(operation: Operation, reason: str) -> GraphError:
    """The error that an operation cannot be exported."""
    return GraphError(f"{_what(operation)} cannot be exported: {reason}.")
