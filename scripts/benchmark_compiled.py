"""Time the compiled step beside the uncompiled one: latency of one robot, and steps per second of many.

Example: python scripts/benchmark_compiled.py --out runs/benchmark

Latency is the processor time of `predict` on one thread, on the observations of an episode; the two policies take
turns. Throughput is that of steps on tensors that lie on the device. The first step, which compiles, is timed twice in
processes of their own: with an empty cache, and with what that left there. Rows are saved as they come.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import gymnasium as gym
import torch
from tqdm import tqdm

import aicon_envs  # noqa: F401  # registers the environments
from aicon_torch import Policy, make_policy

ENVIRONMENTS = {"nav2d": "aicon/Nav2D-v0", "pusht": "aicon/PushT-v0"}
BATCHES = [1, 16, 256, 4096, 65536]


def main() -> None:
    """Parse the arguments, measure, print and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", choices=ENVIRONMENTS, default=list(ENVIRONMENTS), help="default: all")
    parser.add_argument("--steps", type=int, default=10_000, help="steps of one robot (default: 10000)")
    parser.add_argument("--batches", nargs="+", type=int, default=BATCHES, help="sizes (default: 1 ... 65536)")
    parser.add_argument("--device", default="cpu", help="device of the batches (default: cpu)")
    parser.add_argument("--out", type=Path, required=True, help="folder for compiled.json")
    parser.add_argument("--first-step", metavar="TASK", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    if arguments.first_step:
        print(time_first_step(arguments.first_step))
        return
    if arguments.device != "cpu" and not torch.accelerator.is_available():
        parser.error(f"--device {arguments.device}: torch finds no accelerator here")
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "compiled.json"
    results: dict[str, Any] = {}
    for task in arguments.tasks:
        row: dict[str, Any] = {"first_step_s": time_first_steps(task, arguments.out)}
        row["latency_ms"] = measure_latency(task, arguments.steps)
        row["throughput"] = []
        results[task] = row
        cold, warm = row["first_step_s"]
        print(f"\n{task}: the first step takes {cold:.0f} s, {warm:.0f} s once the cache is filled")
        for name, latency in row["latency_ms"].items():
            print(f"  {name:11} {latency['median']:.3f} ms, 99th percentile {latency['percentile_99']:.3f} ms")
        print(f"  steps per second on one {arguments.device}" + (" thread" if arguments.device == "cpu" else ""))
        for batch in arguments.batches:
            speeds = measure_throughput(task, batch, torch.device(arguments.device))
            row["throughput"].append({"batch": batch, **speeds})
            path.write_text(json.dumps({"device": arguments.device, "tasks": results}, indent=2) + "\n")
            print(f"  {batch:6}   uncompiled {speeds['uncompiled']:11,.0f}   compiled {speeds['compiled']:11,.0f}")
    print(f"\nsaved in {path}")


def time_first_steps(task: str, out: Path) -> tuple[float, float]:
    """Seconds of the first step with an empty cache, and with what it left there."""
    command = [sys.executable, "-W", "ignore", __file__, "--first-step", task, "--out", str(out)]
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "TORCHINDUCTOR_CACHE_DIR": cache}
        cold, warm = (
            float(subprocess.run(command, env=environment, check=True, capture_output=True).stdout) for _ in range(2)
        )
    return cold, warm


def time_first_step(task: str) -> float:
    """Seconds until a compiled policy has chosen its first action."""
    observation, _ = gym.make(ENVIRONMENTS[task]).reset(seed=1000)
    policy = make_policy(task).compile()
    start = time.perf_counter()
    policy.predict(observation)
    return time.perf_counter() - start


def measure_latency(task: str, steps: int, turn: int = 100) -> dict[str, dict[str, float]]:
    """Median and 99th percentile of the processor time of `predict`, ms, uncompiled and compiled."""
    policies = _pair(task)
    observations = _episode(policies["uncompiled"], task, turn)
    times: dict[str, list[float]] = {name: [] for name in policies}
    for _ in tqdm(range(0, steps, turn), desc=task, disable=None):
        for name, policy in policies.items():
            memory = policy.predict(observations[0])[1]
            for observation in observations:
                start = time.process_time()
                _, memory = policy.predict(observation, memory)
                times[name].append(1e3 * (time.process_time() - start))
    return {
        name: {"median": statistics.median(taken), "percentile_99": statistics.quantiles(taken, n=100)[-1]}
        for name, taken in times.items()
    }


def measure_throughput(task: str, batch: int, device: torch.device, seconds: float = 1.0) -> dict[str, float]:
    """Steps per second of a batch of robots, each a little elsewhere, uncompiled and compiled."""
    speeds = {}
    for name, policy in _pair(task).items():
        policy.to(device)
        start, _ = gym.make(ENVIRONMENTS[task]).reset(seed=1000)
        readings = {
            key: torch.as_tensor(value, device=device).double() + 0.01 * torch.randn(batch, len(value), device=device)
            for key, value in start.items()
        }
        memory = policy.predict(readings)[1]
        memory = policy.predict(readings, memory)[1]
        count, spent = 0, 0.0
        while spent < seconds:
            began = _now(device)
            for _ in range(5):
                memory = policy.predict(readings, memory)[1]
            spent += _now(device) - began
            count += 5 * batch
        speeds[name] = count / spent
    return speeds


def _now(device: torch.device) -> float:
    """Processor time, or the time when a device has done what it was given, s."""
    if device.type == "cpu":
        return time.process_time()
    torch.accelerator.synchronize()
    return time.perf_counter()


def _pair(task: str) -> dict[str, Policy]:
    return {"uncompiled": make_policy(task), "compiled": make_policy(task).compile()}


def _episode(policy: Policy, task: str, steps: int) -> list[Mapping[str, Any]]:
    """The observations of the first steps of an episode, or of several."""
    env, observations, done, memory = gym.make(ENVIRONMENTS[task]), [], True, None
    for seed in range(1000, 1000 + steps):
        if done:
            observation, _ = env.reset(seed=seed)
            memory, done = None, False
        observations.append(observation)
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, _ = env.step(action)
        done = terminated or truncated
    return observations


if __name__ == "__main__":
    main()
