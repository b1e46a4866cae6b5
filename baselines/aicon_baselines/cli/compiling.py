"""Whether a command compiles the policies that it runs: where it can, always, or never."""

import argparse
import sys
from collections.abc import Mapping

from aicon_baselines.agents.registry import can_be_compiled, compiled
from aicon_baselines.evaluation.predictor import Factory

_COMPILED = "The policies are compiled (--no-compile: the readable step, many times slower)."
_READABLE = (
    "There is no C compiler, so the policies take their readable step, many times slower; "
    "a compiler is a package: pip install 'aicon-torch[compiler]'"
)


def add_compile_option(parser: argparse._ActionsContainer) -> None:
    """Declare `--compile` and `--no-compile`."""
    parser.add_argument(
        "--compile",
        action=argparse.BooleanOptionalAction,
        help="compile the policies' steps (default: where there is a C compiler)",
    )


def compiled_as_asked(policies: Mapping[str, Factory], asked: bool | None) -> dict[str, Factory]:
    """Return what builds these policies, compiled or readable, and say on stderr which.

    Args:
        policies: What builds each policy, by name.
        asked: Whether they shall be compiled; None, if there is a compiler, for those that can be.

    Raises:
        ComparisonError: If one that cannot be compiled is asked to be.
    """
    if asked:
        return {name: compiled(build) for name, build in policies.items()}
    if asked is False or not any(map(can_be_compiled, policies.values())):
        return dict(policies)

    from aicon_torch.export import codegen

    if not codegen.has_compiler():
        print(_READABLE, file=sys.stderr)
        return dict(policies)

    print(_COMPILED, file=sys.stderr)
    return {
        name: compiled(build) if can_be_compiled(build) else build
        for name, build in policies.items()
    }
