"""Run the policies of two pages from many starts, in Node.js: how many arrive, and which do not.

The T is pushed in two worlds from the same starts, which are those of gym-pusht with these seeds:
gym-pusht's own, and that of the page. The policy is one and the same file.

Example: python docs/web/count_starts.py pusht --seed 300000 --starts 200
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import gymnasium as gym

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.cli.command_line import Command, add_option, run_command
from aicon_torch import Policy, make_policy
from building import arm, scripts
from building.packing import compiled
from building.pushing import table

STEPS = {"pusht": 300, "arm": 1000}
"""How many steps there are: those of the benchmark, and 20 s."""

Row = dict[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare which page it is, and which starts there are."""
    parser.add_argument("page", choices=tuple(STEPS), help="of which page")
    add_option(parser, "--seed", 300_000, "the first")
    add_option(parser, "--starts", 200, "how many")


def run(arguments: argparse.Namespace) -> None:
    """Print a line for each world."""
    seeds = range(arguments.seed, arguments.seed + arguments.starts)
    if arguments.page == "arm":
        rows = in_the_page("arm", make_policy(arm), arm.sizes(), list(seeds))
        touched = sum(row["touches"] > 0 for row in rows)
        print(f"arm  {told(rows, seeds, STEPS['arm'])}; in {touched} a link touches the ball")
        return

    policy = make_policy("pusht", observe_goal=True)
    starts = [start_of(seed) for seed in seeds]
    print(f"gym-pusht  {told(in_the_benchmark(policy, seeds), seeds, STEPS['pusht'])}")
    rows = in_the_page("pusht", policy, table(), starts)
    print(f"planck     {told(rows, seeds, STEPS['pusht'])}")


def told(rows: list[Row], seeds: range, most: int) -> str:
    """What came of some starts, in words."""
    steps = sorted(row["steps"] for row in rows if row["success"])
    failed = [seed for seed, row in zip(seeds, rows, strict=True) if not row["success"]]
    middle = steps[len(steps) // 2] if steps else None
    return f"{len(steps)}/{len(rows)} within {most} steps, median {middle}; failed: {failed}"


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
        while steps < STEPS["pusht"] and not info["is_success"]:
            action, memory = compiled_policy.predict(observation, memory)
            observation, _, _, _, info = env.step(action)
            steps += 1
        rows.append({"success": bool(info["is_success"]), "steps": steps})
    return rows


def in_the_page(page: str, policy: Policy, sizes: Row, starts: list[Any]) -> list[Row]:
    """The starts in a page's world: seeds, or where things are, px and rad."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "policy.wasm").write_bytes(compiled(policy))
        task = {"page": page, "sizes": sizes, "starts": starts, "steps": STEPS[page]}
        Path(folder, "task.json").write_text(json.dumps(task))
        script = scripts.bundle("worlds/run_from.mjs", "esm")
        printed = scripts.run("node", "--input-type=module", "-", folder, given=script)
    rows: list[Row] = json.loads(printed)
    return rows


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
