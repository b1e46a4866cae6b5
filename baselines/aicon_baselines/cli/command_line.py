"""The skeleton of every command line: parse, run, and tell in one sentence what went wrong.

Import this module before torch: it sets the number of threads, which is read when torch is loaded.
A command imports torch, matplotlib and what loads them where it runs, so that its help and mistakes
in its arguments take no seconds.

It is argparse, not tyro: a command has a dozen flat flags, most of which need a sentence of help
anyway, and no tree of dataclasses that tyro would spare us writing out.
"""

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import extra_of, missing_extra

# The policies and networks are small: more threads than one would only wait for each other. The
# processes that a comparison starts inherit it.
os.environ.setdefault("OMP_NUM_THREADS", "1")


@dataclass(frozen=True)
class Command:
    """A command line.

    Attributes:
        description: What it does, for its help; usually the docstring of its module.
        add_arguments: Declares its arguments.
        run: Does it, and prints the results.
        when_stopped: What is said to a user who stops it.
    """

    description: str | None
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], None]
    when_stopped: str = "stopped"


RESUMABLE = "stopped; the same command goes on from here"
"""What is said to a user who stops a command that saves what it has."""


def run_command(
    command: Command, arguments: Sequence[str] | None = None, program: str | None = None
) -> None:
    """Parse the arguments and run a command; what a user can mend ends it with a sentence.

    Args:
        command: The command.
        arguments: Its arguments; by default those of this process.
        program: What usage and errors call it; by default the name of the script.
    """
    parser = make_parser(command.description, program)
    command.add_arguments(parser)
    parsed = parser.parse_args(arguments)

    with errors_as_sentences(parser, command.when_stopped):
        command.run(parsed)


def make_parser(description: str | None, program: str | None = None) -> argparse.ArgumentParser:
    """Return a parser whose help has the description as it is written."""
    return argparse.ArgumentParser(
        prog=program,
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def add_option(
    parser: argparse._ActionsContainer, name: str, default: Any, text: str, **others: Any
) -> None:
    """Declare an option that has a default of its own type; a tuple takes several values.

    Args:
        parser: Where to declare it.
        name: Its name, such as "--seed".
        default: Its default.
        text: What it is, for its help, to which the default is added.
        **others: Further arguments of argparse, such as `type=at_least(1)`.
    """
    several = isinstance(default, tuple)
    first = default[0] if several else default
    options: dict[str, Any] = {
        "type": Path if isinstance(first, Path) else type(first),
        "nargs": "+" if several else None,
        "default": default,
        "help": f"{text} (default: {' '.join(map(str, default)) if several else default})",
    }
    parser.add_argument(name, **{**options, **others})


def at_least(least: int) -> Callable[[str], int]:
    """The type of an option that is a whole number from `least` on."""

    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"expected {least} or more, not {value}")
        return value

    return number


def add_policy_option(parser: argparse._ActionsContainer) -> None:
    """Declare `--policy`, which `parse_variant` of `aicon_baselines.agents.variants` reads."""
    parser.add_argument(
        "--policy",
        default="aicon",
        metavar="TEXT",
        help="policy, option=value,... or both, such as steepest,max_speed=0.3 (default: aicon)",
    )


def add_fields(
    parser: argparse._ActionsContainer, defaults: object, helps: Mapping[str, str]
) -> None:
    """Declare an option for some fields of a dataclass; `fields_of` gives them back.

    Args:
        parser: Where to declare them.
        defaults: An instance, whose values are the defaults.
        helps: What each field is, by its name.
    """
    for name, text in helps.items():
        option = f"--{name.replace('_', '-')}"
        add_option(parser, option, getattr(defaults, name), text, metavar=name.upper())


def fields_of(arguments: argparse.Namespace, helps: Mapping[str, str]) -> dict[str, Any]:
    """The values of the fields that were declared by `add_fields`."""
    values = {name: getattr(arguments, name) for name in helps}
    return {
        name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
    }


@contextmanager
def errors_as_sentences(
    parser: argparse.ArgumentParser, when_stopped: str = "stopped"
) -> Iterator[None]:
    """End the process with one sentence, not a traceback, where the user can mend the cause.

    That is exit status 2 for a wrong or missing thing, 130 where the user stopped it, and 141,
    without a word, where whoever read the output has closed it, as head does.
    """
    try:
        yield
        _flush_output()
    except ComparisonError as error:
        parser.error(str(error))
    except BrokenPipeError:
        parser.exit(141)
    except OSError as error:
        # The operating system refuses: no such file, no permission, no space.
        named = f"{error.filename}: " if error.filename else ""
        parser.error(f"{named}{error.strerror or error}")
    except ModuleNotFoundError as error:
        # Without a name it was raised by hand; with a cause it says already what to install.
        if error.name is None or error.__cause__:
            parser.error(str(error))
        if extra_of(error.name) is None:
            raise
        parser.error(str(missing_extra(error)))
    except KeyboardInterrupt:
        parser.exit(130, f"\n{when_stopped}\n")
    except _errors_of_users() as error:
        parser.error(str(error))


def _flush_output() -> None:
    """Write out what was printed; where that cannot be, what is left of it is dropped."""
    if sys.stdout is None:  # where it was closed from the beginning
        return
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise


def _errors_of_users() -> tuple[type[Exception], ...]:
    """What else users cause and can mend. Asked once there is an error: it loads torch."""
    from gymnasium.error import DependencyNotInstalled

    from aicon_torch.errors import OptionError

    return OptionError, DependencyNotInstalled
