"""Constants of the arm from a log of twenty episodes, and what they are worth.

Example: python scripts/identify.py --condition bias --episodes 20 --seed 60000 --out runs/identify

First the shipped policy acts in episodes that are not reported. What of its constants they tell is
named before anything is trained, by the Fisher information; then the likelihood of the readings
finds them. Then the policy is compared with the one that has learned.
"""

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load

if TYPE_CHECKING:
    from torch import Tensor

    from aicon_torch import Policy

Log = tuple[dict[str, "Tensor"], dict[str, "Tensor"]]
"""What was read and what was done, each ``(episodes, steps, n)`` by name."""

SEEDS = range(1000, 1020)
"""Of the log."""

OFFSET = "x_pose.prior.offset"
FRICTION = "x_pose.predict.friction"
LAG = "v_joints.time_constant"

LEARNED: dict[str, dict[str, Any]] = {
    "true_pose": {FRICTION: 0.3, "x_pose.noise": None},
    "bias": {OFFSET: (0.001, 0.001, 0.01), FRICTION: 0.3, "x_pose.noise": None},
    "late": {LAG: 0.2, "x_joints.noise": None},
}
"""What learns in which condition, and where it starts; None where it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the condition, how long the log is, and what is compared."""
    parser.add_argument("--condition", choices=LEARNED, default="bias", help="default: bias")
    add_option(parser, "--steps", 150, "steps of each episode of the log")
    add_option(parser, "--episodes", 20, "episodes to compare; 0 compares none")
    add_option(parser, "--seed", 60_000, "the first of their seeds")
    parser.add_argument("--out", type=Path, required=True, help="folder of the comparison")


def run(arguments: argparse.Namespace) -> None:
    """Record, ask what can be known, learn it, and compare."""
    condition = arguments.condition
    log = record(condition, arguments.steps)
    learner = learn(shipped(condition), LEARNED[condition], log)
    if not arguments.episodes:
        return

    task = load("arm_push")
    config = configure(
        task, seed=arguments.seed, episodes=arguments.episodes, conditions=[condition]
    )
    policies: dict[str, Any] = {
        "aicon": lambda condition: shipped(condition).compile(),
        "learned": lambda condition: learner.compile(),
    }
    with RunFolder.open(arguments.out, config) as folder:
        compare(task, policies, folder)
        print(write_report(task, folder))


def shipped(condition: str) -> Any:
    """The shipped policy, which is told what it is told in a comparison."""
    return make("arm_push", "aicon", condition)


def record(condition: str, steps: int) -> Log:
    """A log of the shipped policy; what an episode reads after its end is missing."""
    import torch

    task = dataclasses.replace(load("arm_push"), horizon=steps)
    policy = shipped(condition).compile()
    seen: list[dict[str, Any]] = []
    done: list[Tensor] = []

    def keep(_: Any, step: Any) -> None:
        readings = {name: np.array(value, np.float64) for name, value in step.observation.items()}
        readings["object_pose"][~step.running] = np.nan
        seen.append(readings)
        done.append(step.memory["a"].clone())

    rollout(policy, task, condition, [task.episode(seed) for seed in SEEDS], SEEDS, on_step=keep)
    log = {name: torch.tensor(np.stack([each[name] for each in seen], 1)) for name in seen[0]}
    return log, {"a": torch.stack(done, 1)}


def learn(policy: "Policy", what: dict[str, Any], log: Log) -> "Policy":
    """The policy whose constants make the readings of a log likeliest."""
    import torch

    names = [name for name, start in what.items() if start is None]
    starts = {name: start for name, start in what.items() if start is not None}
    learner = policy.learn(*names, start=starts)
    learner.information(*log).check()

    optimizer: Any = torch.optim.LBFGS(  # torch leaves it untyped
        learner.parameters(), max_iter=20, max_eval=25, line_search_fn="strong_wolfe"
    )

    def surprise() -> Any:
        filtered = learner.filter(*log)
        loss: Any = -filtered.log_likelihood().sum() / filtered.readings().sum()
        optimizer.zero_grad()
        loss.backward()
        print(f"log-likelihood of a reading {-loss.item():.3f}", flush=True)
        return loss

    optimizer.step(surprise)
    numbers, shipped = learner.model.numbers, policy.model.numbers
    for name in what:
        print(f"{name}: {numbers[name].tolist()}, shipped {shipped[name].tolist()}")
    for name, deviation in learner.information(*log).deviations().items():
        print(f"least standard deviation of {name}, a share of its scale: {deviation:.2g}")
    return learner


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
