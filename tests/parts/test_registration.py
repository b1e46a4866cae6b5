"""Poses and keypoints: placed, registered, and how certain a registered pose is."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import normal
from _inputs.pushing import NOTCHED, SHAPES, body_of, poses, uniform
from torch import Tensor

from aicon_torch.parts import KeypointRegistration

everything = pytest.mark.parametrize("keypoints", SHAPES.values(), ids=SHAPES.keys())


@everything
@pytest.mark.parametrize("batch", [(), (5,), (2, 3)], ids=str)
def test_registration_recovers_the_pose(keypoints: Any, batch: tuple[int, ...]) -> None:
    body = body_of(keypoints)
    angle = math.pi * (2.0 * uniform(*batch, 1) - 1.0)
    pose = torch.cat((0.2 * normal(*batch, 2), angle), dim=-1)

    placed = body.keypoints_at(pose)
    assert placed.shape == (*batch, len(body.keypoints), 2)
    torch.testing.assert_close(body.registration(placed), pose)

    distances = torch.cdist(placed, placed)
    expected = torch.cdist(body.keypoints, body.keypoints)
    torch.testing.assert_close(distances, expected.expand_as(distances))


def test_registration_is_the_least_squares_fit() -> None:
    """No pose near it has a smaller sum of squares."""
    body = body_of()
    observed = body.keypoints_at(poses(10)) + 0.004 * normal(10, 8, 2, seed=3)
    fitted = body.registration(observed)

    def cost(pose: Tensor) -> Tensor:
        return (body.keypoints_at(pose) - observed).square().sum((-1, -2))

    leaf = fitted.clone().requires_grad_()
    (slope,) = torch.autograd.grad(cost(leaf).sum(), leaf)
    assert (slope.abs() < 1e-11 * torch.tensor([1.0, 1.0, 1.0])).all()
    for seed in range(20):
        shift = normal(10, 3, seed=seed) * torch.tensor([0.001, 0.001, 0.02])
        assert (cost(fitted) < cost(fitted + shift)).all()


@pytest.mark.parametrize("keypoints", [None, NOTCHED], ids=["T", "notched"])
def test_a_frame_is_turned_and_moved_with_its_body(keypoints: Any) -> None:
    """Its centre of mass is a point of the body."""
    body = body_of(keypoints)
    frame = torch.tensor([0.03, -0.02, 0.9], dtype=torch.float64)
    cos, sin = math.cos(0.9), math.sin(0.9)
    turn = torch.tensor([[cos, -sin], [sin, cos]], dtype=torch.float64)

    pose = body.pose_of_frame(frame)
    torch.testing.assert_close(pose[:2], frame[:2] + turn @ body.center_of_mass)
    assert pose[2] == 0.9
    corners = frame[:2] + (body.keypoints + body.center_of_mass) @ turn.T
    torch.testing.assert_close(body.keypoints_at(pose), corners)


@everything
def test_a_registered_pose_is_as_uncertain_as_its_keypoints_make_it(keypoints: Any) -> None:
    """The spread of 20,000 registrations of noisy keypoints, in the body frame."""
    body = body_of(keypoints)
    noise = 0.0005 * normal(20_000, len(body.keypoints), 2, seed=2)
    found = body.registration(body.keypoints + noise).var(0)
    expected = KeypointRegistration(body).variances(0.0005)
    np.testing.assert_allclose(found, expected, rtol=0.05)


def test_the_residual_is_zero_at_the_pose_that_is_seen_and_wraps() -> None:
    body = body_of()
    registration = KeypointRegistration(body)
    pose = poses(5)
    reading = body.keypoints_at(pose).flatten(-2)

    whole_turn = torch.tensor([0.0, 0.0, 2 * math.pi], dtype=torch.float64)
    for shift in (torch.zeros(3, dtype=torch.float64), whole_turn):
        residual = registration(pose + shift, reading)
        torch.testing.assert_close(residual, torch.zeros_like(pose), rtol=0, atol=1e-12)


def test_the_prior_is_the_first_reading_give_or_take_its_deviation() -> None:
    body = body_of()
    pose = body.registration(body.keypoints_at(poses(4)))
    mean, covariance = KeypointRegistration(body, prior_deviation=0.02).prior(
        body.keypoints_at(pose).flatten(-2)
    )
    torch.testing.assert_close(mean, pose)
    deviations = covariance.diagonal().sqrt().tolist()
    assert deviations == pytest.approx([0.02, 0.02, 0.02 / body.radius_of_gyration])
