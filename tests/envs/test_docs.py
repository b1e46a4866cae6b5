"""What the docstrings of the environments say is what they do."""

import dataclasses
import inspect
from typing import Any

import gymnasium as gym
import pytest

pytest.importorskip("pymunk")
pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.arm_push import ArmPushEnv
from aicon_envs.nav2d import Nav2DEnv, Nav2DVectorEnv, Physics
from aicon_envs.pusht import PushTEnv, TaskSettings
from aicon_envs.pusht.settings import JUMP_INTERVAL, KICK
from aicon_envs.reach import ReachEnv

IDS = {
    "aicon/Nav2D-v0": (Nav2DEnv, Nav2DVectorEnv),
    "aicon/PushT-v0": (PushTEnv, None),
    "aicon/PandaPush-v0": (ArmPushEnv, None),
    "aicon/ArmPush-v0": (ArmPushEnv, None),
    "aicon/Reach-v0": (ReachEnv, None),
}


def arguments(kind: Any) -> dict[str, inspect.Parameter]:
    return dict(inspect.signature(kind).parameters)


@pytest.mark.parametrize("kind", [Nav2DEnv, PushTEnv, ArmPushEnv, ReachEnv])
def test_every_argument_is_in_the_docstring(kind: Any) -> None:
    settings: list[Any] = {Nav2DEnv: [Physics], PushTEnv: [TaskSettings]}.get(kind, [])
    names = [name for name in arguments(kind) if name not in ("physics", "settings")]
    names += [field.name for each in settings for field in dataclasses.fields(each)]

    documented = inspect.getdoc(kind) or ""
    assert [name for name in names if f"`{name}`" not in documented] == []


@pytest.mark.parametrize("env_id", IDS)
def test_the_time_limit_is_the_one_that_is_told(env_id: str) -> None:
    limit = gym.spec(env_id).max_episode_steps
    single, vector = IDS[env_id]
    assert limit is not None
    assert f"limit is {limit:,} steps" in " ".join((inspect.getdoc(single) or "").split())
    if vector is not None:
        assert arguments(vector)["max_episode_steps"].default == limit


def test_numbers_in_the_docstrings_are_the_defaults() -> None:
    arm, pushing, moving = (
        " ".join((inspect.getdoc(kind) or "").split()) for kind in (ArmPushEnv, PushTEnv, Nav2DEnv)
    )
    defaults = {name: each.default for name, each in arguments(ArmPushEnv).items()}
    assert f"{defaults['mass']:g} kg and {defaults['friction']:g}" in arm
    assert f"standard deviation, {1e3 * defaults['depth_noise']:g} mm" in arm
    assert f"standard deviation, {defaults['force_noise']:g} N" in arm
    assert f"standard deviation, {defaults['joint_noise']:.0e} rad".replace("e-04", "e-4") in arm
    assert f"({defaults['height']}, {defaults['width']}, 3) uint8" in arm
    fastest = ArmPushEnv(obs_type="pose").action_space.high
    assert f"for a Panda {fastest[0]:.4g} (joints 1 to 4) and {fastest[-1]:.4g} (5 to 7)" in arm

    (fewest, most), physics = JUMP_INTERVAL, Physics()
    assert f"{fewest} to {most} steps after the last" in pushing
    assert f"by up to {KICK[0]:g} px and {KICK[1]:g} rad" in pushing
    assert f"`dt` = {physics.dt:g} s" in moving
