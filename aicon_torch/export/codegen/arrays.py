"""Arrays of a program's numbers: what a tensor is while it is translated."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.export.codegen.scalars import CONSTANT, Kind, Number, Program, whole_array

Array = NDArray[Any]
"""The numbers of a tensor, in its shape."""

LOOPED = 256
"""Numbers from which on an operation on the results of a routine is a loop."""

REDUCED = ("add", "maximum")
"""Operations along all of an array that are a loop as well."""

COMPARISONS = ("eq", "ne", "lt", "le", "gt", "ge")


class Writer:
    """Writes operations on arrays into a program, element by element.

    Args:
        program: The program.
    """

    def __init__(self, program: Program) -> None:
        self.program = program

    def array(self, value: Any, kind: Kind | None = None) -> Array:
        """An array of what is one already, of a tensor's constants, or of a number."""
        if isinstance(value, np.ndarray):
            return value if kind is None else self.cast(value, kind)
        if isinstance(value, Tensor):
            own = kind_of(value.dtype)
            numbers = [self.program.constant(x, own) for x in value.flatten().tolist()]
            return self.array(as_array(numbers, tuple(value.shape)), kind)

        is_real = isinstance(value, float)
        own = "bool" if isinstance(value, bool) else "real" if is_real else "int"
        return as_array([self.program.constant(value, kind or own)], ())

    def full(self, shape: Sequence[int], value: float, kind: Kind) -> Array:
        """The same constant everywhere."""
        filled = np.empty(tuple(shape), dtype=object)
        filled[...] = self.program.constant(value, kind)
        return filled

    def cast(self, values: Array, kind: Kind) -> Array:
        """The values as another kind."""
        return self._each(lambda value: self.program.cast(value, kind), values)

    def map(self, operation: str, kind: Kind, *values: Any) -> Array:
        """An elementary operation on each element, with broadcasting."""
        arrays = [self.array(value) for value in values]
        if operation in COMPARISONS:  # of the same kind, though the result is another
            arrays = self._of_one_kind(arrays)
        elif operation == "where":
            arrays = [self.cast(arrays[0], "bool"), *(self.cast(a, kind) for a in arrays[1:])]
        elif not operation.startswith("to_"):
            arrays = [self.cast(array, kind) for array in arrays]
        looped = self._looped(operation, kind, arrays)
        if looped is not None:
            return looped
        return self._each(lambda *numbers: self.program.apply(operation, numbers, kind), *arrays)

    def _looped(self, operation: str, kind: Kind, arrays: Sequence[Array]) -> Array | None:
        """The operation as a loop over arrays of many numbers; None where they are not."""
        shape = np.broadcast_shapes(*[array.shape for array in arrays])
        count = int(np.prod(shape))
        if count < LOOPED or (kind != "real" and operation not in COMPARISONS):
            return None

        # For each argument what the loop reads: one number for all, an array, or a table of
        # constants.
        arguments: list[Number] = []
        places: list[str] = []
        for index, array in enumerate(arrays):
            numbers = list(np.broadcast_to(array, shape).reshape(-1))
            is_condition = operation == "where" and index == 0
            if numbers[0].kind != ("bool" if is_condition else "real"):
                return None
            source = whole_array(numbers)
            if all(number is numbers[0] for number in numbers):
                arguments.append(numbers[0])
                places.append("{}")
            elif source is not None:
                arguments.append(source)
                places.append("{}[i]")
            elif all(number.operation == CONSTANT for number in numbers):
                places.append(f"{self.program.table([n.value for n in numbers])}[i]")
            else:
                return None

        # Without an array there is nothing to loop over.
        if "{}[i]" not in places:
            return None
        return as_array(self.program.loop(operation, arguments, places, kind, count), shape)

    def reduce(
        self, operation: str, kind: Kind, values: Array, dims: Sequence[int], keeps: bool
    ) -> Array:
        """An operation of two arguments along dimensions, from the first element to the last."""
        # The dimensions to reduce go last, as one.
        dims = [dim % values.ndim for dim in dims] if values.ndim else []
        last = np.moveaxis(values, dims, range(-len(dims), 0)) if dims else values[..., None]
        kept = last.shape[: last.ndim - max(len(dims), 1)]
        rows = last.reshape(*kept, -1)

        # Many numbers are reduced by a loop of C, ...
        if operation in REDUCED and rows.size >= LOOPED and kind == "real":
            source = whole_array(list(rows.reshape(-1)))
            if source is not None and source.kind == "real":
                count = rows.size // rows.shape[-1]
                sizes = (rows.shape[-1], count, count)
                call = self.program.call(f"{operation}_rows", [source], sizes)
                items = [self.program.item(call, place) for place in range(count)]
                reduced = as_array(items, kept)
                return np.expand_dims(reduced, tuple(dims)) if keeps else reduced

        # ... and few are written out one by one.
        result = self.cast(rows[..., 0], kind)
        for place in range(1, rows.shape[-1]):
            result = self.map(operation, kind, result, rows[..., place])
        return np.expand_dims(result, tuple(dims)) if keeps else result

    def pick(self, candidates: Sequence[Number], index: Number) -> Number:
        """The candidate at an index, which may be known when the program runs only."""
        if index.operation == CONSTANT:
            place: int = index.value
            return candidates[place]

        # Of two, a choice; of more, an array is shorter than as many choices.
        if len(candidates) <= 2:
            other = candidates[-1]
            arguments = (self.is_at(index, len(candidates) - 1), other, candidates[0])
            return self.program.apply("where", arguments, other.kind)
        if all(candidate is candidates[0] for candidate in candidates):
            return candidates[0]
        return self.program.pick(index, candidates)

    def is_at(self, index: Number, place: int) -> Number:
        """Whether an index is this place."""
        return self.program.apply("eq", (index, self.program.constant(place, "int")), "bool")

    def _of_one_kind(self, arrays: list[Array]) -> list[Array]:
        """Arrays of the kind that holds them all."""
        kinds: set[Kind] = {array.flat[0].kind for array in arrays if array.size}
        widest: Kind = "real" if "real" in kinds else "int"
        return [self.cast(array, widest) for array in arrays]

    def _each(self, function: Callable[..., Number], *arrays: Array) -> Array:
        result = np.frompyfunc(function, len(arrays), 1)(*arrays)
        if not isinstance(result, np.ndarray):
            return as_array([result], ())
        self.program.arrays.append(result)
        return result


def as_array(numbers: Sequence[Number], shape: tuple[int, ...]) -> Array:
    """An array of some numbers."""
    array = np.empty(len(numbers), dtype=object)
    array[:] = numbers
    return array.reshape(shape)


def kind_of(dtype: torch.dtype) -> Kind:
    """The kind of a tensor's elements."""
    if dtype == torch.bool:
        return "bool"
    return "real" if dtype.is_floating_point else "int"
