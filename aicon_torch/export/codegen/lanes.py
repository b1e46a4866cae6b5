"""Where a program does the same in every row of a batch: what a loop can do, written once.

The smallest gaps of a safety goal get a row each, so that one backward pass yields the slopes of
them all. Taken apart into numbers this is one computation, written as many times as there are rows.
Here the numbers that play one part in all rows are found, the *lanes* of a loop over the rows.
"""

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

from aicon_torch.export.codegen.grids import PLACE, Grid
from aicon_torch.export.codegen.scalars import CONSTANT, LOOP, OPERATIONS, PICK, Number, Program

FEWEST = 2048
"""Numbers from which on they are worth a loop."""

MOST_ROWS = 64
"""A batch of more rows is not looked for."""

Argument: TypeAlias = "Lanes | Number | tuple[Number, ...]"
"""Lanes themselves; or a number that is the same in all rows; or any numbers, one for each row."""


@dataclass(frozen=True, eq=False)
class Lanes:
    """The numbers that play one part in all rows: the same operation on the same arguments.

    Attributes:
        numbers: The number in each row.
        arguments: What they are computed from.
    """

    numbers: tuple[Number, ...]
    arguments: tuple[Argument, ...]

    @cached_property
    def last(self) -> int:
        """The index of the number that is the last one in the program."""
        return max(number.index for number in self.numbers)


@dataclass(frozen=True)
class Phase:
    """Numbers by themselves, and after them what loops compute.

    Attributes:
        alone: Numbers by themselves.
        loops: Lanes, by how many rows they have.
        arrays: Operations on the numbers of arrays, by the grid of their places: a loop of them
            each, in which what one reads of another is at its own place.
    """

    alone: list[Number] = field(default_factory=list)
    loops: defaultdict[int, list[Lanes]] = field(default_factory=lambda: defaultdict(list))
    arrays: defaultdict[Grid, list[Number]] = field(default_factory=lambda: defaultdict(list))


def in_phases(program: Program, needed: Collection[int]) -> list[Phase]:
    """Numbers and loops in an order in which they can be computed.

    Args:
        program: The program.
        needed: The indices of the numbers that are computed.
    """
    lanes = _lanes(program, needed)
    while True:
        phases = _ordered(program, needed, lanes)

        # What is in too small a loop is written out, which may make others smaller: once more.
        small = _in_small_loops(phases)
        if not small:
            return phases
        lanes = [each for each in lanes if each not in small]


def _ordered(program: Program, needed: Collection[int], lanes: Sequence[Lanes]) -> list[Phase]:
    """Each number, or all of its lanes, in the first phase in which its arguments are known."""
    lanes_of = {number.index: each for each in lanes for number in each.numbers}
    phases: defaultdict[int, Phase] = defaultdict(Phase)
    phase_of: dict[int, int] = {}

    def known_from(number: Number) -> int:
        """The phase from which on a number can be read outside of its loop."""
        is_looped = number.index in lanes_of or number.operation == LOOP
        return phase_of.get(number.index, 0) + is_looped

    for number in program.numbers:
        if number.index not in needed or number.operation == CONSTANT:
            continue
        own = lanes_of.get(number.index)

        # An array is computed in one loop with those that it reads one after the other.
        if number.operation == LOOP:
            here = {argument for argument in number.arguments if _are_one_loop(number, argument)}
            waits = [phase_of[argument.index] for argument in here]
            waits += [known_from(argument) for argument in number.arguments if argument not in here]
            phase_of[number.index] = max(waits, default=0)
            phases[phase_of[number.index]].arrays[number.value.grid].append(number)

        # A number of its own comes as soon as its arguments are known.
        elif own is None:
            phase_of[number.index] = max(map(known_from, number.arguments), default=0)
            phases[phase_of[number.index]].alone.append(number)

        # A loop computes all of its lanes at once, so it waits for the arguments of every one.
        elif number.index == own.last:
            phase = 0
            for argument in own.arguments:
                if isinstance(argument, Lanes) and argument.last in lanes_of:
                    phase = max(phase, phase_of[argument.last])
                else:
                    phase = max(phase, *map(known_from, in_rows(argument)))
            phase_of.update((each.index, phase) for each in own.numbers)
            phases[phase].loops[len(own.numbers)].append(own)
    return [phases[phase] for phase in sorted(phases)]


def in_rows(argument: Argument) -> tuple[Number, ...]:
    """The numbers of an argument: one in each row, or the one of them all."""
    if isinstance(argument, Lanes):
        return argument.numbers
    return (argument,) if isinstance(argument, Number) else argument


def _are_one_loop(loop: Number, other: Number) -> bool:
    """Whether they can be one: of one grid, and a loop reads of the other what is at its place."""
    if other.operation != LOOP or other.value.grid != loop.value.grid:
        return False

    places = [place for place in loop.value.places if "{}" in place]
    reads = zip(loop.arguments, places, strict=True)
    return all(place == f"{{}}[{PLACE}]" for argument, place in reads if argument is other)


def _in_small_loops(phases: Sequence[Phase]) -> set[Lanes]:
    """The lanes in loops that compute too few numbers."""
    found: set[Lanes] = set()
    for phase in phases:
        for rows, lanes in phase.loops.items():
            if rows * len(lanes) < FEWEST:
                found.update(lanes)
    return found


def _lanes(program: Program, needed: Collection[int]) -> list[Lanes]:
    """All lanes, those of the largest batches first."""
    found: list[Lanes] = []
    free, first_use = set(needed), _first_uses(program, needed)

    for rows in _numbers_of_rows(program):
        lanes = _Search(program, free, first_use, rows).lanes()
        free.difference_update(number.index for each in lanes for number in each.numbers)
        found += lanes
    return found


def _numbers_of_rows(program: Program) -> list[int]:
    """The sizes of leading dimensions, those of the most numbers first."""
    sizes: Counter[int] = Counter()
    for array in program.arrays:
        if array.ndim > 1 and 1 < len(array) <= MOST_ROWS:
            sizes[len(array)] += array.size
    return [rows for rows, size in sizes.most_common() if size >= FEWEST]


class _Search:
    """The search for the lanes of a batch of some rows.

    Args:
        program: The program.
        free: The indices of the numbers that may become lanes.
        first_use: By the index of a number that of the first one which reads it.
        rows: How many rows the batch has.
    """

    def __init__(
        self,
        program: Program,
        free: Collection[int],
        first_use: Mapping[int, float],
        rows: int,
    ) -> None:
        self.program, self.free, self.first_use, self.rows = program, free, first_use, rows
        self.found: list[Lanes] = []
        self.of: dict[int, tuple[Lanes, int]] = {}  # lanes and row by the index of a number

    def lanes(self) -> list[Lanes]:
        """All lanes of these rows."""
        # In the order of their computation: when lanes are looked at, their arguments are known.
        for array in self.program.arrays:
            if array.size % self.rows == 0:
                for numbers in array.reshape(self.rows, -1).T:
                    self._add(tuple(numbers))
        return self.found

    def _add(self, numbers: tuple[Number, ...]) -> None:
        """Take numbers as lanes if they are."""
        # A different number in each row, none of them spoken for, ...
        if len(set(numbers)) < self.rows or not self._are_free(numbers):
            return

        # ... all by the same operation, which a loop can do, ...
        operation, value = numbers[0].operation, numbers[0].value
        if operation not in OPERATIONS and operation != PICK:
            return
        if any((number.operation, number.value) != (operation, value) for number in numbers):
            return

        # ... on arguments that a loop can read. To gather more than one costs what the loop saves,
        # and a choice must be from the same array in every row.
        columns = zip(*(number.arguments for number in numbers), strict=True)
        arguments = [self._argument(column) for column in columns]
        gathered = [argument for argument in arguments if isinstance(argument, tuple)]
        if len(gathered) > 1 or (operation == PICK and not isinstance(arguments[1], Number)):
            return
        lanes = Lanes(numbers, tuple(arguments))
        self.found.append(lanes)
        self.of.update((number.index, (lanes, row)) for row, number in enumerate(numbers))

    def _are_free(self, numbers: Sequence[Number]) -> bool:
        """Whether they are no lanes yet, and none is read before all of them are there."""
        last = max(number.index for number in numbers)
        return all(
            number.index in self.free
            and number.index not in self.of
            and self.first_use[number.index] > last
            for number in numbers
        )

    def _argument(self, numbers: tuple[Number, ...]) -> Argument:
        """One argument in all rows."""
        if all(number is numbers[0] for number in numbers):
            return numbers[0]

        # Lanes, if they stand in the order of the rows; else numbers to be gathered.
        lanes = [self.of.get(number.index) for number in numbers]
        if lanes[0] is not None and lanes == [(lanes[0][0], row) for row in range(self.rows)]:
            return lanes[0][0]
        return numbers


def _first_uses(program: Program, needed: Collection[int]) -> dict[int, float]:
    """By whom, the first one in the program, each number is read; by nobody: infinity."""
    first: dict[int, float] = defaultdict(lambda: float("inf"))

    # Backward, so that the first reader is noted last, and stays.
    for number in reversed(program.numbers):
        if number.index in needed:
            first.update((argument.index, number.index) for argument in number.arguments)
    return first
