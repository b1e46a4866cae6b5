"""Policies exported for other processors command what they command here, to the last bit."""

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from aicon_torch.export.codegen.targets import this_machine

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(this_machine() != "x86_64-linux", reason="not on x86_64-linux"),
    pytest.mark.skipif(not find_spec("ziglang"), reason="no ziglang (pip install ziglang)"),
    pytest.mark.skipif(not find_spec("mujoco"), reason="no MuJoCo (pip install mujoco)"),
]

ROOT = Path(__file__).parents[2]
RECORD = [sys.executable, str(ROOT / "scripts/record_replay.py")]
STEPS = 300

# Emulator, compiler, and where the loader and the C library of that processor are.
EMULATED = {
    "aarch64-linux": ("qemu-aarch64-static", "aarch64-linux-gnu-g++", "/usr/aarch64-linux-gnu"),
    "armv7-linux": ("qemu-arm-static", "arm-linux-gnueabihf-g++", "/usr/arm-linux-gnueabihf"),
}
PACKAGES = "apt install qemu-user-static g++-aarch64-linux-gnu g++-arm-linux-gnueabihf"


def replay_on(target: str, folder: Path, steps: int) -> "subprocess.CompletedProcess[str]":
    """Replay a folder on the other processor."""
    emulator, compiler, libraries = EMULATED[target]
    if not shutil.which(emulator) or not shutil.which(compiler):
        pytest.skip(f"no emulator ({PACKAGES})")

    program, source = folder / "replay", ROOT / "examples/cpp/replay.cpp"
    build = [compiler, "-std=c++17", "-O2", "-o", str(program), str(source), "-ldl"]
    subprocess.run(build, check=True)
    replay = [emulator, "-L", libraries, str(program), str(folder), str(steps)]
    return subprocess.run(replay, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("target", "task", "condition"),
    [
        ("aarch64-linux", "nav2d", "range"),
        ("aarch64-linux", "arm_push", "true_pose"),
        ("armv7-linux", "pusht", "deterministic"),
    ],
)
def test_every_command_is_that_of_this_processor(
    target: str, task: str, condition: str, tmp_path: Path
) -> None:
    what = [task, str(tmp_path), "--condition", condition, "--target", target]
    subprocess.run([*RECORD, *what, "--steps", str(STEPS)], check=True)

    done = replay_on(target, tmp_path, STEPS)
    assert done.returncode == 0, done.stderr
    assert f"{STEPS} steps, every command as recorded" in done.stdout
    assert "allocations in the steps: 0" in done.stdout


@pytest.mark.parametrize("target", EMULATED)
def test_a_policy_for_this_processor_is_refused_there(target: str, tmp_path: Path) -> None:
    subprocess.run([*RECORD, "nav2d", str(tmp_path), "--steps", "1"], check=True)
    done = replay_on(target, tmp_path, 1)
    assert done.returncode == 1
    assert "is a library for x86_64-linux, and this machine is" in done.stderr
