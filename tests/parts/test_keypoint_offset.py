"""An offset of all keypoints shows where a pusher touches the object."""

import torch
from _inputs.pushing import RADIUS, body_of, poses
from torch import Tensor

from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import KeypointOffset

BODY = body_of()
OFFSET = torch.tensor([5.0, -3.0], dtype=torch.float64) * PIXEL
PART = KeypointOffset(BODY, RADIUS, deviation=PIXEL, least_motion=0.5 * PIXEL)


def touching(pose: Tensor, side: int) -> Tensor:
    """Places ``(count, 2)`` of a pusher that touches the middle of a side."""
    start, end = BODY.sides(BODY.keypoints_at(pose))[:, side].split(2, -1)
    along = (end - start) / torch.linalg.vector_norm(end - start, dim=-1, keepdim=True)
    outward = torch.stack((along[:, 1], -along[:, 0]), dim=-1)
    return (start + end) / 2 + RADIUS * outward


def seen(pose: Tensor) -> Tensor:
    """The keypoints ``(count, 2K)`` as they are seen."""
    return (BODY.keypoints_at(pose) + OFFSET).flatten(-2)


def test_with_the_right_offset_a_pusher_that_touches_has_no_gap() -> None:
    pose = poses(20)
    belief = torch.cat((OFFSET.expand(20, 2), pose), dim=-1)
    for side in (0, 1, 4):
        gap = PART.gap(belief, seen(pose), touching(pose, side))
        torch.testing.assert_close(gap, torch.zeros_like(gap), atol=1e-9, rtol=0)


def test_a_gap_tells_nothing_while_the_object_rests() -> None:
    pose = poses(5)
    last = BODY.registration(seen(pose).unflatten(-1, (-1, 2)))
    belief = torch.cat((OFFSET.expand(5, 2), last), dim=-1)

    spread = torch.eye(5, dtype=torch.float64).expand(5, 5, 5) * PIXEL**2
    variance = PART.variance(belief, spread, seen(pose), pose[:, :2] + 1.0)
    assert (variance > 1e5 * PIXEL**2).all()


def test_pushes_on_several_sides_tell_the_offset() -> None:
    """After each the object has moved, and the pusher is where it touches."""
    model = make_policy("pusht", keypoint_offset=5 * PIXEL).model
    estimator = model.owners["x_offset"]
    pose = poses(4)
    values = {"z_keypoints": seen(pose), "z_pusher": touching(pose, 0)}
    values |= estimator.initial(values)
    values["P_offset"] = values["P_offset"].expand(4, 5, 5)

    for step in range(24):
        pose = pose + torch.tensor([PIXEL, -PIXEL, 0.01], dtype=torch.float64)
        values |= {"z_keypoints": seen(pose), "z_pusher": touching(pose, (0, 1, 4)[step % 3])}
        values |= estimator.update({**values, "dt": 0.1})

    error = (values["x_offset"][:, :2] - OFFSET).abs()
    assert (error < 0.5 * PIXEL).all()
