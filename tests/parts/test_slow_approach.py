"""The speed limit near the object, by hand."""

import pytest
import torch
from _inputs import normal
from _inputs.pushing import RADIUS, body_of, outside, poses

from aicon_torch.models.pusht.benchmark import PIXEL, T_WIDTH
from aicon_torch.parts import ContactOptions, SlowApproachOptions, closest_point

CONTACT = ContactOptions(size=T_WIDTH)


@pytest.mark.parametrize("distance", [0, 5, 1000])
def test_the_slow_approach_limits_the_speed_alone(distance: int) -> None:
    """(1 − p)·60 + p·30·clip(g/30, 0.1, 1) px a step; the direction stays."""
    body = body_of()
    slow = SlowApproachOptions().limit(CONTACT.rotation_length(body), RADIUS, CONTACT.size)
    pose, wish = poses(100), 500 * PIXEL * normal(100, 2)
    target = pose + torch.tensor([distance * PIXEL, 0.0, 0.0])
    pusher = outside(body, pose, 60 * PIXEL)
    points = closest_point(pusher.unsqueeze(-2), body.sides(body.keypoints_at(pose)))

    action = slow(wish, pusher, points, pose, target, 0.1)

    gap = (points - pusher.unsqueeze(-2)).norm(dim=-1).amin(-1) - RADIUS
    p = torch.exp(-gap / (20 * PIXEL))
    share = min(max(distance / 30, 0.1), 1.0)
    limit = ((1 - p) * 600 + p * 300 * share) * PIXEL
    speed = torch.minimum(wish.norm(dim=-1), limit)
    torch.testing.assert_close(action.norm(dim=-1), speed, rtol=1e-6, atol=0)
    cosine = torch.cosine_similarity(action, wish)
    torch.testing.assert_close(cosine, torch.ones(100, dtype=torch.float64))
