"""What is written into the outputs of a function: numbers one by one, and stretches of arrays."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from aicon_torch.export.codegen.arrays import LOOPED, Array
from aicon_torch.export.codegen.scalars import Number, Program, array_and_place


class Write(NamedTuple):
    """A number, or a stretch of an array, that is written.

    Attributes:
        output: The name of the output.
        place: The first place there.
        number: What is written; the array that it comes from, if there are many.
        first: The first place in that array; None for a number.
        length: How many are written.
    """

    output: str
    place: int
    number: Number
    first: int | None = None
    length: int = 1


def writes_of(program: Program, outputs: Mapping[str, Array]) -> list[Write]:
    """What is written where."""
    return [
        write
        for output, numbers in outputs.items()
        for write in _into(program, output, list(numbers.reshape(-1)))
    ]


def _into(program: Program, output: str, numbers: list[Number]) -> Iterator[Write]:
    place = 0
    while place < len(numbers):
        # How many follow each other in one array as well?
        start, count = array_and_place(numbers[place]), 1
        if start is not None:
            array, first = start
            for number in numbers[place + 1 :]:
                if array_and_place(number) != (array, first + count):
                    break
                count += 1

        # A long stretch is copied as a whole, a short one number by number.
        if start is not None and count >= LOOPED:
            yield Write(output, place, program.array(array), first, count)
        else:
            for offset in range(count):
                yield Write(output, place + offset, numbers[place + offset])
        place += count
