"""Which robot of a batch is asked about."""

import operator
from typing import Any

from aicon_torch.resolution import Memory


def of_one_robot(memory: Memory, actuator: str, row: Any) -> Memory:
    """The memory of one robot: the same entries, without the batch.

    Args:
        memory: The memory, ``(*B, …)``.
        actuator: Any actuator, which tells the batch.
        row: Which row of the batch: a number, or one for each of its dimensions.

    Raises:
        ValueError: If it names no single row of it.
    """
    batch = tuple(memory[actuator].shape[:-1])
    places = row if isinstance(row, tuple) else (row,)
    try:
        numbers = tuple(map(operator.index, places))
    except TypeError:
        numbers = ()

    # A truth value is a number to Python, and a mask to torch.
    are_numbers = len(numbers) == len(places) and not any(isinstance(p, bool) for p in places)
    is_there = [-count <= number < count for number, count in zip(numbers, batch, strict=False)]
    if not are_numbers or len(numbers) != len(batch) or not all(is_there):
        raise ValueError(f"row={row!r}: the memory has batch shape {batch}; name one row of it.")
    return {key: value[numbers] for key, value in memory.items()}
