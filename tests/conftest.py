"""Settings of all tests: one thread, the same random examples in every run, and no display."""

import os
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import torch
from _chromium import launched
from filelock import FileLock
from gymnasium.error import DependencyNotInstalled
from hypothesis import HealthCheck, settings

from aicon_torch.export.codegen import compiler

with suppress(DependencyNotInstalled):
    import aicon_envs.arm_push  # noqa: F401  # chooses how to render before MuJoCo is imported

pytest.register_assert_rewrite("_asserts")  # what failed is shown there, too
torch.set_num_threads(1)

settings.register_profile(
    "default",
    deadline=None,
    derandomize=True,
    max_examples=25,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("quick", settings.get_profile("default"), max_examples=6)
settings.register_profile(
    "thorough", settings.get_profile("default"), derandomize=False, max_examples=500
)


SHIPPED_FLAGS = compiler.FLAGS


def pytest_configure(config: pytest.Config) -> None:
    """C is not optimized, and without the slow tests there are fewer examples.

    It computes the same bits, and is compiled in a fifth of the time. (zig checks for undefined
    behaviour where it does not optimize.) What zig builds of its own it keeps, also for tests that
    have a cache of their own.
    """
    os.environ.setdefault("ZIG_GLOBAL_CACHE_DIR", os.path.expanduser("~/.cache/zig"))
    compiler.FLAGS = ("-O0", "-fno-sanitize=undefined", *SHIPPED_FLAGS[1:])
    usual = "quick" if config.option.markexpr == "not slow" else "default"
    settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", usual))


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What is made once for all comes first, so that no process waits for another that makes it."""
    items.sort(key=lambda item: "site" not in getattr(item, "fixturenames", ()))


@pytest.fixture
def optimized(monkeypatch: pytest.MonkeyPatch) -> None:
    """C is optimized, as it is shipped."""
    monkeypatch.setattr(compiler, "FLAGS", SHIPPED_FLAGS)


@pytest.fixture
def optimized_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """C for another machine is optimized, as it is shipped; C for this one is not."""
    compiled = compiler.compiled

    def with_flags(source: str, target: str | None = None) -> bytes:
        with monkeypatch.context() as patch:
            patch.setattr(compiler, "FLAGS", compiler.FLAGS if target is None else SHIPPED_FLAGS)
            return compiled(source, target)

    monkeypatch.setattr(compiler, "compiled", with_flags)


@pytest.fixture(scope="session")
def made_once(
    worker_id: str, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str, Callable[[Path], Any]], Path]:
    """Makes a folder by its name, once for all processes that test side by side."""
    own = tmp_path_factory.getbasetemp()
    shared = own if worker_id == "master" else own.parent

    def folder_of(name: str, make: Callable[[Path], Any]) -> Path:
        folder = shared / name
        with FileLock(shared / f"{name}.lock"):
            if not folder.exists():
                make(folder)
        return folder

    return folder_of


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium, driven by playwright, of which a process can hold one only."""
    yield from launched()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """One line for all that this machine lacks."""
    skipped = terminalreporter.stats.get("skipped", [])
    if skipped:
        reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped)
        counts = "; ".join(f"{reason}: {count}" for reason, count in reasons.most_common())
        terminalreporter.write_line(f"{len(skipped)} skipped: {counts}")
