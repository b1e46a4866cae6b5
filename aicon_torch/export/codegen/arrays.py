"""Arrays of a program's numbers: what a tensor is while it is translated."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.export.codegen.grids import (
    COLUMN,
    PLACE,
    Grid,
    equally_spaced,
    index,
)
from aicon_torch.export.codegen.scalars import (
    CONSTANT,
    LOOP,
    Kind,
    Number,
    Program,
    array_and_place,
)

Array = NDArray[Any]
"""The numbers of a tensor, in its shape."""

LOOPED = 256
"""Numbers from which on an operation on those of one array is a loop."""

MANY = 1024
"""Numbers from which on an operation on those of no array is one as well."""

OFTEN = 8
"""How often numbers that are in no array are read in a loop, if they are."""

MOST_SLICES = 4
"""So many arrays that are stacked, as the coordinates of points are, are looped over one by one."""

REDUCED = ("add", "maximum")
"""Operations along all of an array that are a loop as well."""

COUNTED = ("or", "and")
"""Operations on truth values along all of an array that come to how many are true."""

OF_NOTHING = {
    **{"add": 0, "mul": 1, "or": False, "and": True},
    **{"maximum": -math.inf, "minimum": math.inf},
}
"""What operations along no numbers at all come to."""

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

        # A bare number is of the kind that is asked for, or of its own.
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
        if values.size and values.flat[0].kind != kind:
            looped = self._looped(f"to_{kind}", kind, [values])
            if looped is not None:
                return looped
        return self._each(lambda value: self.program.cast(value, kind), values)

    def map(self, operation: str, kind: Kind, *values: Any) -> Array:
        """An elementary operation on each element, with broadcasting."""
        arrays = [self.array(value) for value in values]
        if operation in COMPARISONS:  # of the same kind, though the result is another
            arrays = self._of_one_kind(arrays)
        elif operation == "where":
            # The condition is a truth value; what is chosen from is of the kind of the result.
            arrays = [self.cast(arrays[0], "bool"), *(self.cast(a, kind) for a in arrays[1:])]
        elif not operation.startswith("to_"):
            arrays = [self.cast(array, kind) for array in arrays]

        looped = self._looped(operation, kind, arrays)
        if looped is not None:
            return looped
        return self._each(lambda *numbers: self.program.apply(operation, numbers, kind), *arrays)

    def _looped(self, operation: str, kind: Kind, arrays: Sequence[Array]) -> Array | None:
        """The operation as a loop, or one for each slice of what is stacked; None where neither."""
        looped = self._one_loop(operation, kind, arrays)
        shape = np.broadcast_shapes(*[array.shape for array in arrays])
        if looped is not None or not shape or not 1 < shape[-1] <= MOST_SLICES:
            return looped

        whole = [np.broadcast_to(array, shape) for array in arrays]
        slices: list[Array] = []
        for place in range(shape[-1]):
            looped = self._one_loop(operation, kind, [array[..., place] for array in whole])
            if looped is None:
                return None
            slices.append(looped)
        return np.stack(slices, axis=-1)

    def _one_loop(self, operation: str, kind: Kind, arrays: Sequence[Array]) -> Array | None:
        """The operation as a loop over arrays of many numbers; None where they are not."""
        shape = np.broadcast_shapes(*[array.shape for array in arrays])
        count = int(np.prod(shape))

        # Few numbers are written out. Indices are too: loops are of real numbers and truth values.
        if count < LOOPED or kind == "int":
            return None

        # For each argument what the loop reads: one number for all, an array, a table of constants,
        # or a few numbers again and again.
        grid = Grid.of(shape)
        is_along = reads_array = False  # whether it reads by row or column, and an array
        arguments: list[Number] = []
        places: list[str] = []
        for array in arrays:
            numbers = list(np.broadcast_to(array, shape).reshape(-1))
            if numbers[0].kind == "int":
                return None
            if all(number is numbers[0] for number in numbers):
                arguments.append(numbers[0])
                places.append("{}")
                continue

            few, place = grid.reduced(numbers)
            is_along = is_along or place != PLACE
            is_often = len(few) * OFTEN <= count
            if all(number.operation == CONSTANT for number in numbers):
                table = self.program.table([number.value for number in few])
                places.append(f"{table}[{place}]")
            elif (found := self._in_one_array(few, place, is_often)) is not None:
                reads_array = True
                arguments.append(found[0])
                places.append(found[1])
            elif place != PLACE and is_often:
                arguments.append(self.program.list(few))
                places.append(f"{{}}[{place}]")
            else:
                known = {number: number_of for number_of, number in enumerate(dict.fromkeys(few))}
                if len(known) * OFTEN > count:
                    return None
                table = self.program.table([known[number] for number in few])
                arguments.append(self.program.list(list(known)))
                places.append(f"{{}}[{table}[{place}]]")

        # What reads no row and no column goes with the array that it reads.
        if not is_along:
            grid = _grid_of(arguments, places, count)

        # Without an array it is written out, unless it is another number nearly everywhere.
        if not reads_array:
            columns = [np.broadcast_to(array, shape).reshape(-1) for array in arrays]
            distinct = len(set(zip(*columns, strict=True)))
            if count < MANY or len(arguments) < len(arrays) or 2 * distinct < count:
                return None
        return as_array(self.program.loop(operation, arguments, places, kind, grid), shape)

    def reduce(
        self, operation: str, kind: Kind, values: Array, dims: Sequence[int], keeps: bool
    ) -> Array:
        """An operation of two arguments along dimensions, from the first element to the last."""
        # The dimensions to reduce go last, as one.
        dims = [dim % values.ndim for dim in dims] if values.ndim else []
        last = np.moveaxis(values, dims, range(-len(dims), 0)) if dims else values[..., None]
        kept = last.shape[: last.ndim - max(len(dims), 1)]
        length = math.prod(last.shape[len(kept) :])
        rows = last.reshape(*kept, length)

        # Many numbers are reduced by a routine in C, ...
        are_slices = length <= MOST_SLICES and rows.size >= length * LOOPED
        is_long = rows.size >= LOOPED and not are_slices
        reduced = self._reduced(operation, kind, rows) if is_long else None
        if reduced is not None:
            return np.expand_dims(reduced, tuple(dims)) if keeps else reduced

        # ... and few are written out, or looped over as slices, one after the other.
        result = self.full(kept, OF_NOTHING[operation], kind) if length == 0 else rows[..., 0]
        result = self.cast(result, kind)
        for place in range(1, length):
            result = self.map(operation, kind, result, rows[..., place])
        return np.expand_dims(result, tuple(dims)) if keeps else result

    def _reduced(self, operation: str, kind: Kind, rows: Array) -> Array | None:
        """Each row reduced by a loop; None where there is no array of the rows, or no such loop."""
        # Whether any are true, or all of them, is how many are.
        if operation in COUNTED and self._in_one_array(list(rows.reshape(-1))) is not None:
            ones = self.cast(self.cast(rows, "bool"), "real")
            true = self.reduce("add", "real", ones, [-1], False)
            enough = 1.0 if operation == "or" else float(rows.shape[-1])
            return self.map("ge", "bool", true, enough)
        if operation not in REDUCED or kind != "real":
            return None

        source = self.whole(list(rows.reshape(-1)))
        if source is None:
            return None
        count = rows.size // rows.shape[-1]
        sizes = (rows.shape[-1], count, count)
        call = self.program.call(f"{operation}_rows", [source], sizes)
        items = [self.program.item(call, place) for place in range(count)]
        return as_array(items, rows.shape[:-1])

    def whole(self, numbers: Sequence[Number]) -> Number | None:
        """An array that begins with some real numbers; None where they are not in one."""
        found = self._in_one_array(numbers)
        if found is None or numbers[0].kind != "real":
            return None
        array, place = found

        # An array that is read from its beginning is given as it is; any other stretch is copied.
        if place == f"{{}}[{PLACE}]":
            return array
        copy = self.program.loop("to_real", [array], [place], "real", Grid(len(numbers), 1))

        # Each item of a loop has the loop as its argument, and that is the array.
        return copy[0].arguments[0]

    def _in_one_array(
        self, numbers: Sequence[Number], place: str = PLACE, is_often: bool = False
    ) -> tuple[Number, str] | None:
        """The array that some numbers are in, and what of it is the one at a place, in C.

        Args:
            numbers: The numbers.
            place: What the place of one of them is called.
            is_often: Whether they are read so often that they are better copied than not in a row.
        """
        start = array_and_place(numbers[0])
        if start is None:
            return None
        array, _ = start
        places: list[int] = []
        for number in numbers:
            found = array_and_place(number)
            if found is None or found[0] != array:
                return None
            places.append(found[1])

        # Those at equal distances are found by the first one, others by a table of their places.
        spaced = equally_spaced(places)
        if spaced is None:
            text = f"{self.program.table(places)}[{place}]"
        else:
            text = index(place, *spaced)
        if place == COLUMN and is_often and (spaced is None or spaced[1] > 1):
            return self.program.list(numbers), f"{{}}[{place}]"
        return self.program.array(array), f"{{}}[{text}]"

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
        array = self.whole(candidates) if len(candidates) >= LOOPED else None
        return self.program.pick(index, candidates, array)

    def is_at(self, index: Number, place: int) -> Number:
        """Whether an index is this place."""
        return self.program.apply("eq", (index, self.program.constant(place, "int")), "bool")

    def _of_one_kind(self, arrays: list[Array]) -> list[Array]:
        """Arrays of the kind that holds them all."""
        kinds: set[Kind] = {array.flat[0].kind for array in arrays if array.size}
        widest: Kind = "real" if "real" in kinds else "int"
        return [self.cast(array, widest) for array in arrays]

    def _each(self, function: Callable[..., Number], *arrays: Array) -> Array:
        with np.errstate(all="ignore"):  # of constants it computes, and may find NaN
            result = np.frompyfunc(function, len(arrays), 1)(*arrays)

        # Of arrays without dimensions numpy makes a bare number.
        if not isinstance(result, np.ndarray):
            return as_array([result], ())

        # Noted in its shape: the rows of a batch are looked for among these.
        self.program.arrays.append(result)
        return result


def _grid_of(arguments: Sequence[Number], places: Sequence[str], count: int) -> Grid:
    """The grid of the first loop, as long, that a loop reads place by place; else places only."""
    reads = zip(arguments, [place for place in places if "{}" in place], strict=True)
    for argument, place in reads:
        if argument.operation == LOOP and argument.length == count and place == f"{{}}[{PLACE}]":
            grid: Grid = argument.value.grid
            return grid
    return Grid(count, 1)


def as_array(numbers: Sequence[Number], shape: tuple[int, ...]) -> Array:
    """An array of some numbers."""
    array = np.empty(len(numbers), dtype=object)
    array[:] = numbers
    return array.reshape(shape)


def kind_of(dtype: torch.dtype) -> Kind:
    """The kind of a tensor's elements."""
    if dtype == torch.bool:
        return "bool"
    if dtype.is_complex:
        raise GraphError(f"A tensor of {dtype} cannot be exported: expected real numbers.")
    return "real" if dtype.is_floating_point else "int"
