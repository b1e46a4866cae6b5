"""What is kept of compiled steps is taken only if it is ours, whole, and of this very source."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from aicon_torch.export.codegen import cached_library, compile_library, compiler, has_compiler
from aicon_torch.export.codegen.compiler import compiler_command
from aicon_torch.export.loading import open_library

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

ANSWER = '__attribute__((visibility("default"))) int answer(void) { return 42; }'
OTHER = ANSWER.replace("42", "43")

PLANTED = """\
#include <stdlib.h>
__attribute__((constructor)) static void run(void) { abort(); }
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache/aicon_torch"


@pytest.fixture
def kept(folder: Path) -> Path:
    """The file that was kept of a source."""
    cached_library(ANSWER)
    (file,) = folder.iterdir()
    return file


def test_it_is_compiled_once(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = kept.read_bytes()
    monkeypatch.setenv("CC", "false")
    assert cached_library(ANSWER) == library


def answer(library: bytes) -> int:
    """What is computed by a library, of which a compiler need not write the same bytes again."""
    return int(open_library(library)["answer"]())


def another_policy(file: Path) -> None:
    mode = file.stat().st_mode
    compile_library(OTHER, file)
    file.chmod(mode)


def truncated(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-1])


def flipped(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(bytes(content))


def without_checksum(file: Path) -> None:
    source = file.with_suffix(".c")
    source.write_text(PLANTED)
    command = [*compiler_command(), *compiler.FLAGS, "-shared", "-o", str(file), str(source)]
    subprocess.run(command, check=True)
    source.unlink()
    file.chmod(0o600)


@pytest.mark.parametrize(
    "spoil",
    [
        another_policy,
        truncated,
        flipped,
        without_checksum,
        lambda file: file.write_bytes(b""),
        lambda file: file.chmod(0o666),  # others may have written it
    ],
)
def test_what_is_not_whole_or_not_of_this_source_is_compiled_again(
    spoil: Callable[[Path], None], kept: Path
) -> None:
    spoil(kept)
    assert answer(cached_library(ANSWER)) == 42
    assert answer(kept.read_bytes()) == 42
    assert kept.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root")
def test_a_file_of_another_user_is_compiled_again(kept: Path) -> None:
    compile_library(OTHER, kept)
    os.chown(kept, 12345, -1)
    assert answer(cached_library(ANSWER)) == 42
    assert kept.stat().st_uid == os.geteuid()


def test_a_folder_of_another_user_is_not_used(
    kept: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    kept.unlink()
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    assert answer(cached_library(ANSWER)) == 42
    assert not kept.exists()
    assert "belongs to another user" in caplog.text and str(kept.parent) in caplog.text


def test_a_folder_that_others_may_write_becomes_private(kept: Path) -> None:
    kept.parent.chmod(0o777)
    cached_library(ANSWER)
    assert kept.parent.stat().st_mode & 0o777 == 0o700


def test_a_spoilt_file_costs_one_compilation_not_one_at_every_start(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who comes later finds what was mended, and needs no compiler."""
    kept.write_bytes(b"")
    cached_library(ANSWER)

    monkeypatch.setenv("CC", "false")
    assert answer(cached_library(ANSWER)) == 42
    assert answer(kept.read_bytes()) == 42
