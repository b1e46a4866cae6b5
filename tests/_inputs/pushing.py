"""Objects, poses and places of a pusher for the tests of pushing, in m and rad."""

import math
from collections.abc import Sequence

import shapely
import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch.models.pusht import PIXEL, Options, benchmark, rigid_object
from aicon_torch.parts import RigidObject

Corners = Sequence[Sequence[float]]


def from_pixels(*corners: tuple[float, float]) -> Corners:
    """Corners in m of an object that is drawn in px."""
    return tuple((x * PIXEL, y * PIXEL) for x, y in corners)


RADIUS = benchmark.PUSHER_RADIUS
TRIANGLE = from_pixels((-50, -30), (70, -20), (-10, 60))
NOTCHED = from_pixels((0, 0), (40, 80), (80, 0), (110, 0), (40, 140), (-30, 0))
"""A V upside down, whose notch is sharper than a right angle."""

SHAPES: dict[str, Corners | None] = {"T": None, "triangle": TRIANGLE, "notched": NOTCHED}


def uniform(*shape: int, seed: int = 0) -> Tensor:
    """Uniform in [0, 1), the same in every run."""
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(shape, generator=generator, dtype=torch.float64)


def body_of(keypoints: Corners | None = None) -> RigidObject:
    """The object with these corners; None is the T."""
    return rigid_object(Options(keypoints=keypoints))


def poses(count: int, seed: int = 0) -> Tensor:
    """Poses (x, y, θ) around the middle of the world, ``(count, 3)``."""
    place = PIXEL * (256 + 120 * (uniform(count, 2, seed=seed) - 0.5))
    angle = 2 * math.pi * uniform(count, 1, seed=seed + 1)
    return torch.cat((place, angle), dim=-1)


def outside(body: RigidObject, pose: Tensor, farthest: float, seed: int = 0) -> Tensor:
    """Places of a pusher up to ``farthest`` from some side that touch none, ``(count, 2)``."""
    keypoints, count = body.keypoints_at(pose), len(pose)
    sides = body.sides(keypoints)
    polygons = shapely.polygons(keypoints[:, body.outline_order].numpy())

    places = torch.full((count, 2), torch.nan, dtype=torch.float64)
    while places.isnan().any():
        seed += 1
        place = _beside(sides, farthest, seed)
        distance = shapely.distance(polygons, shapely.points(place.numpy()))
        fits = torch.as_tensor(distance > RADIUS) & places.isnan().any(-1)
        places = torch.where(fits.unsqueeze(-1), place, places)
    return places


def _beside(sides: Tensor, farthest: float, seed: int) -> Tensor:
    """Random places ``(count, 2)`` about one side of each object ``(count, N, 4)``."""
    count, number = sides.shape[:2]
    which, share, turn, gap = uniform(4, count, 1, seed=seed).unbind(0)
    side = sides[torch.arange(count), (number * which).long().squeeze(-1)]

    point = side[:, :2] + (1.4 * share - 0.2) * (side[:, 2:] - side[:, :2])
    angle = 2 * math.pi * turn
    direction = torch.cat((angle.cos(), angle.sin()), dim=-1)
    return point + (RADIUS + farthest * gap) * direction


def in_pixels(body: RigidObject, pose: Tensor, pusher: Tensor) -> dict[str, Tensor]:
    """What the environment shows of a pose and a pusher's place, ``(*B, …)``, px."""
    keypoints = body.keypoints_at(pose).flatten(-2)
    return {"environment_state": keypoints / PIXEL, "agent_pos": pusher / PIXEL}


def wandering(
    steps: int, batch: int, keypoints: Corners | None = None, seed: int = 0
) -> list[dict[str, Tensor]]:
    """Readings, in px, of a pusher that wanders around an object that moves a little."""
    body = body_of(keypoints)
    pose = poses(batch, seed)
    pusher = outside(body, pose, 60 * PIXEL, seed + 5)
    spread = torch.tensor([2 * PIXEL, 2 * PIXEL, 0.05], dtype=torch.float64)

    readings = []
    for step in range(steps):
        readings.append(in_pixels(body, pose, pusher))
        pusher = pusher + 8 * PIXEL * normal(batch, 2, seed=seed + 10 + step)
        pose = pose + spread * normal(batch, 3, seed=seed + 50 + step)
    return readings


def touching(steps: int, batch: int, seed: int = 0) -> list[dict[str, Tensor]]:
    """Readings, in px, of a pusher that is so close to the T that it pushes it every other step."""
    body, pose = body_of(), poses(batch, seed)
    pusher = outside(body, pose, 8 * PIXEL, seed + 5)
    spread = torch.tensor([PIXEL, PIXEL, 0.01], dtype=torch.float64)

    readings = []
    for step in range(steps):
        place = pusher + 0.5 * PIXEL * normal(batch, 2, seed=seed + 10 + step)
        seen = pose + spread * normal(batch, 3, seed=seed + 50 + step)
        readings.append(in_pixels(body, seen, place))
    return readings


def without(reading: dict[str, Tensor], *keys: str) -> dict[str, Tensor]:
    """A reading that lacks some of its keys."""
    return {name: value for name, value in reading.items() if name not in keys}
