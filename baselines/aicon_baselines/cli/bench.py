"""Time a control step of AICON in each task, compiled and uncompiled side by side.

Example: aicon bench --tasks nav2d pusht

What is timed is `predict`, on one thread, on the observations of an episode that was recorded
before; in arm_push the object's pose is told, so that no image is read. The two take turns, and
the times are those of the processor, so that a busy machine slows both alike.
"""

import argparse
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.command_line import Command, add_option
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.evaluation.timing import ratios, replay, spread, take_turns
from aicon_baselines.tasks import choices, load

_RECORDED_STEPS = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the tasks and how long to measure."""
    parser.add_argument(
        "--tasks",
        nargs="+",
        default=["nav2d", "pusht"],
        metavar="TASK",
        help=f"of {choices()} (default: the 2D ones)",
    )
    add_option(parser, "--rounds", 30, "rounds in which the two take turns")
    add_option(parser, "--steps", 100, "steps of each in a round")


def run(arguments: argparse.Namespace) -> None:
    """Measure the tasks and print a line for each."""
    import torch

    torch.set_num_threads(1)
    lines = []
    for task in arguments.tasks:
        times = time_steps(task, arguments.rounds, arguments.steps)
        uncompiled, compiled = times["uncompiled"], times["compiled"]
        faster = spread(ratios(uncompiled, compiled))
        lines.append([task, spread(uncompiled, 1e3), spread(compiled, 1e3), faster])

    print("one control step of one robot, one thread, ms: median (5 % to 95 % of the rounds)\n")
    print(to_markdown(["task", "uncompiled", "compiled", "times as fast"], lines))


def time_steps(task: str, rounds: int, steps: int) -> dict[str, list[float]]:
    """Return the seconds per step in each round, "uncompiled" and "compiled"."""
    condition = load(task).timed_condition or load(task).conditions[0]
    observations = observations_of_one(task, condition, _RECORDED_STEPS)

    policy: Any = make(task, "aicon", condition)
    to_compile: Any = make(task, "aicon", condition)
    programs = {
        "uncompiled": replay(policy, observations),
        "compiled": replay(to_compile.compile(), observations),
    }
    return take_turns(programs, rounds, steps, task)


def record_observations(
    task: str, condition: str, steps: int, seed: int = 1000, policy: Any = None
) -> list[Any]:
    """Return what a policy observes in the first steps of an episode, each a batch of one.

    Args:
        task: Name of the task.
        condition: Of the task.
        steps: Most steps; an episode may end before.
        seed: Seed of the episode.
        policy: By default AICON, compiled.
    """
    from aicon_baselines.evaluation.recording import Recording, record

    content = load(task)
    if policy is None:
        to_compile: Any = make(task, "aicon", condition)
        policy = to_compile.compile()

    env = content.make_env(1, condition, steps)
    reset = content.reset_arguments([content.episode(seed)])
    recording = record(Recording, policy, env, reset, steps, look=lambda seen: seen)
    return list(recording.pictures[:-1])


def observations_of_one(task: str, condition: str, steps: int) -> list[dict[str, NDArray[Any]]]:
    """The same as one robot alone observes it, without a batch."""
    batches = record_observations(task, condition, steps)
    return [{key: np.array(value[0]) for key, value in batch.items()} for batch in batches]


def record_episodes(
    task: str, condition: str, steps: int, policy: Any, seed: int = 1000
) -> list[tuple[Any, bool]]:
    """Return what a policy observes in episodes one after the other, and where one begins.

    Args:
        task: Name of the task.
        condition: Of the task.
        steps: Number of steps of all.
        policy: What acts.
        seed: Seed of the first episode; the next has the next.
    """
    found: list[tuple[Any, bool]] = []
    while len(found) < steps:
        observations = record_observations(task, condition, steps - len(found), seed, policy)
        found += [(observation, index == 0) for index, observation in enumerate(observations)]
        seed += 1
    return found


COMMAND = Command(__doc__, add_arguments, run)
