"""Many robots, one policy: a batch of 64, and a memory that outlives the process.

What you learn: leading dimensions are a batch, so that one call steps 64 robots. The policy has no
state; all that lives from step to step is in the memory, a flat dictionary of tensors. So
`torch.save` keeps 64 episodes, and another policy, in another process, goes on with them. Where
episodes begin at different times, `episode_start` says which.

    python examples/04_many_robots.py
"""

import statistics
import tempfile
import time
from pathlib import Path

import gymnasium as gym
import numpy as np
import torch

import aicon_envs  # noqa: F401  # registers the environments
from aicon_torch import Policy, make_policy

ROBOTS = 64
STEPS = 600  # 30 s of simulated time


def make_navigator() -> Policy:
    """The policy of every robot; its first step compiles, and then it is many times as fast."""
    return make_policy("nav2d").compile()


def main() -> None:
    """Step 64 robots, stop in the middle, and go on with what was saved."""
    env = gym.make_vec(
        "aicon/Nav2D-v0",
        num_envs=ROBOTS,
        vectorization_mode="vector_entry_point",
        map="clutter",
    )
    policy = make_navigator()
    observation, _ = env.reset(seed=0)

    memory = None
    starts = np.ones(ROBOTS, dtype=bool)  # robots whose observation is the first of an episode
    ended = np.zeros(ROBOTS, dtype=bool)
    arrivals = collisions = 0
    times: list[float] = []

    for step in range(STEPS):
        if step == STEPS // 2:
            memory = save_and_load(memory)
            policy = make_navigator()

        begun = time.perf_counter()
        action, memory = policy.predict(observation, memory, starts)
        times.append(time.perf_counter() - begun)

        # Where an episode ended, this step begins a new one: then the robot's memory starts anew.
        starts = ended
        observation, _, terminated, truncated, info = env.step(action)

        ended = terminated | truncated
        arrivals += int((terminated & info["is_success"]).sum())
        collisions += int((terminated & info["collision"]).sum())

    step_time = statistics.median(times)
    print(f"{ROBOTS} robots, {STEPS} steps: {arrivals} arrivals, {collisions} collisions")
    print(f"one step of all: {step_time * 1e3:.1f} ms here, {ROBOTS / step_time:.0f} a second")

    if arrivals < ROBOTS // 2 or collisions > 0:
        raise SystemExit("\nThey did not get far.")
    print("\nThe robots arrive, and none noticed that it was saved and loaded in between.")


def save_and_load(memory: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """The same memory, by way of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "memory.pt"
        torch.save(memory, path)
        print(f"saved {len(memory)} tensors, {path.stat().st_size / 1024:.0f} KiB")
        return torch.load(path)


if __name__ == "__main__":
    main()
