"""Random states near an object, and what the limits of contact make of random wishes there."""

import dataclasses
import math
from typing import Any, NamedTuple

import torch
from torch import Tensor

from _inputs.pushing import RADIUS, Corners, body_of, outside, poses, uniform
from aicon_torch.models.pusht.benchmark import PIXEL, T_WIDTH
from aicon_torch.parts import ContactLimitOptions, ContactLimits, ContactOptions, closest_point


def limits_of(keypoints: Corners | None = None, sides: int = 99, **options: Any) -> ContactLimits:
    """The limits near an object, by default for every side of the T."""
    dynamics = ContactOptions(size=T_WIDTH).dynamics(body_of(keypoints))
    limits = ContactLimitOptions(**options).limits(dynamics, RADIUS, T_WIDTH)
    return dataclasses.replace(limits, nearest_sides=sides)


class NearContact(NamedTuple):
    """States near an object, a wish and an action in each, and what the limits know of each side.

    Attributes:
        pusher: Where the pusher is, ``(count, 2)``, m.
        sides: The object's, ``(count, N, 4)``, m.
        wish: The velocity before the limits, ``(count, 2)``, m/s.
        action: The velocity after them.
        normals: From the pusher to each side, ``(count, N, 2)``.
        gaps: Distance of the disc to each side, ``(count, N)``, m.
        helpful: The push that helps most at each side, ``(count, N)``, m.
        allowed: The push that is allowed there.
    """

    pusher: Tensor
    sides: Tensor
    wish: Tensor
    action: Tensor
    normals: Tensor
    gaps: Tensor
    helpful: Tensor
    allowed: Tensor

    def excess(self, pusher: Tensor) -> Tensor:
        """By how much the disc is deeper in a side than it may be, at most, ``(count,)``, m."""
        points = closest_point(pusher.unsqueeze(-2), self.sides)
        distance = (points - pusher.unsqueeze(-2)).norm(dim=-1)
        return (RADIUS - distance - self.allowed).amax(-1)

    def excess_at_the_end(self) -> Tensor:
        """The excess after a step of 0.1 s with the action, ``(count,)``, m."""
        return self.excess(self.pusher + 0.1 * self.action)


def near_contact(
    limits: ContactLimits, count: int = 2000, farthest: float = 60 * PIXEL, seed: int = 0
) -> NearContact:
    """Random states up to ``farthest`` from an object, and what limits make of random wishes."""
    body = limits.dynamics.body
    pose, target = poses(count, seed), poses(count, seed + 6)
    pusher = outside(body, pose, farthest, seed + 1)
    sides = body.sides(body.keypoints_at(pose))

    angle = 2 * math.pi * uniform(count, 1, seed=seed + 2)
    speed = 800 * PIXEL * uniform(count, 1, seed=seed + 3)
    wish = speed * torch.cat((angle.cos(), angle.sin()), dim=-1)

    points = closest_point(pusher.unsqueeze(-2), sides)
    to_contact = points - pusher.unsqueeze(-2)
    distance = to_contact.norm(dim=-1, keepdim=True)
    normals, gaps = to_contact / distance, distance.squeeze(-1) - RADIUS
    helpful = limits.helpful_push(points, normals, pose, target)
    allowed = torch.where(helpful > 0, helpful.clamp(*limits.push), limits.harm)

    action = limits(wish, pusher, points, sides, pose, target, 0.1)
    return NearContact(pusher, sides, wish, action, normals, gaps, helpful, allowed)
