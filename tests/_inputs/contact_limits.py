"""Random states near an object, and what the limits of contact make of random wishes there."""

import dataclasses
import math
from typing import Any, NamedTuple

import torch
from torch import Tensor

from _inputs.pushing import RADIUS, Corners, outside, poses, uniform
from _inputs.random_numbers import normal
from _inputs.servo import sub_steps
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import ContactLimits, Servo, closest_point


def limits_of(keypoints: Corners | None = None, sides: int = 99, **options: Any) -> ContactLimits:
    """The limits of a policy, by default for every side."""
    policy = make_policy("pusht", keypoints=keypoints, **options)
    (found,) = policy.model.actuators["a"].constraints
    assert isinstance(found, ContactLimits)
    return dataclasses.replace(found, nearest_sides=sides)


class NearContact(NamedTuple):
    """States near an object, a wish and an action in each, and what the limits know of each side.

    Attributes:
        pusher: Where the pusher is, ``(count, 2)``, m.
        velocity: How fast, ``(count, 2)``, m/s.
        sides: The object's, ``(count, N, 4)``, m.
        wish: The velocity before the limits, ``(count, 2)``, m/s.
        action: The velocity after them.
        normals: From the pusher to each side, ``(count, N, 2)``.
        gaps: Distance of the disc to each side, ``(count, N)``, m.
        helpful: The push that helps most at each side, ``(count, N)``, m.
        allowed: The push that is allowed there.
    """

    pusher: Tensor
    velocity: Tensor
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

    def largest_excess(self) -> Tensor:
        """The largest excess of any sub-step of the servo, ``(count,)``, m."""
        offset = Servo.of().target_offset(self.action, self.velocity, 0.1)
        places, _ = sub_steps(offset, self.velocity)
        return torch.stack([self.excess(self.pusher + place) for place in places]).amax(0)


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
    velocity = 300 * PIXEL * normal(count, 2, seed=seed + 4)

    points = closest_point(pusher.unsqueeze(-2), sides)
    to_contact = points - pusher.unsqueeze(-2)
    distance = to_contact.norm(dim=-1, keepdim=True)
    normals, gaps = to_contact / distance, distance.squeeze(-1) - RADIUS
    helpful = limits.helpful_push(points, normals, pose, target)
    allowed = torch.where(helpful > 0, helpful.clamp(*limits.push), limits.harm)

    action = limits(wish, pusher, velocity, points, sides, pose, target, 0.1)
    return NearContact(pusher, velocity, sides, wish, action, normals, gaps, helpful, allowed)
