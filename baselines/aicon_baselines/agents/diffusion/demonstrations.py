"""Demonstrations of pushT: successful episodes of `make_policy("pusht")` in "aicon/PushT-v0"."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_envs.pusht import OBJECTS, PushTVectorEnv
from aicon_envs.pusht.geometry import place
from aicon_envs.pusht import DEFAULT_GOAL

CHUNK = 50
"""Number of seeds recorded as one batch."""

OBSERVATIONS = ("keypoints", "pixels")
"""What a demonstration can show of the object; the pusher's position is always there."""

RESERVED = (range(1000), range(20_000, 21_000))
"""Seeds that results are reported on, which no demonstration may use."""

Demonstration = dict[str, NDArray[Any]]
"""One episode of T steps, by the names of LeRobot: `observation.state` (T, 2), `action` (T, 2), and what was chosen of
`observation.environment_state` (T, 16), all float32 in px, and `observation.image` (T, 96, 96, 3), uint8."""


@dataclass(frozen=True)
class Recording:
    """What to record.

    Attributes:
        episodes: Number of successful episodes.
        seed: First seed.
        noises: Standard deviations of the noise on the executed action, px; chunks of seeds take turns. What is
            recorded is the action that was sent, without the noise: how to go on from where the noise led.
        near: Share of the episodes that start with the object near its goal (σ = 40 px and 0.5 rad).
        max_speed: Largest speed of the teacher, px/s. The default, with `smoothing`, makes demonstrations that last as
            long as human ones. At its own speed AICON solves the task in half the steps, but its targets jump, and a
            student that executes eight actions before it looks again learned nothing from them.
        smoothing: Time constant of the low-pass on the teacher's velocity, s.
        observations: Some of `OBSERVATIONS`.
        horizon: Steps within which an episode has to succeed.
    """

    episodes: int = 200
    seed: int = 100_000
    noises: tuple[float, ...] = (0.0, 2.0)
    near: float = 0.0
    max_speed: float = 250.0
    smoothing: float = 0.3
    observations: tuple[str, ...] = ("keypoints",)
    horizon: int = 300

    def __post_init__(self) -> None:
        """Reject what cannot be recorded."""
        for name in ("episodes", "horizon"):
            if getattr(self, name) < 1:
                raise ComparisonError(f"{name} must be 1 or more, not {getattr(self, name)}")
        seeds = range(self.seed, self.seed + 10 * self.episodes + CHUNK)
        if any(max(seeds.start, held.start) < min(seeds.stop, held.stop) for held in RESERVED) or self.seed < 0:
            raise ComparisonError(
                f"seed must leave out 0 to 999 and 20000 to 20999, which results are reported on, not {self.seed}: "
                "take 100000"
            )
        if not self.noises or min(self.noises) < 0.0:
            raise ComparisonError(f"noises must be one or more numbers >= 0, not {self.noises}")
        if not 0.0 <= self.near <= 1.0:
            raise ComparisonError(f"near must be a share between 0 and 1, not {self.near}")
        for name in ("max_speed", "smoothing"):
            if not getattr(self, name) > 0.0:
                raise ComparisonError(f"{name} must be positive, not {getattr(self, name)}")
        if not self.observations or set(self.observations) - set(OBSERVATIONS):
            raise ComparisonError(f"observations must be some of {', '.join(OBSERVATIONS)}, not {self.observations}")


def record_chunk(recording: Recording, index: int) -> list[Demonstration]:
    """Run the seeds of a chunk as one batch and return the successful episodes, in the order of their seeds."""
    from aicon_torch import make_policy

    first = recording.seed + index * CHUNK
    env = PushTVectorEnv(
        num_envs=CHUNK,
        max_episode_steps=recording.horizon,
        autoreset_mode=AutoresetMode.DISABLED,
        action_noise=recording.noises[index % len(recording.noises)],
        obs_type="pixels_agent_pos" if "pixels" in recording.observations else "environment_state_agent_pos",
        wrappers=[Keypoints] if "pixels" in recording.observations else [],
    )
    policy: Any = make_policy("pusht", max_speed=recording.max_speed, smoothing=recording.smoothing)
    options = {"per_env": [_start(recording, seed) for seed in range(first, first + CHUNK)]}
    observation, info = env.reset(seed=first, options=options)
    memory, ended = None, np.zeros(CHUNK, np.bool_)
    frames: list[list[dict[str, NDArray[Any]]]] = [[] for _ in range(CHUNK)]
    while not ended.all():
        action, memory = policy.predict(observation, memory, ended)
        action = np.asarray(action, np.float32)
        for i in np.flatnonzero(~ended):
            frames[i].append(_frame(recording, {name: value[i] for name, value in observation.items()}, action[i]))
        observation, _, terminated, truncated, info = env.step(action)
        ended = terminated | truncated
    env.close()
    return [
        {name: np.stack([frame[name] for frame in frames[i]]) for name in frames[i][0]}
        for i in np.flatnonzero(info["is_success"])
    ]


class Keypoints(gym.ObservationWrapper[Any, Any, Any]):
    """PushT that observes pictures and the object's keypoints (2N,), px, as well."""

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        """Wrap an environment whose observations are dictionaries."""
        super().__init__(env)
        self._pushed = OBJECTS["T"]
        box = spaces.Box(0.0, 512.0, (2 * len(self._pushed.keypoints),), np.float64)
        known: Any = env.observation_space
        self.observation_space = spaces.Dict({**known.spaces, "environment_state": box})
        self._pose: Any = None

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
        return {**observation, "environment_state": place(self._pushed.keypoints, tuple(self._pose)).ravel()}


def _frame(recording: Recording, observation: dict[str, Any], action: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
    frame = {"observation.state": observation["agent_pos"].astype(np.float32), "action": action}
    if "keypoints" in recording.observations:
        frame["observation.environment_state"] = observation["environment_state"].astype(np.float32)
    if "pixels" in recording.observations:
        frame["observation.image"] = observation["pixels"]
    return frame


def _start(recording: Recording, seed: int) -> dict[str, Any]:
    """Return the options of an episode's reset: nothing for the usual start, or a state near the goal."""
    rng = np.random.default_rng(seed)
    if rng.random() >= recording.near:
        return {}
    pose = np.array(DEFAULT_GOAL) + rng.normal(size=3) * (40.0, 40.0, 0.5)
    return {"reset_to_state": next(_states(pose, rng))}


def _states(pose: NDArray[np.float64], rng: np.random.Generator) -> Iterator[list[float]]:
    """Yield states in which the pusher does not touch the object at this pose."""
    keypoints = place(OBJECTS["T"].keypoints, tuple(pose)).reshape(-1, 2)
    while True:
        pusher = rng.uniform(50.0, 450.0, 2)
        if np.linalg.norm(keypoints.mean(axis=0) - pusher) > 110.0:
            yield [*pusher.tolist(), *pose.tolist()]
