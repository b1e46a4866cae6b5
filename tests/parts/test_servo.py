"""The controller of the pusher: its closed form against the loop of its sub-steps."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from _inputs import normal
from _inputs.pushing import uniform
from _inputs.servo import GAINS, sub_steps
from torch import Tensor

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL
from aicon_torch.models.pusht.benchmark import WORKSPACE
from aicon_torch.parts import PositionTarget, Servo

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
def test_no_sub_step_goes_farther_than_the_farthest(gains: dict[str, Any]) -> None:
    """And one mm more would, unless the bound itself is what is in the way."""
    servo = Servo.of(**gains)
    bound, speed = 0.04 * uniform(500), 1.5 * (uniform(500, seed=1) - 0.5)
    farthest = servo.largest_displacement(bound, speed)
    assert (farthest <= bound).all()

    def largest(end: Tensor) -> Tensor:
        reached = servo.displacement_by_velocity[-1] * speed
        offset = (end - reached) / servo.displacement_by_offset[-1]
        return torch.stack(sub_steps(offset, speed, **gains)[0]).amax(0)

    assert (largest(farthest) <= bound + 1e-12).all()
    assert (largest(farthest + 0.001) > bound).all()
    assert 0.05 < (farthest < bound - 1e-12).double().mean() < 0.95


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
