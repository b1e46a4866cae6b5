"""Commands in the documents are those of today: programs, flags, policies, conditions, options."""

import argparse
import importlib

import pytest
from _documents import ROOT, ShellCommand, shell_commands

from aicon_baselines import tasks
from aicon_baselines.agents import registry
from aicon_baselines.agents.variants import parse_variant
from aicon_baselines.cli.command_line import Command
from aicon_baselines.evaluation.task import Task
from aicon_torch.models import MODELS, replace_options

COMMANDS = shell_commands()
TRAINED = {"sb3", "diffusion"}

CLI = {
    "aicon list": "aicon_baselines.cli.listing",
    "aicon run": "aicon_baselines.cli.run",
    "aicon watch": "aicon_baselines.cli.watch",
    "aicon compare": "aicon_baselines.cli.compare",
    "aicon diagnose": "aicon_baselines.cli.diagnose",
    "aicon figures": "aicon_baselines.cli.figures",
    "aicon bench": "aicon_baselines.cli.bench",
    "aicon export": "aicon_baselines.cli.export",
}


def test_there_are_commands() -> None:
    assert len(COMMANDS) > 20


@pytest.mark.parametrize("command", COMMANDS, ids=str)
def test_a_command_is_understood(command: ShellCommand) -> None:
    arguments = parse(command)

    if "policies" in arguments or "variants" in arguments:
        check_names(arguments, (ROOT / command.block.document).read_text())


def parse(command: ShellCommand) -> argparse.Namespace:
    """The arguments of a command, as its program understands them."""
    program = load_program(command.program)
    parser = argparse.ArgumentParser(exit_on_error=False)
    program.add_arguments(parser)
    return parser.parse_args(command.arguments)


def load_program(name: str) -> Command:
    """The program of this name."""
    if name in CLI:
        module = importlib.import_module(CLI[name])
    else:
        assert (ROOT / name).exists(), f"{name} is not there"
        module = importlib.import_module((ROOT / name).stem)

    program = module.COMMAND
    assert isinstance(program, Command)
    return program


def check_names(arguments: argparse.Namespace, page: str) -> None:
    """Policies, variants and conditions are there in the task of a command, or on its page."""
    task = getattr(arguments, "task", "arm_push")
    if ":" in task:  # one that a page makes: test_tutorials.py
        return
    for policy in getattr(arguments, "policies", ()):
        module, _, function = policy.partition(":")
        is_own = f"# {module}.py\n" in page and f"\ndef {function}(" in page
        assert is_own or policy in {*registry.names(task), *TRAINED}

    for condition in getattr(arguments, "conditions", None) or ():
        assert known_task(task).has_condition(condition)

    package = importlib.import_module(MODELS[task])
    for text in getattr(arguments, "variants", ()):
        name, options = parse_variant(text)
        assert name in registry.names(task)
        replace_options(package.Options(), options)


def known_task(name: str) -> Task:
    """A task whose environment is installed."""
    if name == "arm_push":
        pytest.importorskip("mujoco")
    return tasks.load(name)
