"""Imperfect sensors: noise, dropouts and delays, as wrappers of one environment.

Their randomness comes from a child of the environment's noise, drawn at every reset: the same seed
(or the same option `noise_seed`) gives the same readings, the start and the physics are those of
the environment without wrappers, and two wrappers, one in the other, draw different numbers.
"""

import copy
from collections import deque
from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from aicon_envs.checks import check_integer, check_number
from aicon_envs.pusht.environment import PushTEnv
from aicon_envs.pusht.spaces import KEYPOINTS, Action, Observation


class ReadingBox(spaces.Box):
    """A box of readings that may be missing: NaN lies in it as well."""

    def contains(self, x: Any) -> bool:
        """Return whether every number that is not NaN lies within the bounds."""
        if not isinstance(x, np.ndarray):
            return False

        return super().contains(np.where(np.isnan(x), self.low, x))


class ImperfectSensor(gym.Wrapper[Observation, Action, Observation, Action]):
    """Changes the observations of each episode; the first one may be treated differently.

    Args:
        env: A pushT environment.

    Raises:
        ValueError: If it is another one.
    """

    def __init__(self, env: gym.Env[Observation, Action]) -> None:
        """Wrap an environment."""
        if not isinstance(env.unwrapped, PushTEnv):
            raise ValueError(f"the environment must be one of pushT, got {env}")
        super().__init__(env)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the environment for the options."""
        observation, info = self.env.reset(seed=seed, options=options)

        # A child of the episode's noise: the environment's own numbers stay the same.
        environment = cast("PushTEnv", self.unwrapped)
        (self._generator,) = environment.noise.spawn(1)

        return self._sense_first(observation), info

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._sense(observation), float(reward), terminated, truncated, info

    def _sense_first(self, observation: Observation) -> Observation:
        """Return what the sensor gives at a reset."""
        return self._sense(observation)

    def _sense(self, observation: Observation) -> Observation:
        """Return what the sensor gives after a step."""
        raise NotImplementedError


class SensorNoise(ImperfectSensor, RecordConstructorArgs):
    """Adds Gaussian noise to the keypoints: z = x + n, n ~ N(0, σ²) for every coordinate, px.

    The bounds of the noisy observations become infinite.

    Args:
        env: A pushT environment that observes keypoints.
        sigma: Standard deviation σ, px.

    Raises:
        ValueError: If `sigma` is negative or the environment observes no keypoints.
    """

    def __init__(self, env: gym.Env[Observation, Action], sigma: float) -> None:
        """Wrap an environment."""
        RecordConstructorArgs.__init__(self, sigma=sigma)
        super().__init__(env)

        self._sigma = check_number("sigma", sigma)

        box = _space_of_keypoints(env)
        kind = ReadingBox if isinstance(box, ReadingBox) else spaces.Box
        unbounded = kind(-np.inf, np.inf, box.shape, np.float64)
        self.observation_space = _with_keypoints(env, unbounded)

    def _sense(self, observation: Observation) -> Observation:
        """Return the observation with noise."""
        reading = observation[KEYPOINTS]
        noise = self._generator.normal(0.0, self._sigma, reading.shape)
        return {**observation, KEYPOINTS: reading + noise}


class Dropout(ImperfectSensor, RecordConstructorArgs):
    """Loses all keypoints of a step with a probability, as if the object was not seen.

    They then read NaN, no reading. The first observation of an episode is never lost, and
    `agent_pos` never is.

    Args:
        env: A pushT environment that observes keypoints.
        probability: Probability of a loss, per step.

    Raises:
        ValueError: If `probability` is not in [0, 1] or the environment observes no keypoints.
    """

    def __init__(self, env: gym.Env[Observation, Action], probability: float) -> None:
        """Wrap an environment."""
        RecordConstructorArgs.__init__(self, probability=probability)
        super().__init__(env)

        self._probability = check_number("probability", probability)
        if self._probability > 1.0:
            raise ValueError(f"probability must be in [0, 1], got {probability!r}")

        box = _space_of_keypoints(env)
        readings = ReadingBox(box.low, box.high, dtype=np.float64)
        self.observation_space = _with_keypoints(env, readings)

    def _sense_first(self, observation: Observation) -> Observation:
        """Return the observation as it is."""
        return observation

    def _sense(self, observation: Observation) -> Observation:
        """Return the observation, or one without keypoints."""
        if self._generator.uniform() >= self._probability:
            return observation

        missing = np.full_like(observation[KEYPOINTS], np.nan)
        return {**observation, KEYPOINTS: missing}


class Delay(ImperfectSensor, RecordConstructorArgs):
    """Lets observations lag: after step t comes the observation of step t - k.

    Until step k it is that of the reset. Reward, flags and info are not delayed.

    Args:
        env: A pushT environment.
        steps: Number k of control steps.

    Raises:
        ValueError: If `steps` is not an integer >= 0.
    """

    def __init__(self, env: gym.Env[Observation, Action], steps: int) -> None:
        """Wrap an environment."""
        RecordConstructorArgs.__init__(self, steps=steps)
        super().__init__(env)

        self._recent: deque[Observation] = deque(maxlen=check_integer("steps", steps, 0) + 1)

    def _sense_first(self, observation: Observation) -> Observation:
        """Return the observation, and forget the last episode's."""
        self._recent.clear()
        return self._sense(observation)

    def _sense(self, observation: Observation) -> Observation:
        """Return the oldest observation that is not older than k steps."""
        self._recent.append(observation)
        return copy.deepcopy(self._recent[0])  # which comes again until step k


def _space_of_keypoints(env: gym.Env[Observation, Action]) -> spaces.Box:
    """Return the space of the keypoints in a dictionary observation."""
    space = env.observation_space
    if not (isinstance(space, spaces.Dict) and KEYPOINTS in space.spaces):
        raise ValueError(
            "the environment must observe keypoints: obs_type environment_state_agent_pos, "
            f"got {space}"
        )
    return cast("spaces.Box", space[KEYPOINTS])


def _with_keypoints(env: gym.Env[Observation, Action], box: spaces.Box) -> spaces.Dict:
    """Return the space of its observations with another one of the keypoints."""
    return spaces.Dict({**cast("spaces.Dict", env.observation_space).spaces, KEYPOINTS: box})
