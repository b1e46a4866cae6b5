"""Compiled steps are kept by what is in them, and work where nothing can be kept."""

import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)
from aicon_torch.errors import OptionError
from aicon_torch.export.codegen import cached_library, compile_library, has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

SOURCE = '__attribute__((visibility("default"))) int answer(void) { return 42; }'


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache/aicon_torch"


def moved(z: Tensor, a: Tensor, dt: Tensor) -> Tensor:
    return z - a * dt


def distance(p: Tensor) -> Tensor:
    return torch.linalg.vector_norm(p, dim=-1)


def stepped(gain: float = 1.0, limit: float = 1.0, dtype: torch.dtype = torch.float64) -> Policy:
    """A point's policy, compiled by its first step."""
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit=limit)},
        estimators=[Deterministic("p", moved)],
        goals=[Goal("near", distance)],
        dt=0.1,
        dtype=dtype,
    )
    policy = Policy(model, Sum(), DirectDescent(gain=gain)).compile()
    policy.predict({"z": [1.0, 2.0]})
    return policy


def test_the_same_step_is_compiled_once_and_any_other_anew(cache: Path) -> None:
    stepped()
    stepped()
    assert len(list(cache.iterdir())) == 1

    stepped(gain=1.5)
    stepped(limit=2.0)
    stepped(dtype=torch.float32)
    assert len(list(cache.iterdir())) == 4


def test_a_library_is_whole_at_any_time(tmp_path: Path) -> None:
    """Many write it at once, and each finds it, for it is moved to its place when it is whole."""
    library = tmp_path / "answer.so"
    with ThreadPoolExecutor(8) as threads:
        list(threads.map(lambda _: compile_library(SOURCE, library), range(8)))
    assert [path.name for path in tmp_path.iterdir()] == ["answer.so"]


def test_where_nothing_can_be_kept_it_compiles_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    native = stepped()._native
    assert native is not None and native._steps[torch.float64] is not None

    assert cached_library(SOURCE)


@pytest.mark.parametrize("program", ["/bin/true", "not a program"], ids=["does nothing", "is none"])
def test_a_compiler_that_does_nothing_is_named_with_how_to_choose_another(
    program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken"
    if program.startswith("/"):
        broken.symlink_to(program)
    else:
        broken.write_bytes(program.encode())
        broken.chmod(0o700)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(OptionError, match="cannot be compiled.*CC names another"):
        compile_library(SOURCE, tmp_path / "answer.so")


def test_a_compiler_that_fails_without_a_word_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "false")
    with pytest.raises(OptionError, match="false.* failed: it ended with 1"):
        compile_library(SOURCE, tmp_path / "answer.so")


def test_a_folder_without_room_for_the_compiler_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    with pytest.raises(OptionError, match="missing.*TMPDIR"):
        compile_library(SOURCE, tmp_path / "answer.so")
