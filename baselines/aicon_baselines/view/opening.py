"""Opening an episode to look at: the task's environment and a policy that tells what it decides."""

import logging
from dataclasses import dataclass, replace
from typing import Any

from aicon_baselines.agents.registry import ModelPolicy, factory
from aicon_baselines.agents.variants import parse_variant
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_baselines.view.episode import LiveEpisode

_LOGGER = logging.getLogger(__name__)


@dataclass(frozen=True)
class Opening:
    """An episode that can be opened: its names are right, and nothing is built yet.

    Attributes:
        task: The task, with the maps and the horizon of the episode.
        condition: A condition of it.
        build: What builds the policy.
        seed: Seed of the episode.
    """

    task: Task
    condition: str
    build: ModelPolicy
    seed: int

    @classmethod
    def of(
        cls, task_name: str, policy: str = "aicon", condition: str | None = None, seed: int = 0
    ) -> "Opening":
        """What :func:`open_episode` opens; arguments and errors are the same."""
        # The names are checked as in a comparison.
        task = load(task_name)
        condition = condition or task.look.condition
        conditions = [condition] if condition else None
        config = configure(task, seed=seed, episodes=1, conditions=conditions, horizon=None)
        task, condition = config.apply(task), config.conditions[0]
        if condition == "upstream":
            raise ComparisonError(
                "the condition 'upstream' cannot be watched; 'deterministic' is the same world"
            )

        name, options = parse_variant(policy)
        build = factory(task.name, name, **options)
        if not isinstance(build, ModelPolicy):
            raise ComparisonError(
                f"the policy {name!r} has no gradients to show; aicon watch shows policies of the "
                "library, such as aicon, steepest or potential_field"
            )
        options = {**task.look.options, **build.options}
        return cls(task, condition, replace(build, options=options), seed)

    def open(self) -> LiveEpisode:
        """Build the policy and its world, and start the episode."""
        task = self.task
        _LOGGER.info("Building the policy; for an arm, whose shape is fitted, it takes a while.")
        policy: Any = self.build(self.condition)

        _LOGGER.info("Building the world.")
        env = task.make_env(1, self.condition, task.horizon, **task.look.options)

        def start_arguments(seed: int) -> dict[str, Any]:
            return task.reset_arguments([task.episode(seed)])

        episode = LiveEpisode(task.name, env, policy, start_arguments)
        episode.start(self.seed)
        return episode


def open_episode(
    task_name: str, policy: str = "aicon", condition: str | None = None, seed: int = 0
) -> LiveEpisode:
    """Build an episode of a task, and start it.

    Args:
        task_name: Name of the task.
        policy: Name of the policy, options of it, or both, as in `aicon run`.
        condition: A condition of the task; by default the usual one, or one with more to see.
        seed: Seed of the episode.

    Raises:
        ComparisonError: If a name is unknown, or the policy is none of the library's.
    """
    return Opening.of(task_name, policy, condition, seed).open()
