"""Images of a polygon that lies on a table, seen straight from above."""

import numpy as np
from numpy.typing import NDArray

from aicon_torch.models.arm_push.image_segmentation import RGBDImage
from aicon_torch.models.arm_push.polygon import contains, place
from aicon_torch.parts.camera import Intrinsics

INTRINSICS = Intrinsics(85.7, 79.5, 59.5, 160.0, 120.0)

L_SHAPE = np.array(
    [[-0.05, -0.07], [0.07, -0.07], [0.07, -0.02], [0.0, -0.02], [0.0, 0.08], [-0.05, 0.08]]
)
"""Corners of an L without any symmetry, m."""

TOP = 0.04
"""Height of its top face, m."""

RED, GREY, BLACK = (180, 30, 30), (150, 150, 150), (20, 20, 20)


def from_above(
    pose: NDArray[np.float64],
    corners: NDArray[np.float64] = L_SHAPE,
    height: float = 0.35,
    noise: float = 0.0,
) -> RGBDImage:
    """The object at a pose (x, y, θ), m and rad, seen from above the origin.

    The x axis of the camera is that of the table; its y axis points the other way, its z axis down.
    """
    rotation = np.diag([1.0, -1.0, -1.0])
    position = np.array([0.0, 0.0, height])

    rows, columns = np.mgrid[: int(INTRINSICS.height), : int(INTRINSICS.width)]
    x = (columns - INTRINSICS.center_x) / INTRINSICS.focal * (height - TOP)
    y = -(rows - INTRINSICS.center_y) / INTRINSICS.focal * (height - TOP)
    points = np.column_stack((x.ravel(), y.ravel()))
    is_object = contains(points, place(corners, np.asarray(pose)), 0.0).reshape(rows.shape)

    rgb = np.where(is_object[..., None], RED, GREY).astype(np.uint8)
    depth = np.where(is_object, height - TOP, height)
    depth = depth + noise * np.random.default_rng(0).normal(size=depth.shape)
    return RGBDImage(rgb, depth.astype(np.float32), rotation, position)


def behind_stick(image: RGBDImage) -> RGBDImage:
    """The image with a black stick in front of its middle."""
    rgb = image.rgb.copy()
    rgb[40:, 76:84] = BLACK
    return image._replace(rgb=rgb)
