"""What the pusher does with an action."""

import numpy as np
import pytest
from _pusht_env import APART

from aicon_envs.pusht import PushTEnv


def test_targets_outside_the_world_are_clipped() -> None:
    env = PushTEnv()
    env.reset(options={"reset_to_state": APART})

    for _ in range(50):
        observation, _, _, _, _ = env.step(np.array([-1e6, 40.0]))
    assert observation["agent_pos"] == pytest.approx([0.0, 40.0], abs=1e-3)


@pytest.mark.parametrize("limit", [50.0, 200.0])
def test_the_velocity_limit_holds(limit: float) -> None:
    env = PushTEnv(velocity_limit=limit)
    _, info = env.reset(options={"reset_to_state": APART})
    target = np.array([400.0, 500.0], np.float32)

    speeds = []
    for _ in range(5):
        before = info["pos_agent"]
        _, _, _, _, info = env.step(target)
        speeds.append(float(np.linalg.norm(info["pos_agent"] - before)) / 0.1)
    assert max(speeds) <= limit + 1e-9 and speeds[-1] == pytest.approx(limit)


def test_action_noise_has_the_stated_size() -> None:
    env = PushTEnv(action_noise=3.0, velocity_limit=1e4)
    quiet = PushTEnv(velocity_limit=1e4)
    action = np.array([256.0, 256.0], np.float32)
    options = {"reset_to_state": [156.0, 256.0, 400.0, 100.0, 0.0]}

    # From rest, the PD controller covers a fixed share of the target offset in one step.
    _, start = quiet.reset(options=options)
    _, _, _, _, moved = quiet.step(action)
    share = (moved["pos_agent"] - start["pos_agent"])[0] / 100.0

    errors = []
    for seed in range(400):
        env.reset(seed=seed, options=options)
        _, _, _, _, info = env.step(action)
        errors.append((info["pos_agent"] - moved["pos_agent"]) / share)

    np.testing.assert_allclose(np.std(errors, axis=0), 3.0, rtol=0.1)
    np.testing.assert_allclose(np.mean(errors, axis=0), 0.0, atol=0.5)
