"""Demonstrations: successful episodes of AICON, and what it makes of those of a student."""

from functools import cache
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.configs import (
    CHUNK_SIZE,
    AnyRecording,
    RecordingConfig,
    TaskRecordingConfig,
)
from aicon_baselines.agents.diffusion.corrector import Corrections, Corrector
from aicon_baselines.agents.diffusion.lerobot_names import ACTION, SHOWN, STATE
from aicon_baselines.agents.registry import compiled, factory
from aicon_baselines.evaluation.episodes import Start, run_episodes
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.tasks import load, side_by_side
from aicon_baselines.tasks.registry import lesson_of
from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, PushTEnv
from aicon_envs.pusht.geometry import place
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL

Demonstration = dict[str, NDArray[Any]]
"""One episode of T steps, by the names of LeRobot. In pushT: `observation.state` (T, 2), `action`
(T, 2), and what was chosen of `observation.environment_state` (T, 16), all float32 in px, and
`observation.image` (T, 96, 96, 3), uint8."""

_GOAL_SPREAD = (40.0, 40.0, 0.5)  # standard deviations of a pose near the goal: px, px, rad
_PUSHER_RANGE = (50.0, 450.0)  # px
_CLEARANCE = 110.0  # px from the middle of the keypoints, where the pusher cannot touch the object


class KeypointObservation(gym.Wrapper[Any, Any, Any, Any]):
    """PushT that observes pictures and, beside them, the object's keypoints (2N,), px.

    Args:
        env: An environment whose observations are dictionaries, and whose object is the T.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self._keypoints = OBJECTS["T"].keypoints
        readings: Any = env.observation_space
        world = spaces.Box(0.0, 512.0, (2 * len(self._keypoints),), np.float64)
        self.observation_space = spaces.Dict({**readings.spaces, "environment_state": world})

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**arguments)
        return self._seen(observation, info), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._seen(observation, info), reward, terminated, truncated, info

    def _seen(self, observation: Any, info: dict[str, Any]) -> Any:
        """With the keypoints."""
        keypoints = place(self._keypoints, tuple(info["block_pose"]))
        return {**observation, "environment_state": keypoints.ravel()}


def reset_options(seed: int, near: float) -> dict[str, Any]:
    """Return the options of an episode's reset: none for the usual start, or a state near the goal.

    Args:
        seed: Seed of the episode.
        near: Share of the episodes that start near the goal.
    """
    rng = np.random.default_rng(seed)
    if rng.random() >= near:
        return {}

    object_pose = np.array(DEFAULT_GOAL) + rng.normal(size=3) * _GOAL_SPREAD
    pusher = _sample_free_position(object_pose, rng)
    return {"reset_to_state": [*pusher.tolist(), *object_pose.tolist()]}


def _sample_free_position(
    object_pose: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw a position (2,) of the pusher, px, where it does not touch the object at this pose."""
    keypoints = place(OBJECTS["T"].keypoints, tuple(object_pose)).reshape(-1, 2)
    middle = keypoints.mean(axis=0)

    while True:
        pusher = rng.uniform(*_PUSHER_RANGE, 2)
        if np.linalg.norm(middle - pusher) > _CLEARANCE:
            return pusher


class _Scene(NamedTuple):
    """What a chunk is recorded in: the environment, its start, who acts, and the features."""

    env: VectorEnv[Any, Any, Any]
    start: Start
    policy: Predictor
    features: tuple[str, ...]


def record_chunk(config: AnyRecording, index: int) -> list[Demonstration]:
    """Run the seeds of a chunk as one batch and return its successes, in the order of their seeds.

    Args:
        config: What to record.
        index: Number of the chunk, counted from 0.
    """
    first = config.seed + index * CHUNK_SIZE
    seeds = range(first, first + CHUNK_SIZE)

    # 1. Start all episodes.
    if isinstance(config, RecordingConfig):
        scene = _scene_of_pusht(config, index, seeds)
    else:
        scene = _scene_of_task(config, seeds)
    lesson = lesson_of(config.task)
    frames: list[list[Demonstration]] = [[] for _ in seeds]

    # 2. Note what the teacher sees and does, until all have ended.
    for step in run_episodes(scene.policy, scene.env, scene.start):
        seen = {name: lesson.feature(name, step.observation) for name in scene.features}
        seen[ACTION] = lesson.joined(step.action)

        taught = step.memory.taught if isinstance(step.memory, Corrections) else True
        for row in np.flatnonzero(step.running & taught).tolist():
            frames[row].append({name: _as_stored(values[row]) for name, values in seen.items()})
    scene.env.close()

    # 3. Keep the successes; a student that needed no correction taught nothing.
    succeeded = np.flatnonzero(step.info["is_success"])
    return [_stack_frames(frames[row]) for row in succeeded if frames[row]]


def _scene_of_pusht(config: RecordingConfig, index: int, seeds: range) -> _Scene:
    """PushT with what its recordings choose."""
    env = _make_env(config, index)
    starts = [reset_options(seed, config.near) for seed in seeds]
    start = env.reset(seed=seeds.start, options={"per_env": starts})

    features = (STATE, *(SHOWN[observation] for observation in config.observations))
    return _Scene(env, start, _make_teacher(config), features)


def _scene_of_task(config: TaskRecordingConfig, seeds: range) -> _Scene:
    """Any task as it is, with AICON, or with a student that AICON corrects."""
    task = load(config.task)
    episodes = [task.episode(seed) for seed in seeds]
    env = task.make_env(len(episodes), config.condition, task.horizon)
    start = env.reset(**task.reset_arguments(episodes))

    policy = _teacher_of(config.task, config.condition)
    if config.student:
        from aicon_baselines.agents.diffusion.agent import Agent  # needs LeRobot

        steps = [np.random.default_rng(seed).integers(1, config.longest + 1) for seed in seeds]
        student = Agent(config.student, task=config.task)
        policy = Corrector(student, policy, np.array(steps))
    return _Scene(env, start, policy, tuple(lesson_of(config.task).seen))


@cache
def _teacher_of(task: str, condition: str) -> Any:
    """AICON, compiled once for all chunks, which takes longer than the episodes of one."""
    return compiled(factory(task, "aicon"))(condition)


def _make_env(config: RecordingConfig, index: int) -> VectorEnv[Any, Any, Any]:
    noise = config.noises[index % len(config.noises)]

    def make_one() -> gym.Env[Any, Any]:
        if "pixels" not in config.observations:
            return PushTEnv(action_noise=noise)
        return KeypointObservation(PushTEnv(action_noise=noise, obs_type="pixels_agent_pos"))

    return side_by_side(make_one, CHUNK_SIZE, config.horizon)


@cache
def _make_teacher(config: RecordingConfig) -> Any:
    """Build the policy, whose lengths are in m, once for all chunks."""
    options: dict[str, Any] = {
        "max_speed": PIXEL * config.max_speed,
        "law.smoothing": config.smoothing,
    }
    return make_policy("pusht", **options).compile()


def _as_stored(values: NDArray[Any]) -> NDArray[Any]:
    """Numbers as float32, pictures as they are."""
    return values if values.dtype == np.uint8 else values.astype(np.float32)


def _stack_frames(frames: list[Demonstration]) -> Demonstration:
    """Return the frames of an episode as arrays (T, ...)."""
    episode = {}
    for name in frames[0]:
        episode[name] = np.stack([frame[name] for frame in frames])

    return episode
