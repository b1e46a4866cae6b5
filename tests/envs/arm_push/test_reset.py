"""How episodes of the arm start."""

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from aicon_envs.arm_push import ArmPushEnv


@pytest.fixture(scope="module")
def env() -> ArmPushEnv:
    return ArmPushEnv(obs_type="pose")


@pytest.mark.parametrize("seed", range(8))
def test_episodes_start_upright_beside_the_object_and_within_limits(
    env: ArmPushEnv, seed: int
) -> None:
    _, info = env.reset(seed=seed)
    assert not info["is_success"] and not info["collision"] and not info["fallen"]
    assert info["limit_margin"] > 0.1
    assert info["tip"][2] == pytest.approx(0.02, abs=1e-3)
    assert 0.48 <= info["object_pose"][0] <= 0.60
    assert abs(info["object_pose"][1]) <= 0.15


def test_options_set_poses_and_tip(env: ArmPushEnv) -> None:
    pose, target, tip = (0.5, 0.1, 1.0), (0.55, -0.1, -2.0), (0.6, -0.15)
    options = {"object_pose": pose, "target_pose": target, "tip": tip, "yaw": 0.2}
    _, info = env.reset(seed=0, options=options)

    np.testing.assert_allclose(info["object_pose"], pose, atol=2e-3)
    np.testing.assert_array_equal(info["target_pose"], target)
    np.testing.assert_allclose(info["position"], tip, atol=2e-3)


def test_an_option_changes_nothing_but_what_it_names(env: ArmPushEnv) -> None:
    _, usual = env.reset(seed=3)
    _, info = env.reset(seed=3, options={"object_pose": (0.5, 0.1, 1.0)})
    np.testing.assert_array_equal(info["target_pose"], usual["target_pose"])


def test_an_unknown_option_lists_the_known_ones(env: ArmPushEnv) -> None:
    with pytest.raises(ValueError, match="unknown option goal; valid options are object_pose"):
        env.reset(options={"goal": 1})


def test_without_a_place_for_the_tip_the_error_names_the_way_out(env: ArmPushEnv) -> None:
    with pytest.raises(ValueError, match="name one as the option tip"):
        env.reset(seed=0, options={"object_pose": (5.0, 5.0, 0.0)})


def test_a_tip_out_of_reach_is_an_error(env: ArmPushEnv) -> None:
    with pytest.raises(ValueError, match="no joint angles reach the tip"):
        env.reset(seed=0, options={"tip": (3.0, 0.0)})
