"""Whether a command compiles the policies that it runs."""

import argparse
from collections.abc import Callable

import pytest

from aicon_baselines.agents import compiled, factory
from aicon_baselines.agents.registry import ModelPolicy
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.resolutions import PCGrad
from aicon_torch.export import codegen

OURS = factory("nav2d", "steepest")
OTHERS = {
    "bug2": factory("nav2d", "bug2"),  # nothing of the library
    "pcgrad": ModelPolicy("nav2d", "aicon", {"resolution": PCGrad()}),  # robot by robot
}


def asked(*words: str) -> bool | None:
    """What the words on the command line ask for."""
    parser = argparse.ArgumentParser()
    add_compile_option(parser)
    answer: bool | None = parser.parse_args(words).compile
    return answer


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Callable[[bool], None]:
    """Says whether there is a compiler."""
    return lambda has: monkeypatch.setattr(codegen, "has_compiler", lambda: has)


def test_where_a_compiler_is_there_what_can_be_is_compiled(
    machine: Callable[[bool], None], capsys: pytest.CaptureFixture[str]
) -> None:
    machine(True)
    policies = compiled_as_asked({"ours": OURS, **OTHERS}, asked())
    assert policies == {"ours": compiled(OURS), **OTHERS}
    said = capsys.readouterr().err
    assert "compiled" in said and "--no-compile" in said and said.count("\n") == 1


def test_without_a_compiler_the_readable_step_runs_and_one_line_names_the_package(
    machine: Callable[[bool], None], capsys: pytest.CaptureFixture[str]
) -> None:
    machine(False)
    assert compiled_as_asked({"ours": OURS}, asked()) == {"ours": OURS}
    said = capsys.readouterr().err
    assert "aicon-torch[compiler]" in said and said.count("\n") == 1


def test_who_asks_for_the_readable_step_gets_it(
    machine: Callable[[bool], None], capsys: pytest.CaptureFixture[str]
) -> None:
    machine(True)
    assert compiled_as_asked({"ours": OURS}, asked("--no-compile")) == {"ours": OURS}
    assert capsys.readouterr().err == ""


def test_what_has_no_step_to_compile_is_refused_where_it_is_asked_for() -> None:
    assert compiled_as_asked({"ours": OURS}, asked("--compile")) == {"ours": compiled(OURS)}
    with pytest.raises(ComparisonError, match="Bug2 is no policy of the library"):
        compiled_as_asked(OTHERS, asked("--compile"))


def test_nothing_is_said_where_nothing_can_be_compiled(
    machine: Callable[[bool], None], capsys: pytest.CaptureFixture[str]
) -> None:
    machine(True)
    assert compiled_as_asked(OTHERS, asked()) == OTHERS
    assert capsys.readouterr().err == ""
