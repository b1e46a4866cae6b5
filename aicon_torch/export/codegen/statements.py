"""The statements in C that compute the numbers of a program."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain

import numpy as np
import torch

from aicon_torch.export.codegen.grids import COLUMN, PLACE, ROW, Grid
from aicon_torch.export.codegen.lanes import Lanes, in_phases, in_rows
from aicon_torch.export.codegen.networks import NETWORK_ROUTINES
from aicon_torch.export.codegen.programmes import ROUTINES as PROGRAMME_ROUTINES
from aicon_torch.export.codegen.scalars import (
    CONSTANT,
    INPUT,
    ITEM,
    LIST,
    LOOP,
    OPERATIONS,
    PICK,
    Loop,
    Number,
    Program,
)
from aicon_torch.export.codegen.selection import SELECTION_ROUTINES
from aicon_torch.export.codegen.solving import ROUTINES as SOLVING_ROUTINES

ROUTINES = {
    **SOLVING_ROUTINES,
    **PROGRAMME_ROUTINES,
    **NETWORK_ROUTINES,
    **SELECTION_ROUTINES,
}
"""The routines that a program calls, in C."""

TYPES = {"real": "real", "int": "integer", "bool": "int"}
"""The type of each kind of number in C."""


class Statements:
    """The statements of one function.

    Args:
        program: The program.
        needed: The indices of the numbers that the function computes.
        results: Those of them that are read after all is computed.
    """

    def __init__(
        self, program: Program, needed: Collection[int], results: Iterable[Number]
    ) -> None:
        self.program = program
        self.phases = in_phases(program, needed)

        # Where loops leave their numbers must be known before the first statement is written.
        self._array_of: dict[int, str] = {}  # where a loop leaves a number, by the number's index
        for phase in self.phases:
            for lanes in chain(*phase.loops.values()):
                for row, number in enumerate(lanes.numbers):
                    self._array_of[number.index] = f"{_array(lanes)}[{row}]"
        self._read = {number.index for number in self._read_outside_of_loops(results)}

    def lines(self) -> list[str]:
        """The statements, in an order in which they can be computed."""
        lines: list[str] = []
        for phase in self.phases:
            for number in phase.alone:
                # Before the loops of the same phase, which may read it.
                lines += self._statement(number, [self.text(each) for each in number.arguments])
            for rows, looped in phase.loops.items():
                lines += self._loop_over_rows(rows, looped)
            for grid, arrays in phase.arrays.items():
                lines += self._loop_over_arrays(grid, arrays)
        return lines

    def text(self, number: Number) -> str:
        """A number as an argument, outside of loops."""
        if number.operation == CONSTANT:
            suffix = suffix_of(self.program)
            is_real = number.kind == "real"
            return real_literal(number.value, suffix) if is_real else str(int(number.value))
        if number.operation == INPUT and is_array(number):
            return str(number.value.name)
        return self._array_of.get(number.index, f"v{number.index}")

    def _read_outside_of_loops(self, results: Iterable[Number]) -> Iterator[Number]:
        """What is read by itself, or by another loop than the one that computes it."""
        yield from results
        for phase in self.phases:
            for number in phase.alone:
                yield from number.arguments

            # Lanes of one loop read each other row by row, and need no array for that.
            for looped in phase.loops.values():
                here = set(looped)
                for argument in chain(*(lanes.arguments for lanes in looped)):
                    if argument not in here:
                        yield from in_rows(argument)

            # Nor do operations on arrays of one loop, place by place.
            for arrays in phase.arrays.values():
                together = set(arrays)
                read = chain(*(number.arguments for number in arrays))
                yield from (argument for argument in read if argument not in together)

    def _loop_over_rows(self, rows: int, looped: Sequence[Lanes]) -> list[str]:
        """A loop, with the arrays that it reads and writes."""
        before: list[str] = []
        inside: list[str] = []
        gathered: dict[tuple[Number, ...], str] = {}

        here = set(looped)
        for lanes in looped:
            arguments: list[str] = []

            # Where each argument is: a number outside, one of this loop, or an array of an earlier
            # one; what was computed one by one is gathered into an array before.
            for argument in lanes.arguments:
                if isinstance(argument, Number):
                    arguments.append(self.text(argument))
                elif argument in here:
                    arguments.append(_one(argument))
                elif isinstance(argument, Lanes) and argument.last in self._array_of:
                    arguments.append(f"{_array(argument)}[row]")
                else:
                    numbers = in_rows(argument)
                    if numbers not in gathered:
                        gathered[numbers] = f"{_one(lanes)}_of_{len(gathered)}"
                        before.append(self._list(gathered[numbers], numbers))
                    arguments.append(f"{gathered[numbers]}[row]")

            # All rows compute as the first does; what is read outside of the loop is kept.
            number = lanes.numbers[0]
            inside += self._statement(number, arguments)
            if any(each.index in self._read for each in lanes.numbers):
                before.append(f"  {TYPES[number.kind]} {_array(lanes)}[{rows}];")
                inside.append(f"  {_array(lanes)}[row] = {_one(lanes)};")

        return [*before, f"  for (int row = 0; row < {rows}; ++row) {{", *inside, "  }"]

    def _statement(self, number: Number, arguments: Sequence[str]) -> list[str]:
        """What computes a number, or calls a routine."""
        name, value = f"v{number.index}", ""

        # What is there, and what takes several lines.
        if number.operation == INPUT and is_array(number):
            return []
        if number.operation in ROUTINES:
            return _call(number, name, arguments)
        if number.operation == LIST:
            return [self._list(name, number.arguments)]

        # What is one expression.
        if number.operation == INPUT:
            value = f"{number.value.name}[{number.value.place}]"
        elif number.operation == ITEM:
            value = f"{arguments[0]}[{number.value}]"
        elif number.operation == PICK:
            # An index beyond the candidates picks the first; unsigned, a negative one is beyond.
            index, array = arguments
            value = f"{array}[(unsigned long long){index} < {number.value} ? {index} : 0]"
        else:
            text = OPERATIONS[number.operation].text_of(number.kind)
            value = text.format(*arguments, f=suffix_of(self.program))
        return [f"  const {TYPES[number.kind]} {name} = {value};"]

    def _list(self, name: str, numbers: Sequence[Number]) -> str:
        """An array of numbers."""
        # Constants are static: they lie in the library, and no call writes them anew.
        are_known = all(number.operation == CONSTANT for number in numbers)
        qualifiers = "static const" if are_known else "const"
        listed = ", ".join(map(self.text, numbers))
        return f"  {qualifiers} {TYPES[numbers[0].kind]} {name}[] = {{{listed}}};"

    def _loop_over_arrays(self, grid: Grid, arrays: Sequence[Number]) -> list[str]:
        """A loop over the places of arrays, with those of them that are read elsewhere."""
        before: list[str] = []
        inside: list[str] = []

        together = set(arrays)
        for number in arrays:
            loop: Loop = number.value
            given = iter(number.arguments)
            arguments: list[str] = []
            for place in loop.places:
                # A place without {} reads a table by its name; one with it takes the next argument,
                # which is an array, or what this loop has just computed.
                argument = next(given) if "{}" in place else None
                if argument is None:
                    arguments.append(place)
                elif argument in together:
                    arguments.append(_at_place(argument))
                else:
                    arguments.append(place.format(self.text(argument)))

            # What is chosen from is read first, and not where the choice falls on it: without a
            # branch several places are computed at a time.
            if loop.operation == "where":
                for which, read in enumerate(arguments):
                    if read.endswith("]"):
                        type = TYPES["bool" if which == 0 else number.kind]
                        arguments[which] = f"{_at_place(number)}{which}"
                        inside.append(f"  const {type} {arguments[which]} = {read};")

            kind, name = TYPES[number.kind], f"v{number.index}"
            text = OPERATIONS[loop.operation].text.format(*arguments, f=suffix_of(self.program))
            inside.append(f"  const {kind} {_at_place(number)} = {text};")
            if number.index in self._read:
                before.append(f"  {kind} {name}[{grid.count}];")
                inside.append(f"  {name}[i] = {_at_place(number)};")

        return [*before, *_head(grid), *inside, "  }"]


def _head(grid: Grid) -> list[str]:
    """The head of a loop over the places of a grid."""
    if grid.columns == 1:
        return [f"  for (int {PLACE} = 0; {PLACE} < {grid.rows}; ++{PLACE}) {{"]
    return [
        f"  for (int {ROW} = 0; {ROW} < {grid.rows}; ++{ROW})",
        f"  for (int {COLUMN} = 0; {COLUMN} < {grid.columns}; ++{COLUMN}) {{",
        f"  const int {PLACE} = {grid.columns} * {ROW} + {COLUMN};",
    ]


def is_array(number: Number) -> bool:
    """Whether it is many numbers: a list, an input, or all that a routine or a loop gives."""
    if number.operation == INPUT:
        return bool(number.value.place is None)
    return number.operation in (LIST, LOOP) or number.operation in ROUTINES


def suffix_of(program: Program) -> str:
    """The suffix of functions and literals of the program's precision."""
    return "f" if program.dtype == torch.float32 else ""


def _one(lanes: Lanes) -> str:
    """The name of one row's number, in the loop."""
    return f"v{lanes.numbers[0].index}"


def _at_place(array: Number) -> str:
    """The name of an array's number at place i, in the loop that computes it."""
    return f"v{array.index}_i"


def _array(lanes: Lanes) -> str:
    """The name of an array of them all."""
    return f"{_one(lanes)}_rows"


def _call(number: Number, name: str, arguments: Sequence[str]) -> list[str]:
    """The call of a routine, whose arguments and results are arrays."""
    *sizes, count = number.value

    # Arguments are gathered into one array, unless they are one already.
    given = f"  const real {name}_in[] = {{{', '.join(arguments)}}};"
    result = f"  real {name}[{count}];"

    pointers = f"{name}_in"
    if len(number.arguments) == 1 and is_array(number.arguments[0]):
        given, pointers = "", arguments[0]
    if number.operation.startswith("substitute"):
        # It reads three arrays that stand one after the other: the factors, the rows exchanged, B.
        size = sizes[0]
        pointers = f"{name}_in, {name}_in + {size * size}, {name}_in + {size * size + size}"
    numbers = ", ".join(str(size) for size in sizes)
    return [*filter(None, (given, result)), f"  {number.operation}({numbers}, {pointers}, {name});"]


def real_literal(number: float, suffix: str) -> str:
    """A real number, to the last digit."""
    value = float(number)
    if not np.isfinite(value):
        return "((real)NAN)" if np.isnan(value) else f"({'-' if value < 0 else ''}(real)INFINITY)"

    # In brackets where there is a sign, −0.0's included: two minuses in a row would be C's `--`.
    text = f"{value!r}{suffix}"
    return f"({text})" if text.startswith("-") else text
