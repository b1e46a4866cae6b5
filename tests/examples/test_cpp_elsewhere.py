"""Policies exported for other processors command what they command here, to the last bit."""

import shutil
import subprocess
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest

import record_replay
from aicon_baselines.cli.command_line import run_command
from aicon_torch.export.codegen.targets import this_machine

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(this_machine() != "x86_64-linux", reason="not on x86_64-linux"),
    pytest.mark.skipif(not find_spec("ziglang"), reason="no ziglang (pip install ziglang)"),
    pytest.mark.skipif(not find_spec("mujoco"), reason="no MuJoCo (pip install mujoco)"),
]

Replay = Callable[[str, Path, int], "subprocess.CompletedProcess[str]"]

ROOT = Path(__file__).parents[2]
STEPS = 300

# Emulator, compiler, and where the loader and the C library of that processor are.
EMULATED = {
    "aarch64-linux": ("qemu-aarch64-static", "aarch64-linux-gnu-g++", "/usr/aarch64-linux-gnu"),
    "armv7-linux": ("qemu-arm-static", "arm-linux-gnueabihf-g++", "/usr/arm-linux-gnueabihf"),
}
PACKAGES = "apt install qemu-user-static g++-aarch64-linux-gnu g++-arm-linux-gnueabihf"


@pytest.fixture(scope="module")
def replay_on(tmp_path_factory: pytest.TempPathFactory) -> Replay:
    """Replays so many steps of a folder on another processor."""
    programs = tmp_path_factory.mktemp("programs")

    def replay(target: str, folder: Path, steps: int) -> "subprocess.CompletedProcess[str]":
        emulator, compiler, libraries = EMULATED[target]
        if not shutil.which(emulator) or not shutil.which(compiler):
            pytest.skip(f"no emulator ({PACKAGES})")

        program, source = programs / target, ROOT / "examples/cpp/replay.cpp"
        if not program.exists():
            build = [compiler, "-std=c++17", "-O2", "-o", str(program), str(source), "-ldl"]
            subprocess.run(build, check=True)
        command = [emulator, "-L", libraries, str(program), str(folder), str(steps)]
        return subprocess.run(command, capture_output=True, text=True)

    return replay


@pytest.mark.usefixtures("optimized_elsewhere")
@pytest.mark.parametrize(
    ("target", "task", "condition"),
    [
        ("aarch64-linux", "nav2d", "range"),
        ("aarch64-linux", "arm_push", "true_pose"),
        ("armv7-linux", "pusht", "deterministic"),
    ],
)
def test_every_command_is_that_of_this_processor(
    target: str, task: str, condition: str, tmp_path: Path, replay_on: Replay
) -> None:
    what = [task, str(tmp_path), "--condition", condition, "--target", target]
    run_command(record_replay.COMMAND, [*what, "--steps", str(STEPS)])

    done = replay_on(target, tmp_path, STEPS)
    assert done.returncode == 0, done.stderr
    assert f"{STEPS} steps, every command as recorded" in done.stdout
    assert "allocations in the steps: 0" in done.stdout


@pytest.fixture(scope="module")
def of_this_processor(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy, and a step that it took."""
    folder = tmp_path_factory.mktemp("here")
    run_command(record_replay.COMMAND, ["nav2d", str(folder), "--steps", "1"])
    return folder


@pytest.mark.parametrize("target", EMULATED)
def test_a_policy_for_this_processor_is_refused_there(
    target: str, of_this_processor: Path, replay_on: Replay
) -> None:
    done = replay_on(target, of_this_processor, 1)
    assert done.returncode == 1
    assert "is a library for x86_64-linux, and this machine is" in done.stderr
