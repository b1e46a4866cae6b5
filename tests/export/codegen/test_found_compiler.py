"""Which C compiler is taken, and what is said where there is none."""

import shutil
from pathlib import Path

import pytest

from aicon_torch import OptionError
from aicon_torch.export.codegen import compile_library, compiler, has_compiler

SOURCE = '__attribute__((visibility("default"))) int answer(void) { return 42; }'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder where programs are found."""
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    return tmp_path


def put_program(folder: Path, name: str) -> None:
    (folder / name).symlink_to("/bin/true")


def test_what_cc_names_comes_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("cc", "mine"):
        put_program(folder, name)
    monkeypatch.setenv("CC", "mine --quick")
    assert compiler.compiler_command() == ("mine", "--quick")


def test_then_what_the_system_has(folder: Path) -> None:
    for name in ("clang", "gcc", "cc"):
        put_program(folder, name)
        assert compiler.compiler_command() == (name,)


def test_then_the_package(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_has_zig", lambda: True)
    assert has_compiler()
    assert compiler.compiler_command() == compiler.ZIG


def test_where_there_is_none_the_packages_are_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiler, "_has_zig", lambda: False)
    assert not has_compiler()
    with pytest.raises(OptionError, match=r"aicon-torch\[compiler\].*apt install gcc"):
        compile_library(SOURCE, folder / "answer.so")


@pytest.mark.parametrize(("named", "words"), [("", "CC is empty"), ("'gcc", "no command")])
def test_cc_that_is_no_command_is_an_error_by_name(
    named: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", named)
    with pytest.raises(OptionError, match=words):
        has_compiler()
    with pytest.raises(OptionError, match=words):
        compile_library(SOURCE, tmp_path / "answer.so")


def test_cc_that_is_not_there_is_an_error_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert shutil.which("no-such-compiler") is None
    monkeypatch.setenv("CC", "no-such-compiler")
    assert not has_compiler()
    with pytest.raises(OptionError, match="no-such-compiler.*CC"):
        compile_library(SOURCE, tmp_path / "answer.so")
