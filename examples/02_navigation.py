"""Out of a trap: 2D navigation, and what happened at the conflict.

What you learn: how a policy runs in a Gymnasium environment, and how `policy.trace` tells, for
every step, what met where and who won.

A disc sees the bearing of its target and feels how near the nearest obstacle is: two numbers, no
position, no map. The target lies behind a U. Going there and keeping clear soon pull in opposite
directions; the disc then explores along the wall, in the nullspace of the obstacle's gradient,
until the way is open.

    python examples/02_navigation.py
"""

import gymnasium as gym

import aicon_envs  # noqa: F401  # registers the environments
from aicon_torch import make_policy
from aicon_torch.inspection import QuantityTrace

SEED = 1


def main() -> None:
    """Run an episode, and tell when the policy explored."""
    env = gym.make("aicon/Nav2D-v0", map="u_trap_1")
    policy = make_policy("nav2d").compile()  # the same, much faster

    observation, info = env.reset(seed=SEED)
    print(f"map {info['map']}: {info['distance']:.1f} m to the target, as the crow flies")

    memory, step = None, 0
    was_exploring, ended = False, False

    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        ended = terminated or truncated
        step += 1

        # All gradients meet at x_rob, the displacement in one step: there a conflict shows.
        displacement = policy.trace(memory).quantities["x_rob"]
        exploring = bool(displacement.exploring)

        if exploring != was_exploring:
            time = step * policy.model.dt
            if exploring:
                print(f"{time:6.2f} s  explores: {describe_conflict(displacement)}")
            else:
                print(f"{time:6.2f} s  goes for the target again, {info['distance']:.1f} m away")
        was_exploring = exploring

    duration = step * policy.model.dt
    print("\nThe last step:")
    print(policy.explain(memory))

    ending = "arrived" if info["is_success"] else "did not arrive"
    print(f"\nThe robot {ending} after {duration:.1f} s.")
    if not info["is_success"]:
        raise SystemExit(1)


def describe_conflict(displacement: QuantityTrace) -> str:
    """Which goals oppose each other at a quantity, and how much."""
    goals = displacement.goals_in_conflict()
    if goals is None:
        return "one gradient alone is left, and the way is not open yet"

    dominant, opponent = goals
    return f"{dominant} against {opponent}, cosine {float(displacement.cosine):+.2f}"


if __name__ == "__main__":
    main()
