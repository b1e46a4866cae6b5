"""Time the compiled step beside the uncompiled one: latency of one robot, throughput of many.

Example: python scripts/benchmark_compiled.py --out runs/benchmark

Latency is the processor time of `predict` on one thread, on the observations of an episode; the two
policies take turns. Throughput is that of steps on tensors that lie on the device. The first step,
which compiles, is timed twice in processes of their own: with an empty cache, and with what that
left there. Rows are saved as they come.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, run_command

# isort: split

import gymnasium as gym
import torch
from tqdm import tqdm

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines.cli.bench import record_observations
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks import load
from aicon_torch import Policy, make_policy

ENVIRONMENTS = {"nav2d": "aicon/Nav2D-v0", "pusht": "aicon/PushT-v0"}
BATCHES = [1, 16, 256, 4096, 65536]
SEED = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the tasks, the device and how much to measure."""
    parser.add_argument(
        "--tasks", nargs="+", choices=ENVIRONMENTS, default=list(ENVIRONMENTS), help="default: all"
    )
    parser.add_argument(
        "--steps", type=int, default=10_000, help="steps of one robot (default: 10000)"
    )
    parser.add_argument(
        "--batches", nargs="+", type=int, default=BATCHES, help="sizes (default: 1 ... 65536)"
    )
    parser.add_argument("--device", default="cpu", help="device of the batches (default: cpu)")
    parser.add_argument("--out", type=Path, required=True, help="folder for compiled.json")
    parser.add_argument("--first-step", metavar="TASK", help=argparse.SUPPRESS)


def run(arguments: argparse.Namespace) -> None:
    """Measure, print and save task by task."""
    torch.set_num_threads(1)
    if arguments.first_step:
        print(time_first_step(arguments.first_step))
        return

    device = arguments.device
    if device != "cpu" and not torch.accelerator.is_available():
        raise ComparisonError(f"--device {device}: torch finds no accelerator here")
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "compiled.json"

    results: dict[str, Any] = {}
    for task in arguments.tasks:
        row: dict[str, Any] = {
            "first_step_s": time_first_steps(task, arguments.out),
            "latency_ms": measure_latency(task, arguments.steps),
            "throughput": [],
        }
        results[task] = row
        print_latency(task, row)

        where = "one cpu thread" if device == "cpu" else f"one {device}"
        print(f"  steps per second on {where}")
        for batch in arguments.batches:
            speeds = measure_throughput(task, batch, torch.device(device))
            row["throughput"].append({"batch": batch, **speeds})

            path.write_text(json.dumps({"device": device, "tasks": results}, indent=2) + "\n")
            uncompiled, compiled = speeds["uncompiled"], speeds["compiled"]
            print(f"  {batch:6}   uncompiled {uncompiled:11,.0f}   compiled {compiled:11,.0f}")
    print(f"\nsaved in {path}")


def print_latency(task: str, row: dict[str, Any]) -> None:
    """Print the time of the first step, and of the others."""
    cold, warm = row["first_step_s"]
    print(f"\n{task}: the first step takes {cold:.0f} s, {warm:.0f} s once the cache is filled")

    for name, latency in row["latency_ms"].items():
        median, slow = latency["median"], latency["percentile_99"]
        print(f"  {name:11} {median:.3f} ms, 99th percentile {slow:.3f} ms")


def time_first_steps(task: str, out: Path) -> tuple[float, float]:
    """Seconds of the first step with an empty cache, and with what it left there."""
    script = [sys.executable, "-W", "ignore", __file__]
    command = [*script, "--first-step", task, "--out", str(out)]

    with tempfile.TemporaryDirectory() as cache:
        caches = {"TORCHINDUCTOR_CACHE_DIR": cache, "XDG_CACHE_HOME": cache}
        environment = {**os.environ, **caches}

        def time_once() -> float:
            done = subprocess.run(command, env=environment, check=True, capture_output=True)
            return float(done.stdout)

        return time_once(), time_once()


def time_first_step(task: str) -> float:
    """Seconds until a compiled policy has chosen its first action."""
    observation, _ = gym.make(ENVIRONMENTS[task]).reset(seed=SEED)
    policy = make_policy(task).compile()

    start = time.perf_counter()
    policy.predict(observation)
    return time.perf_counter() - start


def measure_latency(task: str, steps: int, turn: int = 100) -> dict[str, dict[str, float]]:
    """Median and 99th percentile of the processor time of `predict`, ms, of both policies."""
    policies = build_both(task)
    observations = record_observations(task, load(task).conditions[0], turn, SEED)
    times: dict[str, list[float]] = {name: [] for name in policies}

    for _ in tqdm(range(0, steps, turn), desc=task, disable=None):
        for name, policy in policies.items():
            memory = policy.predict(observations[0])[1]
            for observation in observations:
                start = time.process_time()
                _, memory = policy.predict(observation, memory)
                times[name].append(1e3 * (time.process_time() - start))

    summary = {}
    for name, taken in times.items():
        slow = statistics.quantiles(taken, n=100)[-1]
        summary[name] = {"median": statistics.median(taken), "percentile_99": slow}
    return summary


def measure_throughput(
    task: str, batch: int, device: torch.device, seconds: float = 1.0
) -> dict[str, float]:
    """Steps per second of a batch of robots, each a little elsewhere, of both policies."""
    start, _ = gym.make(ENVIRONMENTS[task]).reset(seed=SEED)
    speeds = {}

    for name, policy in build_both(task).items():
        policy.to(device)
        readings = {}
        for key, reading in start.items():
            scatter = 0.01 * torch.randn(batch, len(reading), device=device)
            readings[key] = torch.as_tensor(reading, device=device).double() + scatter

        # The first two steps may compile: one without a memory, and one with.
        memory = policy.predict(readings)[1]
        memory = policy.predict(readings, memory)[1]

        count, spent = 0, 0.0
        while spent < seconds:
            began = read_clock(device)
            for _ in range(5):
                memory = policy.predict(readings, memory)[1]
            spent += read_clock(device) - began
            count += 5 * batch
        speeds[name] = count / spent
    return speeds


def read_clock(device: torch.device) -> float:
    """Processor time, or the time when a device has done what it was given, s."""
    if device.type == "cpu":
        return time.process_time()
    torch.accelerator.synchronize()
    return time.perf_counter()


def build_both(task: str) -> dict[str, Policy]:
    """The policy uncompiled and compiled."""
    return {"uncompiled": make_policy(task), "compiled": make_policy(task).compile()}


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
