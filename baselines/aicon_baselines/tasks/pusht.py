"""The evaluation task "pusht": an object pushed to a pose, as in gym-pusht, and variants of it.

The environment's seed is the episode's seed, so that starts are those of gym-pusht with the same
seed. Repeats differ in their noise only.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv

from aicon_baselines.ablations import PIXEL, PUSHT
from aicon_baselines.evaluation.errors import find_known
from aicon_baselines.evaluation.task import Episode, Lesson, Look, Task
from aicon_baselines.tasks.faults import FAULTS, Faults, at_once, longest
from aicon_baselines.tasks.side_by_side import side_by_side
from aicon_baselines.tasks.upstream import UpstreamPushT
from aicon_envs.pusht import OBJECTS, PushTEnv
from aicon_envs.pusht.clutter import Clutter, Kind
from aicon_envs.pusht.wrappers import Delay, Dropout, SensorNoise

_UPSTREAM = "upstream"
_PICTURE = Path(__file__).parents[2] / "checkpoints" / "pusht_picture"
_PIXELS = {"obs_type": "pixels_agent_pos"}
_SMALL = {"observation_width": 48, "observation_height": 48}
_CLUTTER: tuple[Kind, ...] = ("distractors", "covered", "hidden")
_SPEED = 800.0  # the usual speed limit of the policy, px/s; the benchmark has none
_OBJECTS = ("L", "U", "Z", "H", "plus", "quadrilateral")

# The arguments of the environment in each condition.
_ARGUMENTS: dict[str, dict[str, Any]] = {
    "deterministic": {},
    "noise_2": {"action_noise": 2.0},
    "noise_4": {"action_noise": 4.0},
    "random_goal": {"goal_pose": "random", "observe_goal": True},
    "half_speed": {"velocity_limit": 0.5 * _SPEED},
    "eighth_speed": {"velocity_limit": 0.125 * _SPEED},
    "double_speed": {"velocity_limit": 2.0 * _SPEED},
    "quasi_static_50": {"velocity_limit": 50.0},
    "quasi_static_25": {"velocity_limit": 25.0},
    "quasi_static_50_noise_2": {"velocity_limit": 50.0, "action_noise": 2.0},
    "quasi_static_25_noise_2": {"velocity_limit": 25.0, "action_noise": 2.0},
    **{f"object_{name}": {"object": name} for name in _OBJECTS},
    "kicks": {"kick_interval": 50},
    "dropout": {"wrappers": [partial(Dropout, probability=0.5)]},
    "delay": {"wrappers": [partial(Delay, steps=3)]},
    "keypoint_noise": {"wrappers": [partial(SensorNoise, sigma=2.0)]},
    "pixels": _PIXELS,
    "pixels_48": {**_PIXELS, **_SMALL},
    **{
        f"pixels_{kind}": {**_PIXELS, "wrappers": [partial(Clutter, kind=kind)]}
        for kind in _CLUTTER
    },
    **{
        f"pixels_48_{kind}": {**_PIXELS, **_SMALL, "wrappers": [partial(Clutter, kind=kind)]}
        for kind in _CLUTTER
    },
    "goal_jumps": {"goal_jumps": 2, "observe_goal": True},
    _UPSTREAM: {},
    **{fault: {} for fault in FAULTS},
}
# What a policy knows of the sensors in a condition.
_SENSORS: dict[str, dict[str, Any]] = {
    "delay": {"delay": 3},
    "keypoint_noise": {"keypoint_noise": 2.0 * PIXEL},
}
_FAULTS = Faults(
    dt=0.1,
    late=3,
    jitter=3,
    onset=(20, 60),
    pause=50,
    bias={"environment_state": 5.0},
    ranges={"environment_state": (0.0, 512.0), "agent_pos": (0.0, 512.0)},
    told={"keypoint_offset": 5.0 * PIXEL},
)
_NOISY = (
    *(fault for fault in FAULTS if fault not in ("late", "bias", "uneven")),  # those draw nothing
    "noise_2",
    "noise_4",
    "quasi_static_50_noise_2",
    "quasi_static_25_noise_2",
    "kicks",
    "dropout",
    "keypoint_noise",
    *(f"pixels_{kind}" for kind in _CLUTTER),
    *(f"pixels_48_{kind}" for kind in _CLUTTER),
)


def _make_env(count: int, condition: str, horizon: int, **options: Any) -> VectorEnv[Any, Any, Any]:
    if condition == _UPSTREAM:
        return side_by_side(partial(UpstreamPushT, **options), count, horizon)

    arguments = find_known("condition", at_once(condition)[0], _ARGUMENTS) | options
    layers = arguments.pop("wrappers", ())

    def make_one() -> gymnasium.Env[Any, Any]:
        env: gymnasium.Env[Any, Any] = PushTEnv(**arguments)
        for layer in layers:
            env = layer(env)
        return env

    env = side_by_side(make_one, count, longest(condition, horizon))
    return _FAULTS.wrap(env, condition)


def _reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    noises = [{"noise_seed": episode.noise_seed} if episode.repeat else {} for episode in episodes]
    return {"seed": [episode.seed for episode in episodes], "options": {"per_env": noises}}


def _policy_options(condition: str) -> dict[str, Any]:
    """Tell the policy what is not as usual: outline, sensors, pictures, speed limit, goal.

    The environment's lengths are px; the policy's are m.
    """
    arguments = find_known("condition", at_once(condition)[0], _ARGUMENTS)
    options = {**_SENSORS.get(condition, {}), **_FAULTS.policy_options(condition)}
    if "object" in arguments:
        outline = OBJECTS[arguments["object"]]
        corners = PIXEL * np.asarray(outline.keypoints, np.float64)
        options["keypoints"] = tuple(map(tuple, corners.tolist()))
        options["outline_order"] = tuple(int(index) for index in outline.border)

    if "obs_type" in arguments:
        weights = "weights_48.pt" if "observation_width" in arguments else "weights.pt"
        options |= {"picture": _PICTURE / weights, "push_noise": 0.2}
    if "observe_goal" in arguments:
        options["observe_goal"] = True
    if "velocity_limit" in arguments:
        options["max_speed"] = PIXEL * arguments["velocity_limit"]
    return options


TASK = Task(
    name="pusht",
    time_step=0.1,
    horizon=1000,
    chunk_size=100,
    maps=("uniform",),
    conditions=tuple(_ARGUMENTS),
    faults=FAULTS,
    make_env=_make_env,
    reset_arguments=_reset_arguments,
    policy_options=_policy_options,
    noiseless=tuple(name for name in _ARGUMENTS if name not in _NOISY),
    length_unit="px",
    time_unit="steps",
    milestones=(200, 250, 300),
    model="pusht",
    presets=("aicon", "paper_literal", "steepest", "potential_field"),
    ablations=PUSHT,
    # Where the goal can be dragged, the policy has to see it.
    look=Look(
        scene="aicon_baselines.view.pusht:PushScene",
        surroundings="aicon_baselines.worlds.surroundings:around_pushing",
        options={"observe_goal": True},
    ),
    lesson=Lesson(
        words="Push the T onto its target.",
        seen={
            "observation.state": ("agent_pos",),
            "observation.environment_state": ("environment_state",),
            "observation.image": ("pixels",),
        },
        done={"target": 2},
    ),
)
