"""The evaluation task "arm_push": an arm that pushes an object to a pose.

It sees the object with the camera in its hand, or is told where it is. The arm is a Panda unless
the condition names another one.

The environment's seed is the episode's seed. Repeats have other noise, start and target: a seed of
their own.
"""

import functools
import math
from collections.abc import Sequence
from functools import partial
from typing import Any

from gymnasium.vector import VectorEnv

from aicon_baselines.ablations import ARM_PUSH
from aicon_baselines.evaluation.errors import find_known
from aicon_baselines.evaluation.task import Episode, Look, Measure, Task
from aicon_baselines.tasks.faults import FAULTS, Faults, at_once, longest
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_envs.arm_push import ArmPushEnv

# The arguments of the environment in each condition. Near the base the arm meets its joint limits
# and itself; far from it the arm becomes straight.
_ARGUMENTS: dict[str, dict[str, Any]] = {
    "camera": {},
    "true_pose": {"obs_type": "pose"},
    "half_mass": {"mass": 0.25},
    "double_mass": {"mass": 1.0},
    "half_friction": {"friction": 0.175},
    "more_friction": {"friction": 0.525},
    "object_L": {"object": "L"},
    "image_delay": {"image_delay": 0.1},
    "kick": {"kick_time": 3.0},
    "hard_kick": {"kick_time": 3.0, "kick_force": 6.0},
    "near_true_pose": {"area": ((0.36, 0.44), (-0.1, 0.1)), "obs_type": "pose"},
    "far_true_pose": {"area": ((0.62, 0.70), (-0.1, 0.1)), "obs_type": "pose"},
    "ur5_true_pose": {"robot": "ur5", "obs_type": "pose"},
    **{fault: {"obs_type": "pose"} for fault in FAULTS},
}
_FAULTS = Faults(
    dt=0.01,
    late=10,
    jitter=10,
    onset=(100, 1000),
    pause=500,
    bias={"object_pose": 0.005},
    ranges={"q": (-2.8, 2.8), "object_pose": (-1.0, 1.0)},
    tells_action=True,
)


def _make_env(count: int, condition: str, horizon: int, **options: Any) -> VectorEnv[Any, Any, Any]:
    arguments = find_known("condition", at_once(condition)[0], _ARGUMENTS) | options
    env = side_by_side(partial(ArmPushEnv, **arguments), count, longest(condition, horizon))
    return _FAULTS.wrap(env, condition)


def _reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    seeds = [episode.noise_seed if episode.repeat else episode.seed for episode in episodes]
    return {"seed": seeds}


def _policy_options(condition: str) -> dict[str, Any]:
    """Tell the policy its own body, its sensor and the object's outline, not mass nor friction."""
    arguments = find_known("condition", at_once(condition)[0], _ARGUMENTS)
    late = _FAULTS.policy_options(condition)
    delay = round(arguments.get("image_delay", 0.0) / _FAULTS.dt)
    return {**late, "camera.delay": delay, **_of_the_world(**arguments)}


@functools.cache
def _of_the_world(**arguments: Any) -> dict[str, Any]:
    """What a policy is told of the environment with these arguments."""
    from aicon_torch.models.arm_push import PushingRobot

    env = ArmPushEnv(**arguments)
    return {
        "robot": PushingRobot.from_description(env.description()),
        "corners": tuple((float(x), float(y)) for x, y in env.object.corners),
        "sensing": "pose" if env.obs_type == "pose" else "camera",
    }


TASK = Task(
    name="arm_push",
    time_step=0.01,
    horizon=18_000,
    chunk_size=10,
    maps=("table",),
    conditions=tuple(_ARGUMENTS),
    faults=FAULTS,
    make_env=_make_env,
    reset_arguments=_reset_arguments,
    policy_options=_policy_options,
    milestones=(6_000, 12_000),
    measures=(
        Measure("angle", "median angle at the end", "{:.1f}°", math.degrees(1.0)),
        Measure("limit_margin", "least distance to a joint's limit", "{:.3f} rad", least=True),
        Measure(
            "self_distance",
            "least distance of the robot to itself",
            "{:.0f} mm",
            scale=1e3,
            least=True,
        ),
    ),
    model="arm_push",
    presets=("aicon", "steepest", "potential_field"),
    ablations=ARM_PUSH,
    timed_condition="true_pose",  # so that no image is read
    look=Look(
        scene="aicon_baselines.view.arm_push:ArmPushScene",
        surroundings="aicon_baselines.worlds.surroundings:around_an_arm",
    ),
)
