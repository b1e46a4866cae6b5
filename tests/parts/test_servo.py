"""The controller of the pusher: its closed form against the loop of its sub-steps, and its way."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from _inputs import BATCHES, normal
from _inputs.servo import GAINS, sub_steps

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL
from aicon_torch.models.pusht.benchmark import WORKSPACE
from aicon_torch.parts import PositionTarget, Servo
from aicon_torch.parts.servo import PusherMotion

each_gain = pytest.mark.parametrize("gains", GAINS, ids=str)


@each_gain
def test_the_servo_is_the_loop_of_its_sub_steps(gains: dict[str, Any]) -> None:
    servo = Servo.of(**gains)
    offset, velocity = 0.1 * normal(20), 0.3 * normal(20, seed=1)
    places, final = sub_steps(offset, velocity, **gains)

    for step, place in enumerate(places):
        by_offset = servo.displacement_by_offset[step] * offset
        by_velocity = servo.displacement_by_velocity[step] * velocity
        torch.testing.assert_close(by_offset + by_velocity, place)
    expected = servo.velocity_by_offset * offset + servo.velocity_by_velocity * velocity
    torch.testing.assert_close(expected, final)


@each_gain
def test_the_target_yields_the_velocity_that_was_asked_for(gains: dict[str, Any]) -> None:
    servo = Servo.of(**gains)
    a, velocity = 60 * PIXEL * normal(20, 2), 60 * PIXEL * normal(20, 2, seed=1)
    pusher = PIXEL * (256 + 20 * normal(20, 2, seed=2))
    lowest, highest = WORKSPACE

    target = PositionTarget(servo, WORKSPACE)(a, pusher, velocity, 0.1)
    assert ((target >= lowest) & (target <= highest)).all()
    inside = ((target > lowest) & (target < highest)).all(-1)
    assert inside.double().mean() > 0.5

    places, final = sub_steps(target - pusher, velocity, **gains)
    torch.testing.assert_close(places[-1][inside], 0.1 * a[inside])
    expected = servo.final_velocity(velocity, a, 0.1)
    torch.testing.assert_close(final[inside], expected[inside])


def test_without_a_servo_the_target_is_where_the_pusher_will_be() -> None:
    a, pusher = 60 * PIXEL * normal(20, 2), PIXEL * (256 + 20 * normal(20, 2, seed=2))
    target = PositionTarget(None, WORKSPACE)(a, pusher, normal(20, 2, seed=3), 0.1)
    torch.testing.assert_close(target, (pusher + 0.1 * a).clamp(*WORKSPACE))


@each_gain
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_the_way_is_that_of_the_sub_steps_part_by_part(
    gains: dict[str, Any], batch: tuple[int, ...]
) -> None:
    """Towards the target that is sent: where each of five equal parts of the sub-steps ends."""
    servo, motion = Servo.of(**gains), PusherMotion(Servo.of(**gains)).double()
    velocity, a = 0.3 * normal(*batch, 2), 0.3 * normal(*batch, 2, seed=1)
    moved = motion.update({"v_pusher": velocity, "a": a, "dt": 0.1})

    offset = servo.target_offset(a, velocity, 0.1)
    places, final = sub_steps(offset, velocity, **gains)
    each = len(places) // 5
    torch.testing.assert_close(moved["d_pusher"], torch.cat(places[each - 1 :: each], dim=-1))
    torch.testing.assert_close(moved["v_pusher"], final)


EITHER = pytest.mark.parametrize("servo", [Servo.of(), Servo.of(substeps=3), None], ids=str)


@EITHER
def test_the_way_ends_where_the_action_leads(servo: Servo | None) -> None:
    motion = PusherMotion(servo).double()
    velocity, a = 0.3 * normal(20, 2), 0.3 * normal(20, 2, seed=1)
    moved = motion.update({"v_pusher": velocity, "a": a, "dt": 0.1})

    assert moved["d_pusher"].shape == (20, 2 * motion.parts)
    torch.testing.assert_close(moved["d_pusher"][:, -2:], 0.1 * a)


@EITHER
def test_a_pusher_begins_at_rest_and_stays_there_without_an_action(servo: Servo | None) -> None:
    motion = PusherMotion(servo).double()
    start = motion.initial({})
    assert start["d_pusher"].shape == (2 * motion.parts,) and start["v_pusher"].shape == (2,)
    assert not any(value.any() for value in start.values())

    at_rest = torch.zeros(2, dtype=torch.float64)
    moved = motion.update({**start, "a": at_rest, "dt": 0.1})
    assert not any(value.any() for value in moved.values())


def test_without_a_servo_a_pusher_moves_evenly() -> None:
    a = normal(7, 2)
    moved = PusherMotion(None).double().update({"v_pusher": normal(7, 2), "a": a, "dt": 0.1})
    parts = moved["d_pusher"].unflatten(-1, (-1, 2)).diff(dim=-2)
    torch.testing.assert_close(parts, (0.1 * a / 5).unsqueeze(-2).expand_as(parts))
    assert torch.equal(moved["v_pusher"], a)


@EITHER
def test_an_anticipated_motion_is_the_motion(servo: Servo | None) -> None:
    """The one that a gradient leads through."""
    motion = PusherMotion(servo).double()
    a = normal(4, 2).requires_grad_()
    values = {"v_pusher": 0.3 * normal(4, 2, seed=1), "a": a, "dt": 0.1}
    moved = motion.update(values | {"a": a.detach()})

    for name in motion.outputs:
        anticipated = motion(values, name)
        torch.testing.assert_close(anticipated, moved[name])
        assert anticipated.requires_grad


def test_the_pusher_moves_as_the_model_believes() -> None:
    """In the open: its displacement is the action's, and its velocity follows the model's."""
    env, policy, memory = gym.make("aicon/PushT-v0"), make_policy("pusht"), None
    state = [20.0, 480.0, 420.0, 60.0, 0.3]
    observation, info = env.reset(seed=0, options={"reset_to_state": state})

    for _ in range(4):
        before = observation["agent_pos"]
        action, memory = policy.predict(observation, memory)
        observation, _, _, _, info = env.step(action)
        assert info["n_contacts"] == 0

        moved = 0.1 * memory["a"].numpy() / PIXEL
        np.testing.assert_allclose(observation["agent_pos"] - before, moved, atol=0.3)
        velocity = Servo.of().final_velocity(memory["v_pusher"], memory["a"], 0.1)
        np.testing.assert_allclose(info["vel_agent"], velocity.numpy() / PIXEL, atol=6.0)
