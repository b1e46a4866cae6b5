"""The speed limit near the object, by hand."""

import pytest
import torch
from _inputs import normal
from _inputs.pushing import RADIUS, body_of, outside, poses

from aicon_torch.parts import ContactOptions, SlowApproachOptions, closest_point

CONTACT = ContactOptions(size=0.12)


@pytest.mark.parametrize("distance", [0.0, 0.005, 1.0])
def test_the_slow_approach_limits_the_speed_alone(distance: float) -> None:
    """(1 − p)·0.06 + p·0.03·clip(g/0.03, 0.1, 1) m a step; the direction stays."""
    body = body_of()
    slow = SlowApproachOptions().limit(CONTACT.rotation_length(body), RADIUS, CONTACT.size)
    pose, wish = poses(100), 0.5 * normal(100, 2)
    target = pose + torch.tensor([distance, 0.0, 0.0])
    pusher = outside(body, pose, 0.06)
    points = closest_point(pusher.unsqueeze(-2), body.sides(body.keypoints_at(pose)))

    action = slow(wish, pusher, points, pose, target, 0.1)

    gap = (points - pusher.unsqueeze(-2)).norm(dim=-1).amin(-1) - RADIUS
    p = torch.exp(-gap / 0.02)
    share = min(max(distance / 0.03, 0.1), 1.0)
    limit = (1 - p) * 0.6 + p * 0.3 * share
    speed = torch.minimum(wish.norm(dim=-1), limit)
    torch.testing.assert_close(action.norm(dim=-1), speed, rtol=1e-6, atol=0)
    cosine = torch.cosine_similarity(action, wish)
    torch.testing.assert_close(cosine, torch.ones(100, dtype=torch.float64))
