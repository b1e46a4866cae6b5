"""Resizing of pictures, equal to OpenCV's number for number, without OpenCV."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

_ONE = np.float32(2048.0)
"""Weights are multiples of 1 / 2048."""


def resize(picture: Picture, width: int, height: int) -> Picture:
    """Resize (H, W, 3) bilinearly, in the fixed-point arithmetic of OpenCV's `INTER_LINEAR`.

    A row's blend loses 4 bits, its product with the row's weight 16, and the last 2 are rounded.
    """
    columns = _interpolate(picture.shape[1], width)
    rows = _interpolate(picture.shape[0], height)

    # Along the rows, then between them.
    upper = _blend_columns(picture[rows.low], columns) >> 4
    lower = _blend_columns(picture[rows.high], columns) >> 4

    upper = (upper * rows.low_weight[:, np.newaxis, np.newaxis]) >> 16
    lower = (lower * rows.high_weight[:, np.newaxis, np.newaxis]) >> 16

    resized: Picture = ((upper + lower + 2) >> 2).astype(np.uint8)
    return resized


class _Interpolation(NamedTuple):
    """Between which two pixels of the source each pixel lies, and their weights in 1 / 2048."""

    low: NDArray[np.int64]
    high: NDArray[np.int64]
    low_weight: NDArray[np.int32]
    high_weight: NDArray[np.int32]


def _interpolate(source: int, count: int) -> _Interpolation:
    """Spread `count` pixels over `source` ones along an axis, the middles of both aligned."""
    # In float32, as OpenCV has it.
    position = ((np.arange(count) + 0.5) * (source / count) - 0.5).astype(np.float32)
    position = np.clip(position, 0.0, source - 1.0)

    low = np.floor(position).astype(np.int64)
    high = np.minimum(low + 1, source - 1)

    share = position - low.astype(np.float32)
    low_weight = np.rint((1.0 - share) * _ONE).astype(np.int32)
    high_weight = np.rint(share * _ONE).astype(np.int32)
    return _Interpolation(low, high, low_weight, high_weight)


def _blend_columns(rows: Picture, columns: _Interpolation) -> NDArray[np.int32]:
    """Return rows (h, W, 3) with their columns interpolated, (h, width, 3), in 1 / 2048."""
    left = rows[:, columns.low] * columns.low_weight[:, np.newaxis]
    right = rows[:, columns.high] * columns.high_weight[:, np.newaxis]

    blended: NDArray[np.int32] = left + right
    return blended
