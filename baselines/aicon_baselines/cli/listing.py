"""List the tasks with their policies and conditions, the environments and the extras."""

import argparse
import shutil
import textwrap
from collections.abc import Iterable

import gymnasium

import aicon_envs  # noqa: F401  # registers the environments
from aicon_baselines import agents, extras, tasks
from aicon_baselines.cli.command_line import Command
from aicon_baselines.evaluation.errors import ComparisonError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare nothing: there is nothing to choose."""


def run(arguments: argparse.Namespace) -> None:
    """Print what there is, and how to install what is missing."""
    for task in tasks.names():
        print(f"task {task}")
        _print_task(task)

    environments = [name for name in gymnasium.registry if name.startswith("aicon/")]
    print("environments of gymnasium, after `import aicon_envs`")
    _print_line("", environments)

    print("extras")
    for extra in extras.EXTRAS:
        missing = extras.missing_modules(extra)
        state = f"not installed: {extras.pip_command(extra)}" if missing else "installed"
        _print_line(extra, [state])


def _print_task(name: str) -> None:
    """Print the policies and conditions of a task, or what it needs."""
    try:
        task = tasks.load(name)
    except ComparisonError as error:
        _print_line("", [str(error)])
        return

    _print_line("presets", task.presets)
    _print_line("ablations", task.ablations)
    _print_line("opponents", agents.opponents(name))
    _print_line("conditions", task.patterns or task.conditions)


def _print_line(title: str, entries: Iterable[str]) -> None:
    """Print entries, if there are any, beside their title, as wide as the terminal."""
    entries = tuple(entries)
    if not entries:
        return

    width = shutil.get_terminal_size().columns
    text = ", ".join(entries)
    wrapped = textwrap.fill(
        text,
        width,
        initial_indent=f"  {title:12}",
        subsequent_indent=" " * 14,
        break_long_words=False,
    )
    print(wrapped)


COMMAND = Command(__doc__, add_arguments, run)
