"""Demonstrations of pushT: successful episodes of `make_policy("pusht")` in "aicon/PushT-v0"."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.configs import CHUNK_SIZE, RecordingConfig
from aicon_baselines.agents.diffusion.lerobot_names import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.tasks import side_by_side
from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, PushTEnv
from aicon_envs.pusht.geometry import place
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL

Demonstration = dict[str, NDArray[Any]]
"""One episode of T steps, by the names of LeRobot: `observation.state` (T, 2), `action` (T, 2), and
what was chosen of `observation.environment_state` (T, 16), all float32 in px, and
`observation.image` (T, 96, 96, 3), uint8."""

_GOAL_SPREAD = (40.0, 40.0, 0.5)  # standard deviations of a pose near the goal: px, px, rad
_PUSHER_RANGE = (50.0, 450.0)  # px
_CLEARANCE = 110.0  # px from the middle of the keypoints, where the pusher cannot touch the object


class KeypointObservation(gym.ObservationWrapper[Any, Any, Any]):
    """PushT that observes pictures and, beside them, the object's keypoints (2N,), px.

    Args:
        env: An environment whose observations are dictionaries, and whose object is the T.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self._keypoints = OBJECTS["T"].keypoints
        self._pose: Any = None

        readings: Any = env.observation_space
        world = spaces.Box(0.0, 512.0, (2 * len(self._keypoints),), np.float64)
        self.observation_space = spaces.Dict({**readings.spaces, "environment_state": world})

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**arguments)
        self._pose = info["block_pose"]
        return self.observation(observation), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._pose = info["block_pose"]
        return self.observation(observation), reward, terminated, truncated, info

    def observation(self, observation: Any) -> Any:
        """Add the keypoints."""
        keypoints = place(self._keypoints, tuple(self._pose))
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


def record_chunk(config: RecordingConfig, index: int) -> list[Demonstration]:
    """Run the seeds of a chunk as one batch and return its successes, in the order of their seeds.

    Args:
        config: What to record.
        index: Number of the chunk, counted from 0.
    """
    env = _make_env(config, index)
    teacher = _make_teacher(config)
    frames: list[list[Demonstration]] = [[] for _ in range(CHUNK_SIZE)]

    # 1. Start all episodes.
    first_seed = config.seed + index * CHUNK_SIZE
    seeds = range(first_seed, first_seed + CHUNK_SIZE)
    starts = [reset_options(seed, config.near) for seed in seeds]
    start = env.reset(seed=first_seed, options={"per_env": starts})

    # 2. Note what the teacher sees and does, until all have ended.
    for step in run_episodes(teacher, env, start):
        action = np.asarray(step.action, np.float32)
        for row in np.flatnonzero(step.running).tolist():
            frames[row].append(_make_frame(config, step.observation, action, row))
    env.close()

    # 3. Keep the successes.
    return [_stack_frames(frames[row]) for row in np.flatnonzero(step.info["is_success"])]


def _make_env(config: RecordingConfig, index: int) -> VectorEnv[Any, Any, Any]:
    noise = config.noises[index % len(config.noises)]

    def make_one() -> gym.Env[Any, Any]:
        if "pixels" not in config.observations:
            return PushTEnv(action_noise=noise)
        return KeypointObservation(PushTEnv(action_noise=noise, obs_type="pixels_agent_pos"))

    return side_by_side(make_one, CHUNK_SIZE, config.horizon)


def _make_teacher(config: RecordingConfig) -> Any:
    """Build the policy, whose lengths are in m."""
    options: dict[str, Any] = {
        "max_speed": PIXEL * config.max_speed,
        "law.smoothing": config.smoothing,
    }
    return make_policy("pusht", **options).compile()


def _make_frame(
    config: RecordingConfig,
    observation: dict[str, NDArray[Any]],
    action: NDArray[np.float32],
    row: int,
) -> Demonstration:
    """Return what a row of the batch saw and did, as one frame of its demonstration."""
    frame: Demonstration = {
        STATE: observation["agent_pos"][row].astype(np.float32),
        ACTION: action[row],
    }

    if "keypoints" in config.observations:
        frame[KEYPOINTS] = observation["environment_state"][row].astype(np.float32)
    if "pixels" in config.observations:
        frame[PIXELS] = observation["pixels"][row]
    return frame


def _stack_frames(frames: list[Demonstration]) -> Demonstration:
    """Return the frames of an episode as arrays (T, ...)."""
    episode = {}
    for name in frames[0]:
        episode[name] = np.stack([frame[name] for frame in frames])

    return episode
