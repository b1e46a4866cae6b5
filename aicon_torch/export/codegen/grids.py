"""The places of a loop as rows and columns: what varies along one of them only is read so often.

Distances of many points to many objects are such a grid. Read by row and column instead of by a
table of places, what lies in a row is computed several at a time.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import TypeVar

Item = TypeVar("Item", bound=Hashable)

PLACE, ROW, COLUMN = "i", "row", "column"
"""What a place, its row and its column are called in C."""


@dataclass(frozen=True)
class Grid:
    """The places of a loop, row by row.

    Attributes:
        rows: How many rows.
        columns: How many columns; 1 where there are places only.
    """

    rows: int
    columns: int

    @property
    def count(self) -> int:
        """How many places."""
        return self.rows * self.columns

    @classmethod
    def of(cls, shape: Sequence[int]) -> "Grid":
        """The grid of an array: its last dimension, and all before it as one."""
        *before, columns = shape
        rows = 1
        for size in before:
            rows *= size
        return cls(rows, columns) if rows > 1 else cls(columns, 1)

    def reduced(self, items: Sequence[Item]) -> tuple[list[Item], str]:
        """The items that have to be read, and which of them is the one at a place.

        Args:
            items: One for each place.
        """
        columns = self.columns
        if columns > 1:
            by_row = [items[row * columns] for row in range(self.rows)]
            if all(item == by_row[place // columns] for place, item in enumerate(items)):
                return by_row, ROW
            by_column = list(items[:columns])
            if all(item == by_column[place % columns] for place, item in enumerate(items)):
                return by_column, COLUMN
        return list(items), PLACE


def equally_spaced(numbers: Sequence[int]) -> tuple[int, int] | None:
    """The first of some numbers and the distance of the next one; None where that varies."""
    first, step = numbers[0], numbers[1] - numbers[0] if len(numbers) > 1 else 1
    end = first + step * len(numbers)
    return (first, step) if step > 0 and list(numbers) == list(range(first, end, step)) else None


def index(place: str, first: int, step: int) -> str:
    """The index ``step * place + first`` in C."""
    scaled = place if step == 1 else f"{step} * {place}"
    return f"{scaled} + {first}" if first else scaled
