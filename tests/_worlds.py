"""Episodes in other people's worlds."""

from collections.abc import Iterator, Sequence
from typing import Any


def episodes(
    world: Any, condition: str, seeds: Sequence[int], horizon: int | None = None, task: Any = None
) -> Iterator[tuple[Any, Any]]:
    """What is seen and told after each step of a batch, until all its episodes have ended."""
    task = task or world.TASK
    policy = world.build(world.Options(**task.policy_options(condition))).compile()
    env = task.make_env(len(seeds), condition, horizon or task.horizon)
    (observation, _), memory, is_over = env.reset(seed=list(seeds)), None, False
    while not is_over:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        yield observation, info
        is_over = (terminated | truncated).all()
    env.close()


def succeed(
    world: Any, condition: str, seeds: Sequence[int], horizon: int | None = None, task: Any = None
) -> bool:
    """Whether all episodes of a batch end with success."""
    *_, (_, told) = episodes(world, condition, seeds, horizon, task)
    return bool(told["is_success"].all())
