"""Export a policy, and record episodes of it for the program in C++ to replay.

Example: python scripts/record_replay.py nav2d build/nav2d

With --target it is recorded here, and the policy in the folder is the one for that machine.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.bench import record_episodes
from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.tasks import load, names
from aicon_torch import ExportedPolicy, load_exported
from aicon_torch.export.codegen.targets import TARGETS
from aicon_torch.export.exported_memory import ExportedMemory
from aicon_torch.export.layout import Layout
from aicon_torch.export.library import Library


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, the folder and how much to record."""
    parser.add_argument("task", choices=names())
    parser.add_argument("folder", type=Path, help="for policy.so and what was recorded")
    parser.add_argument("--condition", metavar="NAME", help="variant of the environment")
    parser.add_argument("--iterations", type=int, help="gradients in a step (default: as shipped)")
    parser.add_argument("--target", choices=TARGETS, help="replay on another machine")
    add_option(parser, "--steps", 200, "recorded steps", type=at_least(1))


def run(arguments: argparse.Namespace) -> None:
    """Write the policy, readings.bin, commands.bin and starts.bin."""
    task, folder = arguments.task, arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    condition = arguments.condition or load(task).timed_condition or load(task).conditions[0]
    law = {} if arguments.iterations is None else {"law.iterations": arguments.iterations}
    policy: Any = factory(task, "aicon", **law)(condition)
    policy.export(folder / "policy.so", task=task, condition=condition)

    exported = load_exported(folder / "policy.so", perception=policy.perception)
    episodes = record_episodes(task, condition, arguments.steps, exported)
    files = ("readings.bin", "commands.bin", "starts.bin")
    recorded = replayed(Library.read(folder / "policy.so"), exported, policy.perception, episodes)
    for name, rows in zip(files, recorded, strict=True):
        np.array(rows, dtype=np.float64).tofile(folder / name)
    if arguments.target is not None:
        (folder / "policy.so").unlink()
        library = (folder / "policy").with_suffix(TARGETS[arguments.target].suffix)
        policy.export(library, target=arguments.target, task=task, condition=condition)
    print(f"{arguments.steps} steps of {task} in {folder}")


def replayed(
    library: Library,
    exported: ExportedPolicy,
    perception: Any,
    observations: list[tuple[Any, bool]],
) -> tuple[list[Any], list[Any], list[bool]]:
    """Readings as the library takes them, its commands, and where an episode begins, a row each."""
    layout = Layout.from_json(library.metadata["memory"])
    memory = library.blank()
    readings, commands, starts = [], [], []

    for observation, begins in observations:
        if perception is not None:
            known = None if begins else ExportedMemory(memory[np.newaxis], layout)
            observation = perception(observation, known, None)
        readings.append(exported.flat_readings(observation).reshape(-1))

        memory, command = library.run(readings[-1], memory, np.array(begins, dtype=np.uint8))
        commands.append(command)
        starts.append(begins)
    return readings, commands, starts


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
