"""The gradients at the pusher, against closed forms written by hand."""

import math
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import lean
from _inputs.pushing import NOTCHED, RADIUS, TRIANGLE, in_pixels, outside, poses, wandering
from numpy.typing import NDArray

from aicon_torch import DirectDescent, make_policy
from aicon_torch.models import pusht, replace_options
from aicon_torch.models.pusht import PIXEL, rigid_object
from aicon_torch.parts import RigidObject

Vector = NDArray[Any]


def gradient_of_the_goal(pose: Vector, target: Vector, length: float) -> Vector:
    """h = ∂g/∂x_obj with g = ‖(Δx, Δy, LΔθ)‖."""
    error = pose - target
    error[2] = length * ((error[2] + np.pi) % (2 * np.pi) - np.pi)
    scale = np.array([1.0, 1.0, length])
    return np.asarray(error / np.sqrt(error @ error) * scale)


def effect_of_a_contact(
    arm: Vector, tangent: Vector, normal: Vector, gyration: float, contact: pusht.Options
) -> tuple[Vector, Vector]:
    """Δ of a contact at an arm from the centre, and ∂Δ for each metre along the side."""
    length = contact.contact.rotation * gyration
    lever = arm[0] * normal[1] - arm[1] * normal[0]
    size = np.linalg.norm(arm)

    if contact.contact.effect == "angle":  # from the normal to the line to the centre
        facing = -(arm @ normal)  # the same all along the side
        effect = np.array([*normal, np.arctan2(lever, facing) / length])
        return effect, np.array([0.0, 0.0, facing / size**2 / length])

    # (n, λ/r²)/√(1 + (Lλ/r²)²), and λ grows by one metre a metre along the side
    k = gyration**-2.0
    scale = np.sqrt(1.0 + (length * k * lever) ** 2)
    direction = np.array([*normal, k * lever])
    slope_of_scale = (length * k) ** 2 * lever / scale**3
    return direction / scale, np.array([0.0, 0.0, k]) / scale - direction * slope_of_scale


def by_hand(
    pose: Vector, pusher: Vector, target: Vector, body: RigidObject, options: pusht.Options
) -> dict[str, Vector]:
    """p₁ = s b ∂P/∂q and p₂ = s P h·∂Δ/∂x at the pusher, for each side, and b itself.

    P is the likelihood that counts, by the sign of b = h·Δ or by its sigmoid.
    """
    contact, gyration = options.contact, body.radius_of_gyration
    step, aim = contact.step * contact.size, contact.aim * contact.size
    reach, reaction = contact.reach * contact.size, contact.reaction * contact.size
    h = gradient_of_the_goal(pose.copy(), target, contact.rotation * gyration)

    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[cos, -sin], [sin, cos]])
    corners = body.keypoints.numpy()[list(body.outline_order)] @ turn.T + pose[:2]

    found: dict[str, Vector] = {}
    for side, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        t = (end - start) / np.linalg.norm(end - start)
        n = np.array([-t[1], t[0]])
        share = (pusher - start) @ t / np.linalg.norm(end - start)
        inside = 0.0 < share < 1.0
        point = start + np.clip(share, 0.0, 1.0) * (end - start)
        effect, slope = effect_of_a_contact(point - pose[:2], t, n, gyration, options)
        b = h @ effect

        # The two likelihoods, and how they grow towards the contact.
        away, aimed = point - pusher, point - pusher - aim * n
        intended = np.exp(-(np.linalg.norm(aimed) - (RADIUS - aim)) / reach)
        happens = np.exp(-(np.linalg.norm(away) - RADIUS) / reaction)
        if contact.facing and not inside:
            happens *= max(n @ away / np.linalg.norm(away), 0.0)
        by_intended = intended / reach * aimed / np.linalg.norm(aimed)
        by_happens = happens / reaction * away / np.linalg.norm(away)

        # Which of them counts.
        wanted = 1.0 / (1.0 + np.exp(b / contact.intent)) if contact.intent else float(b < 0)
        slope_of_p = wanted * by_intended + (1.0 - wanted) * by_happens
        p = wanted * intended + (1.0 - wanted) * happens
        found[f"p_contact[{side}]"] = step * b * slope_of_p
        found[f"x_contact[{side}]"] = step * p * (h @ slope) * t * inside
        found[f"gain[{side}]"] = np.array([b, inside])
    return found


FORMS: dict[str, dict[str, Any]] = {
    "ours": {},
    "soft": {"contact.intent": 0.1},
    "soft and hot": {"contact.intent": 3.0, "contact.facing": False},
    "no aim": {"contact.effect": "angle", "contact.intent": 0.1, "contact.aim": 0.0},
    "angle": {"contact.effect": "angle", "contact.rotation": 1.0},
    "angle and soft": {"contact.effect": "angle", "keypoints": NOTCHED, "contact.intent": 0.3},
    "one likelihood for both": {
        "contact.reach": 1 / 12,
        "contact.aim": 0.0,
        "contact.facing": False,
    },
    "a triangle": {"keypoints": TRIANGLE, "contact.reach": 0.4},
    "a notch": {"keypoints": NOTCHED, "contact.effect": "angle", "contact.rotation": 0.7},
    "off its middle": {
        "keypoints": TRIANGLE,
        "center_of_mass": (10 * PIXEL, 5 * PIXEL),
        "radius_of_gyration": 25 * PIXEL,
    },
}


@pytest.mark.parametrize("changes", FORMS.values(), ids=FORMS.keys())
@pytest.mark.parametrize("by_row", [True, False])
def test_gradients_at_the_pusher_are_those_written_by_hand(
    changes: dict[str, Any], by_row: bool
) -> None:
    law = DirectDescent()  # takes its gradient at the estimates
    policy = make_policy("pusht", law=law, **changes, **{"resolution.by_row": by_row})
    options = replace_options(pusht.Options(), changes)
    body, pose = rigid_object(options), poses(30, seed=3)
    reading = in_pixels(body, pose, outside(body, pose, 60 * PIXEL, seed=4))
    trace = policy.trace(policy.predict(reading)[1])

    # Each gradient came over one contact, or over the two of one side.
    pusher = trace.quantities["x_pusher"]
    contacts = [path[-2].split("+") for path in pusher.paths]
    expected_contacts = {f"{x}_contact[{i}]" for x in "px" for i in range(len(body.keypoints))}
    assert {contact for merged in contacts for contact in merged} == expected_contacts

    kinds = set()
    for row in range(30):
        believed = (trace.values[name][row].numpy() for name in ("x_pose", "x_pusher", "x_target"))
        expected = by_hand(*believed, body, options)
        for index, merged in enumerate(contacts):
            gradient = pusher.gradients[row, index].numpy()
            total = sum(expected[contact] for contact in merged)
            np.testing.assert_allclose(gradient, total, rtol=1e-8, atol=1e-10)
        kinds |= {
            (gain[0] < 0, bool(gain[1]))
            for name, gain in expected.items()
            if name.startswith("gain")
        }
    assert len(kinds) == 4  # contacts that help and harm, inside a side and at its ends


def test_the_cost_is_the_distance_of_the_poses() -> None:
    """√(|Δc|² + (Lθ)²), θ the shorter way round; the target is a pose of the body frame."""
    body, pose = rigid_object(pusht.Options()), poses(50, seed=1)
    policy = lean("pusht")
    far = torch.full((50, 2), 20 * PIXEL, dtype=torch.float64)
    trace = policy.trace(policy.predict(in_pixels(body, pose, far))[1])

    frame = torch.tensor([256 * PIXEL, 256 * PIXEL, math.pi / 4], dtype=torch.float64)
    error = pose - body.pose_of_frame(frame)
    turn = (error[:, 2] + math.pi) % (2 * math.pi) - math.pi
    length = 1.55 * 3000**0.5 * PIXEL
    expected = (error[:, :2].square().sum(-1) + (length * turn) ** 2).sqrt()
    torch.testing.assert_close(trace.costs["push"], expected, rtol=0, atol=1e-9)


def test_a_step_is_explained() -> None:
    policy, memory = lean("pusht"), None
    for reading in wandering(3, 2):
        _, memory = policy.predict(reading, memory)
    assert memory is not None
    for row in range(2):
        explanation = policy.explain(memory, row)
        assert math.isfinite(explanation.goals["push"].predicted_change)
        path = explanation.quantities["x_pusher"].candidates[0].path
        assert path.startswith("push → x_obj → ")
        assert explanation.action["a"] == tuple(memory["a"][row].tolist())
