"""Demonstrations of pushT: successful episodes of `make_policy("pusht")` in "aicon/PushT-v0"."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.agents.diffusion.feature_names import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.keypoint_observation import KeypointObservation
from aicon_baselines.agents.diffusion.recording_config import CHUNK_SIZE, RecordingConfig
from aicon_baselines.agents.diffusion.start_states import reset_options
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.tasks import side_by_side
from aicon_envs.pusht import PushTEnv
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL

Demonstration = dict[str, NDArray[Any]]
"""One episode of T steps, by the names of LeRobot: `observation.state` (T, 2), `action` (T, 2), and
what was chosen of `observation.environment_state` (T, 16), all float32 in px, and
`observation.image` (T, 96, 96, 3), uint8."""


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

    def make_one() -> gymnasium.Env[Any, Any]:
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
