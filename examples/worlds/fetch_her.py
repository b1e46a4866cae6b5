"""A learner in Fetch: stable-baselines3's SAC with hindsight experience replay, trained here.

In this folder, with what fetch.py needs:

    python fetch_her.py reach --steps 20000 --out ../../runs/her_reach
    python fetch_her.py push --steps 200000 --out ../../runs/her_push

It is told what the benchmark tells a learner, and its rewards: -1 for each step off the goal. The
episodes are those of `aicon compare --task fetch:TASK --episodes 100 --seed 400000`, and count as
solved where they are so at their last step. A row an episode is written to episodes.csv.

Learning from goals that were reached by chance: Andrychowicz et al., "Hindsight Experience Replay",
2017. The numbers are those of RL Baselines3 Zoo for these worlds, but for SAC in the place of TQC
and smaller networks.
"""

import argparse
import csv
import time
from pathlib import Path
from typing import Any

import gymnasium
from others import needed
from stable_baselines3 import SAC, HerReplayBuffer
from tqdm import tqdm

FIRST_STEPS = 1000  # drawn at random, before it learns


def world_of(task: str) -> gymnasium.Env[Any, Any]:
    """The benchmark's own world, with readings, what was achieved and what was desired."""
    gymnasium.register_envs(needed("gymnasium_robotics", "gymnasium-robotics"))
    return gymnasium.make(f"Fetch{task.capitalize()}-v4")


def learner(world: gymnasium.Env[Any, Any], seed: int) -> SAC:
    """SAC, four of whose five goals are what an episode came to later."""
    return SAC(
        "MultiInputPolicy",
        world,
        replay_buffer_class=HerReplayBuffer,
        replay_buffer_kwargs={"n_sampled_goal": 4, "goal_selection_strategy": "future"},
        learning_starts=FIRST_STEPS,
        learning_rate=1e-3,
        batch_size=256,
        gamma=0.95,
        tau=0.05,
        policy_kwargs={"net_arch": [256, 256]},
        seed=seed,
    )


def solves(agent: SAC, world: gymnasium.Env[Any, Any], seed: int) -> bool:
    """Whether the last step of an episode is at the goal."""
    observation, _ = world.reset(seed=seed)
    while True:
        action, _ = agent.predict(observation, deterministic=True)
        observation, _, terminated, truncated, info = world.step(action)
        if terminated or truncated:
            return bool(info["is_success"])


def main() -> None:
    """Train, keep what was learned, and play the episodes."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("task", choices=["reach", "push"])
    parser.add_argument("--steps", type=int, required=True, help="of training")
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=400000, help="of the first episode")
    parser.add_argument("--out", type=Path, required=True, help="folder of the agent and its rows")
    told = parser.parse_args()

    start, world = time.monotonic(), world_of(told.task)
    agent = learner(world, seed=0).learn(told.steps, progress_bar=True)
    minutes = (time.monotonic() - start) / 60
    told.out.mkdir(parents=True, exist_ok=True)
    agent.save(told.out / "agent.zip")

    solved = 0
    with (told.out / "episodes.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["seed", "success"])
        for seed in tqdm(range(told.seed, told.seed + told.episodes), unit="episode"):
            success = solves(agent, world, seed)
            solved += success
            rows.writerow([seed, success])
            file.flush()
    print(f"{solved} of {told.episodes}, after {told.steps} steps of training, {minutes:.0f} min")


if __name__ == "__main__":
    main()
