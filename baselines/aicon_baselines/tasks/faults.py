"""Faults of sensors and of the way to the robot, for any task: conditions of a comparison.

A fault changes what the policy reads, or which of its actions the robot executes; the world stays
as it is. Its randomness comes from the episode's seed alone, or from its ``noise_seed`` where it
has one. Faults that happen at once are joined by a plus, such as ``late+bias``, and what is told of
each stays true.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv, VectorWrapper
from numpy.typing import NDArray

Observation = dict[str, NDArray[Any]]

FAULTS = (
    "late",
    "jitter",
    "held",
    "uneven",
    "stuck",
    "outliers",
    "bias",
    "blackout",
    "gone",
    "erratic",
)
"""The conditions.

- ``late``: every observation is so old; its age is told.
- ``jitter``: likewise, by an amount of its own each time, from none.
- ``held``: in half of the steps the robot executes its last action again; which one is told.
- ``uneven``: a control step takes as long as one, two or three; how long is told.
- ``stuck``: from a random time on all readings stay the same for a while.
- ``outliers``: one reading in twenty is any number of its range.
- ``bias``: some sensors are off by a constant.
- ``blackout``: from a random time on there is no reading for a while.
- ``gone``: from a random time on there is no reading any more.
- ``erratic``: from a random time on every reading is any number of its range.
"""

DISTURBANCES = ("stuck", "outliers", "bias", "blackout", "gone", "erratic")
"""Those in which readings are wrong or missing, in the order in which they come."""

HELD, OUTLIERS, UNEVEN = 0.5, 0.05, 3
FOR_EVER = 10**9  # steps
_STREAM = 7919  # sets the faults' random numbers apart from the environment's


@dataclass(frozen=True)
class Faults:
    """How large the faults of a task are.

    Attributes:
        dt: Control step, s.
        late: Age of late observations, steps.
        jitter: Largest age of observations that come after a while of their own, steps.
        onset: Earliest and latest time at which readings stop or freeze, steps.
        pause: For how long they do, steps.
        bias: Offset by key.
        ranges: Range of the outliers by key; others have none.
        held: How many steps later than usual a policy's action may take effect where it is held; 0
            where a policy is not told.
        told: What a policy is told where sensors are off, by option.
        tells_action: Whether the action that is held is told, as ``executed``.
    """

    dt: float
    late: int
    jitter: int
    onset: tuple[int, int]
    pause: int
    bias: Mapping[str, float]
    ranges: Mapping[str, tuple[float, float]]
    held: int = 0
    told: Mapping[str, Any] = field(default_factory=dict)
    tells_action: bool = False

    def wrap(self, env: VectorEnv[Any, Any, Any], condition: str) -> VectorEnv[Any, Any, Any]:
        """The environment with the faults of a condition, if any, each around those before it.

        Readings come late, counted in the environment's own steps, and are disturbed when they
        come; a control step takes several of those, and executes one action.
        """
        faults = at_once(condition)
        late = self.late if "late" in faults else 0
        jitter = self.jitter if "jitter" in faults else 0
        if late or jitter:
            env = _Late(env, self, late, jitter)
        for fault in DISTURBANCES:
            if fault in faults:
                env = Disturbed(env, self, fault)
        if "uneven" in faults:
            env = _Uneven(env, self)
        return _Held(env, self) if "held" in faults else env

    def policy_options(self, condition: str) -> dict[str, Any]:
        """What a policy is told: how old readings may be, or how far off."""
        faults = at_once(condition)
        options: dict[str, Any] = dict(self.told) if "bias" in faults else {}

        ages = {"late": self.late, "jitter": self.jitter}
        delay = sum(ages.get(fault, 0) for fault in faults)
        if delay:
            options["delay"] = delay

        # An action is held for some steps, of as many of the usual ones as they take on average.
        steps = self.held if "held" in faults else 0
        if "uneven" in faults and self.held:
            steps = (1 + steps) * (1 + UNEVEN) // 2
        if steps:
            options["action_delay"] = steps
        return options


def at_once(condition: str) -> tuple[str, ...]:
    """The faults of a condition, such as ``("late", "bias")`` of ``late+bias``."""
    return tuple(condition.split("+"))


def are_faults(condition: str) -> bool:
    """Whether a condition is one of the faults, or several at once."""
    return set(at_once(condition)) <= set(FAULTS)


def longest(condition: str, horizon: int) -> int:
    """How many of the environment's steps an episode of so many control steps may take."""
    return UNEVEN * horizon if "uneven" in at_once(condition) else horizon


def disturbed(env: VectorEnv[Any, Any, Any], fault: str) -> "Disturbed":
    """The layer of an environment in which a fault disturbs its readings."""
    while isinstance(env, _Faulty):
        if isinstance(env, Disturbed) and env.fault == fault:
            return env
        env = env.env
    raise ValueError(f"no readings are {fault!r} in {env}; expected an environment with that fault")


class _Faulty(VectorWrapper):
    """An environment with a fault: each row has random numbers of its own."""

    def __init__(self, env: VectorEnv[Any, Any, Any], faults: Faults) -> None:
        super().__init__(env)
        self._faults = faults
        self._generators: list[np.random.Generator] = []
        self._layer: int = env._layer + 1 if isinstance(env, _Faulty) else 0

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        """Start all episodes; ``seed`` is one number for each, and so may be ``noise_seed``."""
        observation, info = self.env.reset(seed=seed, options=options)

        # Repeats of an episode share its seed where only their noise may differ.
        own = (options or {}).get("per_env") or [{}] * len(seed)
        noises = [each.get("noise_seed", one) for each, one in zip(own, seed, strict=True)]
        stream = _STREAM + self._layer
        self._generators = [np.random.default_rng([stream, one]) for one in noises]
        return self._begin(dict(observation), info), info

    def _draw(self, draw: Callable[[np.random.Generator], Any]) -> NDArray[Any]:
        """A number or an array for each row."""
        return np.array([draw(generator) for generator in self._generators])

    def _begin(self, observation: Observation, info: dict[str, Any]) -> Observation:
        """The first observation."""
        return observation


class _Late(_Faulty):
    """Observations are ``late`` steps old, and up to ``jitter`` more; ``age`` is told."""

    def __init__(
        self, env: VectorEnv[Any, Any, Any], faults: Faults, late: int, jitter: int
    ) -> None:
        super().__init__(env, faults)
        self._late, self._jitter = late, jitter
        self._recent: list[Observation] = []

    def step(self, actions: Any) -> Any:
        """Move, and observe what was."""
        observation, *rest = self.env.step(actions)
        self._recent = [dict(observation), *self._recent[: self._late + self._jitter]]
        return (self._sensed(), *rest)

    def _begin(self, observation: Observation, info: dict[str, Any]) -> Observation:
        self._recent = [observation]
        return self._sensed()

    def _sensed(self) -> Observation:
        ages = np.full(self.num_envs, self._late)
        if self._jitter:
            ages += self._draw(lambda generator: generator.integers(self._jitter + 1))
        ages = np.minimum(ages, len(self._recent) - 1)

        rows = range(self.num_envs)
        sensed: Observation = {}
        for key in self._recent[0]:
            sensed[key] = np.stack([self._recent[ages[row]][key][row] for row in rows])
        sensed["age"] = (self._faults.dt * ages)[:, np.newaxis]
        return sensed


class _Held(_Faulty):
    """In half of the steps the last action is executed again."""

    def __init__(self, env: VectorEnv[Any, Any, Any], faults: Faults) -> None:
        super().__init__(env, faults)
        self._executed: NDArray[Any] = np.zeros(0)

    def step(self, actions: Any) -> Any:
        """Move by the actions, or by the last ones."""
        held = self._draw(lambda generator: generator.uniform() < HELD)
        self._executed = np.where(held[:, np.newaxis], self._executed, actions)
        observation, *rest = self.env.step(self._executed)
        return (self._sensed(dict(observation)), *rest)

    def _begin(self, observation: Observation, info: dict[str, Any]) -> Observation:
        space: Any = self.env.action_space
        if self._faults.tells_action:
            self._executed = np.zeros(space.shape, space.dtype)
        else:  # where zero is not rest, the place where it is
            self._executed = np.asarray(info["position"], space.dtype)
        return self._sensed(observation)

    def _sensed(self, observation: Observation) -> Observation:
        """The observation, and the action that was executed."""
        if self._faults.tells_action:
            observation["executed"] = self._executed.copy()
        return observation


class _Uneven(_Faulty):
    """Each control step takes 1 to UNEVEN of the usual ones, in all rows alike; it is told."""

    def step(self, actions: Any) -> Any:
        """Move by the actions for a while; what ends an episode meanwhile ends it."""
        steps = int(self._generator.integers(1, UNEVEN + 1))
        observation, rewards, terminated, truncated, info = self.env.step(actions)
        for _ in range(steps - 1):
            observation, more, ends, runs_out, info = self.env.step(actions)
            rewards, terminated, truncated = rewards + more, terminated | ends, truncated | runs_out
        return self._sensed(dict(observation), steps), rewards, terminated, truncated, info

    def _begin(self, observation: Observation, info: dict[str, Any]) -> Observation:
        # Rows cannot wait for each other, so the sequence is the same for every episode.
        self._generator = np.random.default_rng(_STREAM)
        return self._sensed(observation, 1)

    def _sensed(self, observation: Observation, steps: int) -> Observation:
        observation["elapsed"] = np.full((self.num_envs, 1), self._faults.dt * steps)
        return observation


class Disturbed(_Faulty):
    """Readings are wrong or missing, now and then or from some time on; their age is told as it is.

    Attributes:
        fault: One of :data:`DISTURBANCES`.
        onset: From which step on, ``(B,)``.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], faults: Faults, fault: str) -> None:
        super().__init__(env, faults)
        self.fault = fault
        self._steps = 0
        self._frozen: Observation = {}

    @property
    def since(self) -> NDArray[np.int64]:
        """How many of the environment's steps ago it began, ``(B,)``; negative before."""
        return self._steps - self.onset

    @property
    def pause(self) -> int:
        """For how long readings are wrong, steps."""
        is_for_ever = self.fault in ("gone", "erratic")
        return FOR_EVER if is_for_ever else self._faults.pause

    def step(self, actions: Any) -> Any:
        """Move, and sense with the fault."""
        observation, *rest = self.env.step(actions)
        self._steps += 1
        return (self._sensed(dict(observation)), *rest)

    def _begin(self, observation: Observation, info: dict[str, Any]) -> Observation:
        earliest, latest = self._faults.onset
        self.onset = self._draw(lambda generator: generator.integers(earliest, latest + 1))
        self._steps, self._frozen = 0, observation
        return self._sensed(observation)

    def _sensed(self, observation: Observation) -> Observation:
        pauses = (self.since >= 0) & (self.since < self.pause)
        sensed = dict(observation)
        for key in observation.keys() - {"age"}:
            reading = observation[key]
            sensed[key] = self._reading(key, reading, pauses.reshape(-1, *[1] * (reading.ndim - 1)))
        if self.fault == "stuck":
            self._frozen = sensed
        return sensed

    def _reading(self, key: str, reading: NDArray[Any], pauses: NDArray[np.bool_]) -> NDArray[Any]:
        if self.fault == "stuck":
            return np.where(pauses, self._frozen[key], reading)
        if self.fault in ("blackout", "gone"):
            return np.where(pauses, np.nan, reading)
        if self.fault == "bias":
            return reading + self._faults.bias.get(key, 0.0)

        # Outliers, now and then or for ever.
        if key not in self._faults.ranges:
            return reading
        low, high = self._faults.ranges[key]
        is_wrong = self._draw(lambda generator: generator.uniform() < OUTLIERS)
        wrong = self._draw(lambda generator: generator.uniform(low, high, reading.shape[1:]))
        is_wrong = pauses if self.fault == "erratic" else is_wrong.reshape(pauses.shape)
        return np.where(is_wrong, wrong, reading).astype(reading.dtype)
