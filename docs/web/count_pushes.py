"""Push the T in two worlds from the same starts: gym-pusht's, and that of the page, in Node.js.

The policy is one and the same file. Starts are those of gym-pusht with these seeds.

Example: python docs/web/count_pushes.py --seed 300000 --starts 200
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import gymnasium as gym

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.cli.command_line import Command, run_command
from aicon_torch import Policy, make_policy
from building import scripts
from building.packing import compiled
from building.pushing import table

STEPS = 300
"""How many steps there are, those of the benchmark."""

Row = dict[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare which starts there are."""
    parser.add_argument("--seed", type=int, default=300_000, help="the first (default: 300000)")
    parser.add_argument("--starts", type=int, default=200, help="how many (default: 200)")


def run(arguments: argparse.Namespace) -> None:
    """Print a line for each world: how many succeed, after how many steps, and which do not."""
    policy = make_policy("pusht", observe_goal=True)
    seeds = range(arguments.seed, arguments.seed + arguments.starts)
    starts = [start_of(seed) for seed in seeds]
    print(f"gym-pusht  {told(in_the_benchmark(policy, seeds), seeds)}")
    print(f"planck     {told(in_planck(policy, starts), seeds)}")


def told(rows: list[Row], seeds: range) -> str:
    """What came of some starts, in words."""
    steps = sorted(row["steps"] for row in rows if row["success"])
    failed = [seed for seed, row in zip(seeds, rows, strict=True) if not row["success"]]
    middle = steps[len(steps) // 2] if steps else None
    return f"{len(steps)}/{len(rows)} within {STEPS} steps, median {middle}; failed: {failed}"


def start_of(seed: int) -> Row:
    """Where gym-pusht puts the disc and the T, px and rad."""
    _, info = gym.make("aicon/PushT-v0", observe_goal=True).reset(seed=seed)
    return {"pusher": info["pos_agent"].tolist(), "pose": info["block_pose"].tolist()}


def in_the_benchmark(policy: Policy, seeds: range) -> list[Row]:
    """The starts in our copy of gym-pusht, which equals it number for number."""
    env, compiled_policy = gym.make("aicon/PushT-v0", observe_goal=True), policy.compile()
    rows: list[Row] = []
    for seed in seeds:
        (observation, info), memory, steps = env.reset(seed=seed), None, 0
        while steps < STEPS and not info["is_success"]:
            action, memory = compiled_policy.predict(observation, memory)
            observation, _, _, _, info = env.step(action)
            steps += 1
        rows.append({"success": bool(info["is_success"]), "steps": steps})
    return rows


def in_planck(policy: Policy, starts: list[Row]) -> list[Row]:
    """The starts in the page's world."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "policy.wasm").write_bytes(compiled(policy))
        task = {"table": table(), "starts": starts, "steps": STEPS}
        Path(folder, "task.json").write_text(json.dumps(task))
        script = scripts.bundle("worlds/push_from.mjs", "esm")
        printed = scripts.run("node", "--input-type=module", "-", folder, given=script)
    rows: list[Row] = json.loads(printed)
    return rows


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
