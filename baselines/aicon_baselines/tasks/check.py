"""What a task promises, tried out, as Gymnasium's `check_env` does for an environment."""

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box
from gymnasium.vector import VectorEnv

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Episode, Task

_STEPS = 4
_LONGEST = 4 * _STEPS  # where a step may take less time than usual, an episode has more of them
_COUNT = 2  # episodes
_ROUNDED = 1e-5  # by how much an action may be beyond a bound

_Report = tuple[Any, dict[str, Any]]
"""An observation and the info beside it."""


def check_task(task: Task, conditions: Sequence[str] | None = None, policy: str = "aicon") -> None:
    """Try what a task promises: two short episodes in each condition, and a step of a policy.

    Every preset is built, too.

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
    checks = [_Check(task, condition) for condition in conditions or task.conditions]
    for check in checks:
        check.run(policy)
    for preset in task.presets:
        checks[0].build(preset)


def _check_declaration(task: Task) -> None:
    """Check what can be read without an environment."""
    from aicon_baselines.agents.registry import model_of
    from aicon_torch import presets

    def refuse(wrong: str) -> None:
        raise ComparisonError(f"task {task.name!r}: {wrong}")

    # Numbers that count something.
    numbers = {
        "time_step": task.time_step,
        "horizon": task.horizon,
        "chunk_size": task.chunk_size,
        "maps": len(task.maps),
        "conditions": len(task.conditions),
    }
    for name, number in numbers.items():
        if not number > 0:
            refuse(f"{name} must be more than 0, not {number}")

    # Names of conditions, ...
    for name, chosen in {"faults": task.faults, "noiseless": task.noiseless}.items():
        for unknown in sorted(set(chosen) - set(task.conditions)):
            conditions = ", ".join(task.conditions)
            refuse(f"{name} names {unknown!r}, which is none of its conditions: {conditions}")

    # ... times that are shown, ...
    if any(steps > task.horizon for steps in task.milestones):
        refuse(f"milestones {task.milestones} must be within the horizon, {task.horizon} steps")

    # ... and names of presets.
    there = presets(model_of(task)) if task.presets else ()
    for name in task.presets:
        if name not in there:
            known = ", ".join(there)
            refuse(f"the model {task.model!r} has no preset {name!r}; it has: {known}")


class _Check:
    """The promises of a task in one condition."""

    def __init__(self, task: Task, condition: str) -> None:
        self._task, self._condition = task, condition
        self._episodes = [task.episode(seed) for seed in range(_COUNT)]

    def run(self, policy: str) -> None:
        """Try them one after the other."""
        actions, first = self._play(self._episodes)
        self._check_info(first[0][1], after_a_step=False)
        self._check_info(first[1][1], after_a_step=True)

        _, again = self._play(self._episodes, actions)
        self._compare(first, again, "the same seeds and actions give another step")

        for row, episode in enumerate(self._episodes):
            _, alone = self._play([episode], [action[row : row + 1] for action in actions])
            found = f"seed {episode.seed} alone is another episode than in a batch, in step"
            self._compare(first, alone, found, slice(row, row + 1))

        if self._task.is_noiseless(self._condition):
            repeats = [self._task.episode(episode.seed, repeat=1) for episode in self._episodes]
            _, copies = self._play(repeats, actions)
            found = "it is declared noiseless, and its repeats differ in step"
            self._compare(first, copies, found)

        if policy:
            self._check_policy(policy)

    def _play(
        self, episodes: Sequence[Episode], actions: Sequence[Any] = ()
    ) -> tuple[list[Any], list[_Report]]:
        """Play episodes to a horizon of a few steps and beyond; by default choose actions.

        Returns:
            The actions, and what was seen at first and after each.
        """
        count = len(episodes)
        env = self._task.make_env(count, self._condition, _STEPS)
        if env.num_envs != count:
            found = f"`make_env({count}, ...)` made {env.num_envs} environments"
            raise self._broken(found, "make as many")

        try:
            seen = [copy.deepcopy(env.reset(**self._task.reset_arguments(episodes)))]
            if not actions:
                env.action_space.seed(0)
                actions = [env.action_space.sample() for _ in range(_STEPS)]
            for action in actions:
                observation, *_, info = env.step(action)
                seen.append(copy.deepcopy((observation, info)))

            self._check_at_rest(env, actions[-1])
            return list(actions), seen
        finally:
            env.close()

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

        # It ends, and stays where it is.
        if not np.all(terminated | truncated):
            found = f"episodes go on after the horizon of {_STEPS} steps"
            right = "`make_env` has to end them there, as gymnasium's TimeLimit does"
            raise self._broken(found, right)
        if not np.array_equal(info["position"], later["position"]):
            right = "disable autoreset, and let it stand still"
            raise self._broken("an episode that has ended moves", right)

    def _check_info(self, info: Mapping[str, Any], after_a_step: bool) -> None:
        """The info has what rows are made of, in the right shape."""
        numbers = ["distance", *(measure.key for measure in self._task.measures)]
        if after_a_step:
            numbers += ["is_success", "collision"]

        for key in (*numbers, "position"):
            if key not in info:
                raise self._broken(f"info has no {key!r}", f"it has: {', '.join(sorted(info))}")

            value = np.asarray(info[key])
            if key in numbers and value.shape != (_COUNT,):
                found = f"info[{key!r}] has shape {value.shape}"
                raise self._broken(found, f"one number an episode is ({_COUNT},)")
            if value.dtype == object or not np.isfinite(value).all():
                raise self._broken(f"info[{key!r}] is {value}", "it is finite numbers")

        where = np.shape(info["position"])
        if where not in ((_COUNT, 2), (_COUNT, 3)):
            right = f"it is ({_COUNT}, 2) for {_COUNT} episodes, or ({_COUNT}, 3)"
            raise self._broken(f"info['position'] has shape {where}", right)

    def _compare(
        self,
        first: Sequence[_Report],
        other: Sequence[_Report],
        found: str,
        rows: slice = slice(None),
    ) -> None:
        """Two plays of the same episodes agree in every step, some rows of the first."""
        for step, (one, another) in enumerate(zip(first, other, strict=True)):
            difference = _difference(_shown(one), _shown(another), rows)
            if difference:
                right = "what happens depends on the seed in `reset_arguments` and the actions only"
                raise self._broken(f"{found} {step}: {difference}", right)

    def build(self, name: str) -> Any:
        """A policy, which accepts what it is told about the condition."""
        from aicon_baselines.agents.registry import make
        from aicon_torch.errors import OptionError

        try:
            return make(self._task, name, self._condition)
        except OptionError as error:
            right = "its preset and `policy_options` name options of its model"
            raise self._broken(f"the policy {name!r} cannot be built: {error}", right) from error

    def _check_policy(self, name: str) -> None:
        """A policy accepts what it is told, and its actions are those of the environment."""
        policy = self.build(name)
        options = getattr(policy, "env_options", {})
        env = self._task.make_env(_COUNT, self._condition, _STEPS, **options)
        try:
            observation, _ = env.reset(**self._task.reset_arguments(self._episodes))
            action, _ = policy.predict(observation, None, np.ones(_COUNT, np.bool_))
        finally:
            env.close()
        if action.shape != env.action_space.shape or not np.isfinite(action).all():
            right = f"finite numbers {env.action_space.shape} are the environment's actions"
            raise self._broken(f"the policy {name!r} acts with shape {action.shape}", right)

        # What is sent is what the environment takes: its own units, not the policy's.
        space = env.action_space
        if isinstance(space, Box):
            beyond = np.maximum(action - space.high, space.low - action)
            if not (beyond <= _ROUNDED * (1 + np.abs(action))).all():
                right = "an actuator's `command` makes the environment's actions of its velocities"
                found = f"the policy {name!r} acts with {action.tolist()}, beyond the action space"
                raise self._broken(found, right)

    def _broken(self, found: str, right: str) -> ComparisonError:
        return ComparisonError(
            f"task {self._task.name!r}, condition {self._condition!r}: {found}; {right}"
        )


def _shown(report: _Report) -> dict[str, Any]:
    """What two plays of an episode have to agree on."""
    observation, info = report
    return {"observation": observation, "position": info["position"], "distance": info["distance"]}


def _difference(one: Any, other: Any, rows: slice, name: str = "") -> str:
    """Say where some rows of nested values differ from others; nothing if they do not."""
    if isinstance(one, Mapping):
        found = (_difference(one[key], other[key], rows, key) for key in one)
        return next(filter(None, found), "")

    # The sums of a batch are rounded in another order.
    one, other = np.asarray(one)[rows], np.asarray(other)
    if one.dtype.kind == "f":
        agrees = np.allclose(one, other, rtol=1e-5, atol=1e-6, equal_nan=True)
    else:
        agrees = np.array_equal(one, other)
    return "" if agrees else f"{name} {one.tolist()} and {other.tolist()}"
