"""The outline of the object that is pushed: a simple polygon, its mass properties and its registration."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from aicon_torch.errors import OptionError

T_KEYPOINTS = ((-60, 0), (60, 0), (60, 30), (-60, 30), (-15, 30), (15, 30), (15, 120), (-15, 120))
"""Corners of the benchmark's T in its body frame, in the order in which it reports them, px."""

T_BORDER = (0, 1, 2, 5, 6, 7, 4, 3)
"""The order in which they follow each other around the T."""

T_CENTER = (0.0, 45.0)
"""The T's centre of mass in the benchmark's physics, px."""

T_GYRATION = 3000**0.5
"""Its radius of gyration there, px: both its boxes have the inertia of the bar about the frame's origin.

A T of uniform density has its centre at (0, 40.7) and a radius of gyration of 43.9 px.
"""


@dataclass(frozen=True)
class Outline:
    """A polygon and how it moves when it is pushed.

    Attributes:
        keypoints: Corners in the body frame relative to the centre of mass, in the order of the sensor, ``(N, 2)``, px.
        center: Centre of mass in the body frame, ``(2,)``, px.
        border: Order of the corners around the polygon, with the inside on the right of each side as the y axis points
            up (on the left on a screen, where it points down).
        gyration: Radius of gyration, px.
    """

    keypoints: Tensor
    center: Tensor
    border: tuple[int, ...]
    gyration: float

    @classmethod
    def of(
        cls,
        keypoints: Sequence[Sequence[float]] | None = None,
        border: Sequence[int] | None = None,
        center: Sequence[float] | None = None,
        gyration: float | None = None,
    ) -> "Outline":
        """The benchmark's T, or a polygon of uniform density.

        Args:
            keypoints: Corners in the body frame, px; None for the T.
            border: Their order around the polygon, in either sense; by default the order in which they are given.
            center: Centre of mass, px, if it is not the polygon's.
            gyration: Radius of gyration, px, if it is not the polygon's.

        Raises:
            OptionError: If these are no corners of a polygon with an area.
        """
        if keypoints is None:
            keypoints, border = T_KEYPOINTS, T_BORDER if border is None else border
            center, gyration = T_CENTER if center is None else center, T_GYRATION if gyration is None else gyration
        if isinstance(keypoints, str) or not hasattr(keypoints, "__len__") or len(keypoints) < 3:
            raise OptionError(f"keypoints={keypoints!r}: expected 3 or more corners (x, y) in px.")
        corners = torch.tensor([numbers("keypoints", corner, 2) for corner in keypoints], dtype=torch.float64)
        order = [int(index) for index in (range(len(corners)) if border is None else border)]
        if sorted(order) != list(range(len(corners))):
            raise OptionError(f"border={border!r}: expected each of the {len(corners)} keypoints once.")
        if not _is_simple(corners[order]):
            raise OptionError(
                f"border={border!r}: two sides cross; expected the order of the keypoints around the object."
            )
        area, centroid, squared = _moments(corners[order])
        if not abs(area) > 0:
            raise OptionError("keypoints: expected a polygon with an area; does border= follow its outline?")
        if area < 0:
            order.reverse()
        middle = centroid if center is None else torch.tensor(numbers("center", center, 2), dtype=torch.float64)
        radius = squared**0.5 if gyration is None else numbers("gyration", gyration, 1)[0]
        if not radius > 0:
            raise OptionError(f"gyration={gyration!r}: expected a positive number of px.")
        return cls(corners - middle, middle, tuple(order), float(radius))

    def sides(self, x_keypoints: Tensor) -> Tensor:
        """The sides (start, end) in the order of the border, ``(*B, N, 4)``, px."""
        after = (*self.border[1:], self.border[0])
        return torch.cat((x_keypoints[..., self.border, :], x_keypoints[..., after, :]), dim=-1)

    def placed(self, pose: Tensor) -> Tensor:
        """The keypoints ``(*B, N, 2)`` of an object whose centre and orientation are (x, y, θ) ``(*B, 3)``."""
        cos, sin = torch.cos(pose[..., 2:]), torch.sin(pose[..., 2:])
        x, y = self.keypoints.to(pose).unbind(-1)
        return torch.stack((cos * x - sin * y, sin * x + cos * y), dim=-1) + pose[..., None, :2]

    def pose(self, x_keypoints: Tensor) -> Tensor:
        """Registration: the pose (x, y, θ) whose keypoints are nearest to these in the least-squares sense.

        The optimal rotation in the plane has the angle of Σ (rᵢ · kᵢ, rᵢ × kᵢ), both taken from their means (Kabsch).

        Args:
            x_keypoints: ``(*B, N, 2)``, px.

        Returns:
            ``(*B, 3)``, px and rad.
        """
        model = self.keypoints.to(x_keypoints)
        middle = model.mean(0)
        mean = x_keypoints.mean(-2)
        (rx, ry), (kx, ky) = (model - middle).unbind(-1), (x_keypoints - mean.unsqueeze(-2)).unbind(-1)
        cos, sin = (rx * kx + ry * ky).sum(-1), (rx * ky - ry * kx).sum(-1)
        angle = torch.atan2(sin, cos)
        cos, sin = torch.cos(angle), torch.sin(angle)
        x = mean[..., 0] - (cos * middle[0] - sin * middle[1])
        y = mean[..., 1] - (sin * middle[0] + cos * middle[1])
        return torch.stack((x, y, angle), dim=-1)

    def center_at(self, frame: Tensor) -> Tensor:
        """Centre and orientation ``(*B, 3)`` of an object whose body frame is at (x, y, θ) ``(*B, 3)``."""
        cos, sin = torch.cos(frame[..., 2]), torch.sin(frame[..., 2])
        x, y = self.center.to(frame)
        offset = torch.stack((cos * x - sin * y, sin * x + cos * y, torch.zeros_like(cos)), dim=-1)
        return frame + offset


def numbers(name: str, value: Any, size: int) -> tuple[float, ...]:
    """The finite numbers of an option.

    Raises:
        OptionError: If they are not so many or not finite.
    """
    try:
        found = tuple(map(float, value)) if size > 1 else (float(value),)
    except (TypeError, ValueError):
        found = ()
    if isinstance(value, str | bool) or len(found) != size or not all(map(math.isfinite, found)):
        raise OptionError(f"{name}={value!r}: expected {size} finite number{'s' * (size > 1)}.")
    return found


def _is_simple(border: Tensor) -> bool:
    """Whether no two sides of a polygon ``(N, 2)`` cross."""
    after = border.roll(-1, 0)

    def turn(a: Tensor, b: Tensor, c: Tensor) -> Tensor:
        first, second = b - a, c - a
        return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]

    a, b, c, d = border[:, None], after[:, None], border[None], after[None]
    crossing = (turn(a, b, c) * turn(a, b, d) < 0) & (turn(c, d, a) * turn(c, d, b) < 0)
    return not bool(crossing.any())


def _moments(border: Tensor) -> tuple[float, Tensor, float]:
    """Signed area, centroid ``(2,)`` and squared radius of gyration about it of a polygon ``(N, 2)``."""
    origin = border.mean(0)
    here = border - origin
    after = here.roll(-1, 0)
    cross = here[:, 0] * after[:, 1] - here[:, 1] * after[:, 0]
    area = float(cross.sum()) / 2
    if area == 0:
        return 0.0, origin, 0.0
    centroid = ((here + after) * cross.unsqueeze(-1)).sum(0) / (6 * area)
    second = float((cross * (here * here + here * after + after * after).sum(-1)).sum()) / (12 * area)
    return area, centroid + origin, second - float(centroid @ centroid)
