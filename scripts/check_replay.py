"""Hold the compiled and the exported step against the readable one.

Example: python scripts/check_replay.py --tasks nav2d pusht --steps 1000 --episodes 3

Replayed: at each recorded observation all step from the same memory, and what they return is
compared, number by number: |x − y| / (1 + |y|). In float32 so is the step in float64, since where
two gradients, or two sides of an object, are next to equal, rounding decides. Closed loops: each
runs the same episodes on its own, and the steps until the end are counted. A task may be followed
by a condition: nav2d, arm_push:true_pose.
"""

import argparse
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from tqdm import tqdm

from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.bench import record_episodes, record_observations
from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.tasks import load
from aicon_torch import load_exported

TASKS = ["nav2d", "pusht", "arm_push:true_pose", "arm_push:camera", "reach"]
TOLERANCES = {"float64": 1e-10, "float32": 1e-5}
SEED = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the tasks and how much to compare."""
    parser.add_argument("--tasks", nargs="+", default=TASKS, help="default: all")
    parser.add_argument("--dtypes", nargs="+", choices=TOLERANCES, default=list(TOLERANCES))
    parser.add_argument(
        "--steps", type=int, default=1000, help="recorded observations (default: 1000)"
    )
    parser.add_argument(
        "--episodes", type=int, default=0, help="closed loops of each policy (default: none)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Compare, and print a line for each comparison."""
    torch.set_num_threads(1)
    for task in arguments.tasks:
        name, _, condition = task.partition(":")
        condition = condition or load(name).conditions[0]

        for dtype in arguments.dtypes:
            if arguments.steps:
                tolerance = TOLERANCES[dtype]
                policies = build_all(name, condition, dtype)
                for line in replayed(name, condition, arguments.steps, policies, tolerance):
                    print(f"{task}, {dtype}: {line}", flush=True)
        if arguments.episodes:
            lengths = closed_loops(name, condition, arguments.episodes)
            print(f"{task}, steps until the end: {lengths}", flush=True)


def build_all(task: str, condition: str, dtype: str) -> dict[str, Any]:
    """The policy in its three forms."""
    policy: Any = factory(task, "aicon", dtype=getattr(torch, dtype))(condition)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "policy.so")
        policy.export(file)
        exported = load_exported(file, perception=policy.perception)
    policies = {"readable": policy, "compiled": policy.compile(), "exported": exported}
    if dtype != "float64":
        exact: Any = factory(task, "aicon")(condition)
        policies["compiled in float64"] = exact.compile()
    return policies


def replayed(
    task: str, condition: str, steps: int, policies: dict[str, Any], tolerance: float
) -> Iterator[str]:
    """Compare steps from the same memory, and say by how much they differ."""
    readable = policies.pop("readable")
    deviations: dict[str, list[dict[str, float]]] = {name: [] for name in policies}
    memory: Any = None

    recorded = record_episodes(task, condition, steps)
    for observation, begins in tqdm(recorded, desc=task, disable=None):
        before = None if begins else memory
        action, memory = readable.predict(observation, before)
        for name, policy in policies.items():
            own_action, after = policy.predict(observation, before)
            entries = {"the action": deviation(own_action, action)}
            entries |= {entry: deviation(after[entry], memory[entry]) for entry in memory}
            deviations[name].append(entries)

    for name, found in deviations.items():
        largest = np.array([max(entries.values()) for entries in found])
        worst = int(largest.argmax())
        entry = max(found[worst], key=lambda entry: found[worst][entry])
        beyond = int((largest > tolerance).sum())
        of_actions = max(entries["the action"] for entries in found)
        yield (
            f"{name}, {len(found)} steps: {largest.max():.1e} at most ({entry}, step {worst}), "
            f"median {np.median(largest):.1e}, beyond {tolerance:.0e} in {beyond}; "
            f"actions {of_actions:.1e}"
        )


def deviation(found: Any, expected: Any) -> float:
    """The largest |x − y| / (1 + |y|); infinite where only one is a number."""
    x, y = (np.asarray(value, dtype=np.float64) for value in (found, expected))
    same = (x == y) | (np.isnan(x) & np.isnan(y))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(x - y) / (1 + np.abs(y)))
    return float(np.nan_to_num(apart, nan=np.inf).max(initial=0.0))


def closed_loops(task: str, condition: str, episodes: int) -> Mapping[str, list[int]]:
    """How many steps each policy takes until the end of each episode."""
    horizon = load(task).horizon
    lengths: dict[str, list[int]] = {}
    for name, policy in build_all(task, condition, "float64").items():
        lengths[name] = []
        for seed in range(SEED, SEED + episodes):
            observations = record_observations(task, condition, horizon, seed, policy)
            lengths[name].append(len(observations))
    return lengths


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
