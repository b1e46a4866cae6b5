"""Export a policy, and record an episode of it for the program in C++ to replay.

Example: python scripts/record_replay.py nav2d build/nav2d
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.bench import record_observations
from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.tasks import load, names
from aicon_torch import load_exported
from aicon_torch.control.exported_memory import ExportedMemory
from aicon_torch.control.layout import Layout
from aicon_torch.control.library import Library

CONDITIONS = {"panda_push": "true_pose"}  # elsewhere the task's first


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, the folder and how much to record."""
    parser.add_argument("task", choices=names())
    parser.add_argument("folder", type=Path, help="for policy.so, readings.bin and commands.bin")
    parser.add_argument("--condition", metavar="NAME", help="variant of the environment")
    parser.add_argument("--iterations", type=int, help="gradients in a step (default: as shipped)")
    parser.add_argument("--steps", type=int, default=200, help="of the episode (default: 200)")


def run(arguments: argparse.Namespace) -> None:
    """Write policy.so, readings.bin and commands.bin."""
    task, folder = arguments.task, arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    condition = arguments.condition or CONDITIONS.get(task, load(task).conditions[0])
    law = {} if arguments.iterations is None else {"law.iterations": arguments.iterations}
    policy: Any = factory(task, "aicon", **law)(condition)
    policy.export(folder / "policy.so", task=task, condition=condition)

    observations = record_observations(task, condition, arguments.steps)
    readings, commands = replayed(folder / "policy.so", policy.perception, observations)
    readings.tofile(folder / "readings.bin")
    commands.tofile(folder / "commands.bin")
    print(f"{len(readings)} steps of {task} in {folder}")


def replayed(path: Path, perception: Any, observations: list[Any]) -> tuple[Any, Any]:
    """The readings of an episode as the library takes them, and its commands, a row each."""
    library, exported = Library(path), load_exported(path)
    layout = Layout.from_json(library.metadata["memory"])
    memory, starts = library.blank(), np.ones((), dtype=np.uint8)
    readings, commands = [], []

    for observation in observations:
        if perception is not None:
            known = ExportedMemory(memory[np.newaxis], layout) if readings else None
            observation = perception(observation, known, None)
        readings.append(exported.flat_readings(observation).reshape(-1))

        memory, command = library.run(readings[-1], memory, starts)
        starts = np.zeros((), dtype=np.uint8)
        commands.append(command)
    return np.array(readings), np.array(commands)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
