"""Time the arm's loop on one thread: physics and rendering, image, control step, real-time factor.

Example: python scripts/benchmark_arm_push.py --steps 3000 --out runs/benchmark

The loop runs at 100 Hz of simulated time, with an image every fifth step. The control step, reading
images left out, is timed in the loop, where physics and rendering have emptied the processor's
caches, and again on what was recorded. Times are those of the processor, since other programs may
run beside; the whole of `predict` and the real-time factor are given by the clock, too. With
--background images are read in a thread of their own, while the physics go on.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any, NamedTuple

from aicon_baselines.cli.command_line import Command, run_command

# isort: split

import numpy as np
import torch

from aicon_baselines.tasks.arm_push import TASK
from aicon_envs.arm_push import ArmPushEnv
from aicon_torch import Policy, make_policy


class Times(NamedTuple):
    """Seconds of each part in each step, and the age of the image that it saw."""

    environment: list[float]
    image: list[float]
    control: list[float]
    predict: list[float]
    clock: list[float]
    again: list[float]
    age: list[float]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much to measure."""
    parser.add_argument(
        "--steps", type=int, default=3000, help="control steps, of one episode or more"
    )
    parser.add_argument("--seed", type=int, default=1000, help="seed of the first episode")
    parser.add_argument("--uncompiled", action="store_true", help="do not compile the policy")
    parser.add_argument("--background", action="store_true", help="do not wait for images")
    parser.add_argument("--out", type=Path, required=True, help="folder for arm_push.json")


def run(arguments: argparse.Namespace) -> None:
    """Measure, print and save."""
    torch.set_num_threads(1)
    compiled, background = not arguments.uncompiled, arguments.background
    times = measure(arguments.steps, arguments.seed, compiled, background)
    results = summarize(times)

    for name, row in results["parts"].items():
        median, slow = row["median"], row["percentile_99"]
        print(f"{name:30} {median:7.3f} ms, 99th percentile {slow:7.3f} ms")
    factors = results["real_time_factor"]
    processor, clock = factors["processor"], factors["clock"]
    print(f"real-time factor: {processor:.2f} by processor time, {clock:.2f} by the clock")

    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "arm_push.json"
    path.write_text(json.dumps(results, indent=2) + "\n")


class TimedPerception:
    """A perception that is timed, and whose readings are kept."""

    def __init__(self, perception: Any) -> None:
        self._perception = perception
        self.seconds: list[float] = []
        self.readings: list[Any] = []

    def __call__(self, observation: Any, values: Any, starts: Any) -> Any:
        """Read the image, and note how long it took."""
        start = time.process_time()
        readings = self._perception(observation, values, starts)
        self.seconds.append(time.process_time() - start)
        self.readings.append(readings)
        return readings

    def forget(self) -> None:
        """Forget what was noted."""
        self.seconds.clear()
        self.readings.clear()


def measure(steps: int, seed: int, compiled: bool, background: bool) -> Times:
    """Run the loop, the first step, which compiles, left out of the times."""
    options = {**TASK.policy_options("camera"), "camera.background": background}
    policy: Any = make_policy("arm_push", **options)
    perception = TimedPerception(policy.perception)
    policy.perception = perception
    blind = Policy(policy.model, policy.resolution, policy.law)
    if compiled:
        policy, blind = policy.compile(), blind.compile()

    env = ArmPushEnv()
    observation, _ = env.reset(seed=seed)
    policy.predict(observation)
    perception.forget()

    times = Times([], perception.seconds, [], [], [], [], [])
    memory: Any = None
    begins: list[bool] = []

    for _ in range(steps):
        begins.append(memory is None)
        clock, start = time.perf_counter(), time.process_time()

        action, memory = policy.predict(observation, memory)
        decided = time.process_time()
        times.predict.append(time.perf_counter() - clock)
        times.control.append(decided - start - perception.seconds[-1])

        observation, _, terminated, _, _ = env.step(action)
        times.environment.append(time.process_time() - decided)
        times.clock.append(time.perf_counter() - clock)
        times.age.append(float(observation["image_age"][0]))

        if terminated:
            seed, memory = seed + 1, None
            observation, _ = env.reset(seed=seed)

    env.close()
    times.again.extend(measure_again(blind, perception.readings, begins))
    return times


def measure_again(policy: Any, readings: list[Any], begins: list[bool]) -> list[float]:
    """Seconds of the same control steps with nothing between them."""
    _, memory = policy.predict(readings[0])  # it compiles
    seconds = []
    for reading, is_first in zip(readings, begins, strict=True):
        before = None if is_first else memory
        start = time.process_time()
        _, memory = policy.predict(reading, before)
        seconds.append(time.process_time() - start)
    return seconds


def summarize(times: Times) -> dict[str, Any]:
    """Medians and 99th percentiles, ms, and simulated by spent time."""
    image, environment = np.array(times.image), np.array(times.environment)
    rendered = np.array(times.age) < TASK.time_step / 2
    # Between images there is nothing to read, which takes next to no time.
    reads_image = image > 10 * np.median(image)

    parts = {
        "predict, by the clock": np.array(times.predict),
        "control step": np.array(times.control),
        "control step on recorded data": np.array(times.again),
        "reading a new image": image[reads_image],
        "environment, without an image": environment[~rendered],
        "environment, with an image": environment[rendered],
    }
    percentiles = {}
    for name, seconds in parts.items():
        median, slow = 1e3 * np.percentile(seconds, (50, 99))
        percentiles[name] = {"median": float(median), "percentile_99": float(slow)}

    simulated = len(times.clock) * TASK.time_step
    processor = sum(times.control) + sum(times.image) + sum(times.environment)
    factors = {"processor": simulated / processor, "clock": simulated / sum(times.clock)}
    return {"parts": percentiles, "real_time_factor": factors}


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
