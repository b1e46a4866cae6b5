"""One episode, four rules: what should happen where gradients meet?

What you learn: the rule is one argument. Graph, estimators, limits and start are the same four
times; only what happens to the gradients that meet at a quantity differs.

- `NullspaceProjection()`: ordered by strength, each projected into the nullspaces of the stronger
  ones; where the strongest two oppose each other, exploration. As the library ships it.
- `Sum()`: added up. That is plain backpropagation, a potential field.
- `SteepestPath()`: the steepest complete path and nothing else (Eq. 2 of the paper).
- `NullspaceProjection.as_in_paper()`: the paper's text, without what we added to the rule.

One episode shows how they differ, not how often each succeeds: docs/results/pusht.md says that.

    python examples/03_compare_resolutions.py
"""

from typing import NamedTuple

import gymnasium as gym

import aicon_envs  # noqa: F401  # registers the environments
from aicon_torch import NullspaceProjection, Resolution, SteepestPath, Sum, make_policy

SEED = 3
HORIZON = 300  # steps, the benchmark's own

RULES: dict[str, Resolution] = {
    "NullspaceProjection()": NullspaceProjection(),
    "Sum()": Sum(),
    "SteepestPath()": SteepestPath(),
    "NullspaceProjection.as_in_paper()": NullspaceProjection.as_in_paper(),
}


class Outcome(NamedTuple):
    """How an episode went.

    Attributes:
        success: Whether the T covered its target.
        steps: How many steps it took.
        coverage: Share of the target that was covered at the end.
        explored: Share of the steps in which a quantity explored.
    """

    success: bool
    steps: int
    coverage: float
    explored: float


def push(resolution: Resolution) -> Outcome:
    """Push the T with this rule."""
    env = gym.make("aicon/PushT-v0", max_episode_steps=HORIZON)
    policy = make_policy("pusht", resolution=resolution).compile()  # the same, much faster

    observation, info = env.reset(seed=SEED)
    memory, steps, exploring_steps, ended = None, 0, 0, False

    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        ended = terminated or truncated

        steps += 1
        quantities = policy.trace(memory).quantities.values()
        exploring_steps += any(bool(quantity.exploring) for quantity in quantities)

    env.close()
    return Outcome(info["is_success"], steps, info["coverage"], exploring_steps / steps)


def main() -> None:
    """Run the episode with each rule and print a table."""
    outcomes: dict[str, Outcome] = {}
    print(f"{'rule':35} {'success':>8} {'steps':>6} {'covered':>8} {'explored':>9}")

    for name, resolution in RULES.items():
        outcome = push(resolution)
        outcomes[name] = outcome

        success = "yes" if outcome.success else "no"
        numbers = f"{outcome.steps:6d} {outcome.coverage:8.0%} {outcome.explored:9.0%}"
        print(f"{name:35} {success:>8} {numbers}")

    if not outcomes["NullspaceProjection()"].success:
        raise SystemExit("\nThe shipped rule did not solve this episode.")
    print("\nThe shipped rule solves the episode.")


if __name__ == "__main__":
    main()
