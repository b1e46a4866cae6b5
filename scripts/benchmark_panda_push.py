"""Time the arm's loop on one thread: physics and rendering, image, control step, and all of it against real time.

Example: python scripts/benchmark_panda.py --steps 3000 --out runs/benchmark

The loop runs at 100 Hz of simulated time, with an image every fifth step. The control step, reading images left out, is
timed in the loop, where physics and rendering have emptied the processor's caches, and again on what was recorded.
Times are those of the processor, since other programs may run beside; the real-time factor is given by the clock, too.
"""

import argparse
import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import numpy as np
import torch

from aicon_baselines.tasks.panda_push import TASK
from aicon_envs.panda_push import PandaPushEnv
from aicon_torch import make_policy


def main() -> None:
    """Parse the arguments, measure, print and save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--steps",
        type=int,
        default=3000,
        help="control steps, of one episode or more (default: 3000)",
    )
    parser.add_argument(
        "--seed", type=int, default=1000, help="seed of the first episode (default: 1000)"
    )
    parser.add_argument("--uncompiled", action="store_true", help="do not compile the policy")
    parser.add_argument("--out", type=Path, required=True, help="folder for panda.json")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    times = measure(arguments.steps, arguments.seed, not arguments.uncompiled)
    results = summary(times)
    for name, row in results["parts"].items():
        print(f"{name:30} {row['median']:6.3f} ms, 99th percentile {row['percentile_99']:6.3f} ms")
    factors = results["real_time_factor"]
    print(
        f"real-time factor: {factors['processor']:.2f} by processor time, {factors['clock']:.2f} by the clock"
    )
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "panda.json").write_text(json.dumps(results, indent=2) + "\n")


def measure(steps: int, seed: int, compiled: bool) -> dict[str, list[float]]:
    """Seconds of each part in each step, the first step, which compiles, left out."""
    seeing: Any = make_policy("panda_push", **TASK.policy_options("camera"))
    times: dict[str, list[float]] = {
        "environment": [],
        "image": [],
        "control": [],
        "clock": [],
        "again": [],
        "age": [],
    }
    seen: list[Any] = []
    before: list[Any] = []
    seeing.read = _timed(seeing.read, times["image"], seen)
    policy = seeing.compile() if compiled else seeing
    env = PandaPushEnv()
    observation, _ = env.reset(seed=seed)
    policy.predict(observation)
    times["image"].clear()
    seen.clear()
    memory: Any = None
    for _ in range(steps):
        before.append(memory)
        clock, start = time.perf_counter(), time.process_time()
        action, memory = policy.predict(observation, memory)
        decided = time.process_time()
        observation, _, terminated, _, _ = env.step(action)
        times["environment"].append(time.process_time() - decided)
        times["control"].append(decided - start - times["image"][-1])
        times["clock"].append(time.perf_counter() - clock)
        times["age"].append(float(observation["image_age"][0]))
        if terminated:
            seed, memory = seed + 1, None
            observation, _ = env.reset(seed=seed)
    env.close()
    seeing.read = lambda observation, *_: observation
    for observation, memory in zip(seen, before, strict=True):
        start = time.process_time()
        policy.predict(observation, memory)
        times["again"].append(time.process_time() - start)
    return times


def summary(times: dict[str, list[float]]) -> dict[str, Any]:
    """Medians and 99th percentiles, ms, and simulated by spent time."""
    image, environment = np.array(times["image"]), np.array(times["environment"])
    rendered = np.array(times["age"]) < TASK.time_step / 2
    parts = {
        "control step": times["control"],
        "control step on recorded data": times["again"],
        "reading a new image": image[
            image > 10 * np.median(image)
        ],  # between images there is nothing to read
        "environment, without an image": environment[~rendered],
        "environment, with an image": environment[rendered],
    }
    spent = sum(times["control"]) + float(image.sum()) + sum(times["environment"])
    simulated = len(times["clock"]) * TASK.time_step
    return {
        "parts": {
            name: dict(
                zip(
                    ("median", "percentile_99"),
                    (1e3 * np.percentile(part, (50, 99))).tolist(),
                    strict=True,
                )
            )
            for name, part in parts.items()
        },
        "real_time_factor": {
            "processor": simulated / spent,
            "clock": simulated / sum(times["clock"]),
        },
    }


def _timed(
    function: Callable[..., Any], times: list[float], results: list[Any]
) -> Callable[..., Any]:
    def call(*arguments: Any) -> Any:
        start = time.process_time()
        results.append(function(*arguments))
        times.append(time.process_time() - start)
        return results[-1]

    return call


if __name__ == "__main__":
    main()
