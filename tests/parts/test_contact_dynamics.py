"""What a push does to an object: force and torque, and what the environment's physics do."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import normal
from _inputs.pushing import RADIUS, SHAPES, body_of, poses

from aicon_envs.pusht import OBJECTS
from aicon_envs.pusht.simulation import Simulation
from aicon_torch.models.pusht import PIXEL
from aicon_torch.models.pusht.benchmark import T_WIDTH
from aicon_torch.parts import ContactDynamics, ContactOptions, PoseMotion
from aicon_torch.parts.servo import even_motion

CONTACT = ContactOptions(size=T_WIDTH)


@pytest.mark.parametrize("keypoints", SHAPES.values(), ids=SHAPES.keys())
def test_a_push_moves_the_contact_with_it(keypoints: Any) -> None:
    """By as much as the push along its normal, without friction.

    Force and torque (n, λ) act on the masses (1, r²).
    """
    body = body_of(keypoints)
    pose, turn = poses(20), normal(20, 7, 1, seed=1)
    points = pose[:, None, :2] + 60 * PIXEL * normal(20, 7, 2, seed=2)
    normals = torch.cat((turn.cos(), turn.sin()), dim=-1)
    response = CONTACT.dynamics(body).response(pose, points, normals)

    arm = points - pose[:, None, :2]
    swing = response[..., 2:] * torch.stack((-arm[..., 1], arm[..., 0]), dim=-1)
    along = ((response[..., :2] + swing) * normals).sum(-1)
    torch.testing.assert_close(along, torch.ones(20, 7, dtype=torch.float64))

    torque = arm[..., 0] * normals[..., 1] - arm[..., 1] * normals[..., 0]
    force = response[..., :2].norm(dim=-1)
    torch.testing.assert_close(response[..., :2], force.unsqueeze(-1) * normals)
    torch.testing.assert_close(body.radius_of_gyration**2 * response[..., 2], force * torque)


def test_the_effects_differ_in_how_far_they_turn() -> None:
    """A contact 30 px beside the line through the centre, 40 px before it."""
    body = body_of()
    length, gyration = CONTACT.rotation_length(body), body.radius_of_gyration
    pose = torch.zeros(3, dtype=torch.float64)
    points = PIXEL * torch.tensor([[30.0, -40.0]], dtype=torch.float64)
    normals = torch.tensor([[0.0, 1.0]], dtype=torch.float64)

    def turn_by(effect: Any) -> float:
        dynamics = dataclasses.replace(CONTACT, effect=effect).dynamics(body)
        effects = dynamics.effects(pose, points, normals)
        return float(effects[0, 2] / effects[0, 1])

    assert turn_by("quasi_static") == pytest.approx(30 * PIXEL / gyration**2)
    assert turn_by("angle") == pytest.approx(math.atan2(30, 40) / length)


def test_contacts_give_the_gradient_and_the_pose_stays_where_it_is() -> None:
    """∂g/∂p = s h·Δ of each: of the intended where it lowers the cost, else of the other."""
    body = body_of()
    dynamics = CONTACT.dynamics(body)
    (pose,) = poses(1)
    keypoints = body.keypoints_at(pose)
    sides = body.sides(keypoints)
    points = (sides[:, :2] + sides[:, 2:]) / 2
    likelihood = torch.full((8, 2), 0.5, dtype=torch.float64, requires_grad=True)

    moved = dynamics(keypoints, points, likelihood, sides)
    error = torch.remainder(moved - pose + 1.0, 2 * math.pi) - 1.0
    torch.testing.assert_close(error, torch.zeros(3, dtype=torch.float64), rtol=0, atol=1e-12)

    (slope,) = torch.autograd.grad(moved[0], likelihood)
    normals = torch.stack((sides[:, 1] - sides[:, 3], sides[:, 2] - sides[:, 0]), dim=-1)
    effect = dynamics.step * dynamics.effects(pose, points, torch.nn.functional.normalize(normals))
    along_x = effect[:, 0]
    torch.testing.assert_close(slope[:, 0], along_x.clamp(max=0.0))
    torch.testing.assert_close(slope[:, 1], along_x.clamp(min=0.0))


@pytest.mark.parametrize("name", ["T", "L"])
def test_the_object_goes_where_the_model_believes(name: str) -> None:
    """Pushed in the environment's physics, a few px at a time, at places of several sides."""
    body = body_of(None if name == "T" else (OBJECTS[name].keypoints * PIXEL).tolist())
    motion = PoseMotion(ContactDynamics(body, rotation_length=1.0, step=PIXEL), RADIUS)
    frame = torch.tensor([250 * PIXEL, 230 * PIXEL, 0.4], dtype=torch.float64)
    before = body.pose_of_frame(frame)
    scale = torch.tensor([1.0, 1.0, body.radius_of_gyration], dtype=torch.float64)
    to_pixels = np.array([1 / PIXEL, 1 / PIXEL, 1.0])

    errors, moves = [], []
    for side in body.sides(body.keypoints_at(before)):
        for share in (0.2, 0.5, 0.8):
            start, along = side[:2], side[2:] - side[:2]
            inward = torch.stack((-along[1], along[0])) / along.norm()
            pusher = start + share * along - (RADIUS + 2 * PIXEL) * inward
            action = PIXEL * (70 * inward + 10 * along / along.norm())

            pose = tuple((frame.numpy() * to_pixels).tolist())
            world = Simulation(OBJECTS[name], tuple((pusher / PIXEL).tolist()), pose)
            far_ahead = tuple(((pusher + 1e3 * action) / PIXEL).tolist())
            world.steer(far_ahead, limit=float(action.norm()) / PIXEL)
            after = body.pose_of_frame(torch.as_tensor(np.array(world.pose) / to_pixels))

            believed = motion(before, pusher + 0.1 * action, even_motion(0.1 * action))
            errors.append(float((scale * (believed - after)).norm()))
            moves.append(float((scale * (after - before)).norm()))

    assert min(moves) > 2 * PIXEL
    assert np.median(errors) < 0.6 * PIXEL
    assert np.median(np.array(errors) / np.array(moves)) < 0.15
