"""An object of your own: the same policy pushes an arrow.

What you learn: the environment and the policy take any simple polygon. The policy derives all that
it needs from the corners: sides, centre of mass, radius of gyration. No constant changes.

One thing to mind is the unit. The environment is the benchmark's, a picture of 512 px; the library
counts in metres, and takes the picture for half a metre: PIXEL is the size of one px.

    python examples/05_own_object.py
"""

import gymnasium as gym

import aicon_envs  # noqa: F401  # registers the environments
from aicon_torch import Policy, make_policy
from aicon_torch.models.pusht import PIXEL

# Corners in order around the object, px. It need not be convex.
ARROW = [[0, -60], [50, 0], [20, 0], [20, 60], [-20, 60], [-20, 0], [-50, 0]]


def main() -> None:
    """Push the arrow in three episodes."""
    env = gym.make("aicon/PushT-v0", object=ARROW)

    corners = [[x * PIXEL, y * PIXEL] for x, y in ARROW]
    policy = make_policy("pusht", keypoints=corners).compile()  # the same, much faster

    paths = list(policy.model.paths())
    print(f"{len(ARROW)} sides, and two paths through each: {len(paths)} paths, such as")
    print(f"  {paths[0]}\n  {paths[-1]}\n")

    solved = 0
    for seed in range(3):
        success, steps = push(env, policy, seed)
        solved += success
        print(f"seed {seed}: {'in place' if success else 'not in place'} after {steps} steps")

    if solved < 3:
        raise SystemExit("\nThe arrow was not always pushed into place.")
    print("\nThe arrow is in place each time.")


def push(env: gym.Env, policy: Policy, seed: int) -> tuple[bool, int]:
    """Run one episode: whether it succeeded, and how many steps it took."""
    observation, info = env.reset(seed=seed)
    memory, steps, ended = None, 0, False

    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        ended = terminated or truncated
        steps += 1

    return info["is_success"], steps


if __name__ == "__main__":
    main()
