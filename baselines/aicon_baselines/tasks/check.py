"""What a task promises, tried out, as Gymnasium's `check_env` does for an environment."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Episode, Task

_STEPS = 4
_LONGEST = 4 * _STEPS  # where a step may take less time than usual, an episode has more of them

_Report = tuple[Any, dict[str, Any]]
"""An observation and the info beside it."""


def check_task(task: Task, conditions: Sequence[str] | None = None, policy: str = "aicon") -> None:
    """Try what a task promises: two short episodes in each condition, and a step of a policy.

    Args:
        task: The task.
        conditions: Some of its conditions; by default all.
        policy: Name of a policy, which has to accept what it is told about each condition; empty
            for a task that has none yet.

    Raises:
        ComparisonError: At the first promise that is broken: which one, in what condition, and what
            would be right.

    Example:
        >>> from aicon_baselines import tasks
        >>> tasks.check_task(tasks.load("nav2d"), ["range"])
    """
    _check_declaration(task)
    for condition in task.conditions if conditions is None else conditions:
        _Check(task, condition).run(policy)


def _check_declaration(task: Task) -> None:
    """Check what can be read without an environment."""
    numbers = {
        "time_step": task.time_step,
        "horizon": task.horizon,
        "chunk_size": task.chunk_size,
        "maps": len(task.maps),
        "conditions": len(task.conditions),
    }
    for name, number in numbers.items():
        if not number > 0:
            raise ComparisonError(f"task {task.name!r}: {name} must be more than 0, not {number}")

    subsets = {"faults": task.faults, "noiseless": task.noiseless}
    for name, chosen in subsets.items():
        unknown = sorted(set(chosen) - set(task.conditions))
        if unknown:
            raise ComparisonError(
                f"task {task.name!r}: {name} names {unknown[0]!r}, which is none of its "
                f"conditions: {', '.join(task.conditions)}"
            )

    if any(steps > task.horizon for steps in task.milestones):
        raise ComparisonError(
            f"task {task.name!r}: milestones {task.milestones} must be within the horizon, "
            f"{task.horizon} steps"
        )
    if task.model:
        _check_presets(task)


def _check_presets(task: Task) -> None:
    """Check that what is compared is a preset of the model."""
    from aicon_baselines.agents.registry import model_of
    from aicon_torch import presets

    there = presets(model_of(task))
    for name in task.presets:
        if name not in there:
            raise ComparisonError(
                f"task {task.name!r}: the model {task.model!r} has no preset {name!r}; it has: "
                f"{', '.join(there)}"
            )


class _Check:
    """The promises of a task in one condition."""

    def __init__(self, task: Task, condition: str) -> None:
        self._task, self._condition = task, condition
        self._count = 2
        self._episodes = [task.episode(seed) for seed in range(self._count)]

    def run(self, policy: str) -> None:
        """Try them one after the other."""
        actions, first = self._play(self._episodes)
        self._check_info(first[0][1], after_a_step=False)
        self._check_info(first[1][1], after_a_step=True)

        self._check_the_same_again(actions, first)
        self._check_alone(actions, first)
        self._check_copies(actions, first)
        if policy:
            self._check_policy(policy)

    def _play(
        self, episodes: Sequence[Episode], actions: Sequence[Any] = ()
    ) -> tuple[list[Any], list[_Report]]:
        """Play episodes to a horizon of a few steps and beyond; by default choose actions.

        Returns:
            The actions, and what was seen at first and after each.
        """
        env = self._make_env(len(episodes))
        try:
            seen = [copy.deepcopy(env.reset(**self._task.reset_arguments(episodes)))]
            actions = list(actions) or self._choose_actions(env)
            for action in actions:
                observation, *_, info = env.step(action)
                seen.append(copy.deepcopy((observation, info)))

            self._check_at_rest(env, actions[-1])
            return actions, seen
        finally:
            env.close()

    def _make_env(self, count: int) -> VectorEnv[Any, Any, Any]:
        env = self._task.make_env(count, self._condition, _STEPS)
        if env.num_envs != count:
            raise self._broken(
                f"`make_env({count}, ...)` made {env.num_envs} environments", "make as many"
            )
        return env

    def _choose_actions(self, env: VectorEnv[Any, Any, Any]) -> list[Any]:
        env.action_space.seed(0)
        return [env.action_space.sample() for _ in range(_STEPS)]

    def _check_at_rest(self, env: VectorEnv[Any, Any, Any], action: Any) -> None:
        """Episodes end at the horizon, and stay as they are while others of their batch go on."""
        try:
            for _ in range(_LONGEST):
                *_, terminated, truncated, info = env.step(action)
                if np.all(terminated | truncated):
                    break
            *_, later = env.step(action)
        except ResetNeeded as error:
            raise self._broken(
                f"after the end of an episode there is no other step: {error}",
                "end each environment with `StandStillAfterEnd`, and put them into a `SideBySide`",
            ) from error

        if not np.all(terminated | truncated):
            raise self._broken(
                f"episodes go on after the horizon of {_STEPS} steps",
                "`make_env` has to end them there, as gymnasium's TimeLimit does",
            )
        if not np.array_equal(info["position"], later["position"]):
            raise self._broken(
                "an episode that has ended moves", "disable autoreset, and let it stand still"
            )

    def _check_info(self, info: Mapping[str, Any], after_a_step: bool) -> None:
        """The info has what rows are made of, in the right shape."""
        count = self._count
        shapes: dict[str, tuple[int, ...]] = {"distance": (count,)}
        shapes |= {measure.key: (count,) for measure in self._task.measures}
        if after_a_step:
            shapes |= {"is_success": (count,), "collision": (count,)}

        for key, shape in shapes.items():
            self._check_value(info, key, shape)
        where = self._check_value(info, "position", None)
        if where.ndim != 2 or where.shape[0] != count or where.shape[1] not in (2, 3):
            raise self._broken(
                f"info['position'] has shape {where.shape}",
                f"it is ({count}, 2) for {count} episodes, or ({count}, 3)",
            )

    def _check_value(
        self, info: Mapping[str, Any], key: str, shape: tuple[int, ...] | None
    ) -> NDArray[Any]:
        if key not in info:
            raise self._broken(f"info has no {key!r}", f"it has: {', '.join(sorted(info))}")

        value = np.asarray(info[key])
        if shape is not None and value.shape != shape:
            raise self._broken(
                f"info[{key!r}] has shape {value.shape}", f"one number an episode is {shape}"
            )
        if value.dtype == object or not np.isfinite(value).all():
            raise self._broken(f"info[{key!r}] is {value}", "it is finite numbers")
        return value

    def _check_the_same_again(self, actions: Sequence[Any], first: Sequence[_Report]) -> None:
        _, again = self._play(self._episodes, actions)
        for step, (one, other) in enumerate(zip(first, again, strict=True)):
            self._check_equal(
                _shown(one), _shown(other), f"the same seeds and actions give another step {step}"
            )

    def _check_alone(self, actions: Sequence[Any], first: Sequence[_Report]) -> None:
        for row, episode in enumerate(self._episodes):
            _, alone = self._play([episode], [action[row : row + 1] for action in actions])
            for step, (one, other) in enumerate(zip(first, alone, strict=True)):
                found = f"seed {episode.seed} alone is another episode than in a batch, in step "
                self._check_equal(_row(_shown(one), row), _shown(other), f"{found}{step}")

    def _check_copies(self, actions: Sequence[Any], first: Sequence[_Report]) -> None:
        """Where there is no noise, the repeat of an episode is a copy."""
        if self._condition not in self._task.noiseless:
            return
        repeats = [self._task.episode(episode.seed, repeat=1) for episode in self._episodes]
        _, again = self._play(repeats, actions)
        for one, other in zip(first, again, strict=True):
            self._check_equal(
                _shown(one), _shown(other), "it is declared noiseless, and its repeats differ"
            )

    def _check_equal(self, one: Any, other: Any, found: str) -> None:
        difference = _difference(one, other)
        if difference:
            raise self._broken(
                f"{found}: {difference}",
                "what happens depends on the seed in `reset_arguments` and the actions only",
            )

    def _check_policy(self, name: str) -> None:
        """A policy accepts what it is told, and its actions are those of the environment."""
        from aicon_baselines.agents.registry import make
        from aicon_torch.errors import OptionError

        try:
            policy = make(self._task, name, self._condition)
        except OptionError as error:
            raise self._broken(
                f"the policy {name!r} refuses what `policy_options` tells it: {error}",
                "tell it options of its model",
            ) from error

        options = getattr(policy, "env_options", {})
        env = self._task.make_env(self._count, self._condition, _STEPS, **options)
        try:
            observation, _ = env.reset(**self._task.reset_arguments(self._episodes))
            action, _ = policy.predict(observation, None, np.ones(self._count, np.bool_))
        finally:
            env.close()
        if action.shape != env.action_space.shape or not np.isfinite(action).all():
            raise self._broken(
                f"the policy {name!r} acts with shape {action.shape}",
                f"finite numbers {env.action_space.shape} are the environment's actions",
            )

    def _broken(self, found: str, right: str) -> ComparisonError:
        return ComparisonError(
            f"task {self._task.name!r}, condition {self._condition!r}: {found}; {right}"
        )


def _shown(report: _Report) -> dict[str, Any]:
    """What two plays of an episode have to agree on."""
    observation, info = report
    return {"observation": observation, "position": info["position"], "distance": info["distance"]}


def _row(values: Any, row: int) -> Any:
    """One episode of a batch, as a batch of one."""
    if isinstance(values, Mapping):
        return {key: _row(value, row) for key, value in values.items()}
    return values[row : row + 1]


def _difference(one: Any, other: Any, name: str = "") -> str:
    """Say where two nested values differ; nothing if they do not."""
    if isinstance(one, Mapping):
        found = (_difference(one[key], other[key], key) for key in one)
        return next(filter(None, found), "")

    # The sums of a batch are rounded in another order.
    one, other = np.asarray(one), np.asarray(other)
    if one.dtype.kind == "f":
        agrees = np.allclose(one, other, rtol=1e-5, atol=1e-6, equal_nan=True)
    else:
        agrees = np.array_equal(one, other)
    return "" if agrees else f"{name} {one.tolist()} and {other.tolist()}"
