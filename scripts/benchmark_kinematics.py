"""Time a step of reaching with both kinematics: ours in closed form, and pytorch-kinematics itself.

Example: python scripts/benchmark_kinematics.py --robots ur5 panda

Both policies are compiled, with an empty cache, and take turns on the same recorded observations of
one robot that reaches for a pose. Times are those of the processor, compilers included.
"""

import argparse
import os
import tempfile
import time
from typing import Any, get_args

import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

from aicon_baselines.cli.bench import observations_of_one
from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.tasks import load
from aicon_torch import Policy, make_policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain, Kinematics

ROBOTS = ("ur5", "panda", "xarm7")
RECORDED = 100

Observations = list[dict[str, NDArray[Any]]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the robots and how long to measure."""
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=ROBOTS, help="default: all")
    parser.add_argument("--rounds", type=int, default=100, help="turns (default: 100)")


def run(arguments: argparse.Namespace) -> None:
    """Measure one robot after the other, where nothing was compiled before."""
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as cache:
        os.environ.update(XDG_CACHE_HOME=cache, TORCHINDUCTOR_CACHE_DIR=cache)
        for robot in arguments.robots:
            measure(robot, arguments.rounds)


def measure(robot: str, rounds: int) -> None:
    """Print the first step and the median time of the others, of both."""
    condition = f"{robot}_pose_home"
    policies = build_both(load("reach").policy_options(condition))
    observations = observations_of_one("reach", condition, RECORDED)

    for name, policy in policies.items():
        print(
            f"{robot}, {name}: first step {first_step(policy, observations[0]):.1f} s", flush=True
        )

    times: dict[str, list[float]] = {name: [] for name in policies}
    for _ in tqdm(range(rounds), desc=robot, disable=None):
        for name, policy in policies.items():
            times[name].append(turn(policy, observations))

    ours, theirs = (np.array(taken) for taken in times.values())
    low, middle, high = np.percentile(theirs / ours, (5, 50, 95))
    for name, taken in times.items():
        print(f"{robot}, {name}: {1e6 * np.median(taken):.1f} us a step")
    print(f"{robot}: {middle:.2f} times as long ({low:.2f} to {high:.2f})", flush=True)


def build_both(options: dict[str, Any]) -> dict[str, Policy]:
    """The policy with each of the kinematics; the one in closed form comes first."""
    source, tip, srdf = options.pop("robot"), options.pop("tip"), options.pop("srdf")
    shape = Capsules.from_urdf(source, srdf, tip)

    policies: dict[str, Policy] = {}
    for kinematics in get_args(Kinematics):
        chain = Chain.from_urdf(source, tip, kinematics=kinematics)
        policies[kinematics] = make_policy("reach", robot=Robot(chain, shape), **options).compile()
    return policies


def first_step(policy: Policy, observation: dict[str, NDArray[Any]]) -> float:
    """Seconds of the processor, those of compilers included."""
    start = processor_time()
    policy.predict(observation)
    return processor_time() - start


def processor_time() -> float:
    """Of this process and of those that it has waited for, s."""
    return sum(os.times()[:4])


def turn(policy: Policy, observations: Observations) -> float:
    """Seconds of the processor for a step, on average over the observations."""
    memory = None
    start = time.process_time()
    for observation in observations:
        _, memory = policy.predict(observation, memory)
    return (time.process_time() - start) / len(observations)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
