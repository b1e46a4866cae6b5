"""Operators that make tensors of constants."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer, as_array
from aicon_torch.export.codegen.operators import Translation
from aicon_torch.export.codegen.scalars import Kind


def full(writer: Writer, kind: Kind, shape: Sequence[int], value: float, **_: Any) -> Array:
    """A constant everywhere."""
    return writer.full(shape, value, kind)


def full_like(writer: Writer, kind: Kind, like: Array, value: float, **_: Any) -> Array:
    """A constant in the shape of another."""
    return writer.full(like.shape, value, kind)


def scalar(writer: Writer, kind: Kind, value: float, **_: Any) -> Array:
    """One constant."""
    return writer.full((), value, kind)


def zeros(writer: Writer, kind: Kind, shape: Sequence[int], **_: Any) -> Array:
    """Zeros."""
    return writer.full(shape, 0, kind)


def zeros_like(writer: Writer, kind: Kind, like: Array, *_: Any, **__: Any) -> Array:
    """Zeros in the shape of another."""
    return writer.full(like.shape, 0, kind)


def steps(writer: Writer, kind: Kind, start: float, end: float, step: float = 1, **_: Any) -> Array:
    """Constants at equal distances."""
    values = np.arange(start, end, step).tolist()
    return as_array([writer.program.constant(value, kind) for value in values], (len(values),))


CREATION: dict[str, Translation] = {
    "full": full,
    "full_like": full_like,
    "scalar_tensor": scalar,
    "zeros": zeros,
    "zeros_like": zeros_like,
    # What is empty is overwritten before anyone reads it, so zeros do.
    "empty": zeros,
    "arange": steps,
}
"""The translation of each operator that creates, by its name in aten without the overload."""
