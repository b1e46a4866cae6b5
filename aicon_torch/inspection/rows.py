"""Which robot of a batch is asked about."""

import operator
from typing import Any

import torch

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

    # A truth value is a number to Python, and a mask to torch; an array of one is an array.
    are_numbers = len(numbers) == len(places) and not any(map(_is_mask_or_array, places))
    is_there = [-count <= number < count for number, count in zip(numbers, batch, strict=False)]
    if not are_numbers or len(numbers) != len(batch) or not all(is_there):
        raise ValueError(f"row={row!r}: the memory has batch shape {batch}; name one row of it.")
    return {key: value[numbers] for key, value in memory.items()}


def _is_mask_or_array(place: Any) -> bool:
    """Whether something is a truth value, or has a dimension."""
    is_mask = isinstance(place, bool) or getattr(place, "dtype", None) == torch.bool
    return is_mask or getattr(place, "ndim", 0) > 0
