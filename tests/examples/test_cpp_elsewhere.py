"""Policies exported for other processors command what they command here, to the last bit."""

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from aicon_baselines.agents.registry import factory
from aicon_torch.export.codegen.targets import this_machine

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(this_machine() != "x86_64-linux", reason="not on x86_64-linux"),
    pytest.mark.skipif(not find_spec("ziglang"), reason="no ziglang (pip install ziglang)"),
    pytest.mark.skipif(not find_spec("mujoco"), reason="no MuJoCo (pip install mujoco)"),
]

ROOT = Path(__file__).parents[2]
RECORD = [sys.executable, str(ROOT / "scripts/record_replay.py")]
STEPS = 1000
CONDITIONS = {
    "nav2d": "range",
    "pusht": "deterministic",
    "arm_push": "true_pose",
    "reach": "panda_pose_home",
}
"""The tasks, and what is recorded of each."""

# Emulator, where the loader and the C library of that processor are, and what ziglang calls it.
EMULATED = {
    "aarch64-linux": (
        "qemu-aarch64-static",
        Path("/usr/aarch64-linux-gnu"),
        "aarch64-linux-gnu.2.31",
    ),
    "armv7-linux": (
        "qemu-arm-static",
        Path("/usr/arm-linux-gnueabihf"),
        "arm-linux-gnueabihf.2.31",
    ),
}
PACKAGES = "apt install qemu-user-static libc6-arm64-cross libc6-armhf-cross"


@pytest.fixture(scope="module", params=EMULATED)
def target(request: pytest.FixtureRequest) -> str:
    emulator, libraries, _ = EMULATED[request.param]
    if not shutil.which(emulator) or not libraries.is_dir():
        pytest.skip(f"no emulator ({PACKAGES})")
    return str(request.param)


@pytest.fixture(scope="module")
def replay(target: str, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The command that replays a folder on the other processor."""
    emulator, libraries, triple = EMULATED[target]
    program = tmp_path_factory.mktemp("replay") / "replay"
    build = [sys.executable, "-m", "ziglang", "c++", "-target", triple, "-std=c++17", "-O2"]
    source = ROOT / "examples/cpp/replay.cpp"
    subprocess.run([*build, "-o", str(program), str(source)], check=True)
    return [emulator, "-L", str(libraries), str(program)]


@pytest.fixture(scope="module", params=CONDITIONS)
def recorded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a task's policy read and commanded here, in a folder of the task's name."""
    folder = tmp_path_factory.mktemp("recorded") / str(request.param)
    what = [folder.name, str(folder), "--condition", CONDITIONS[folder.name]]
    subprocess.run([*RECORD, *what, "--steps", str(STEPS)], check=True)
    return folder


def test_every_command_is_that_of_this_processor(
    recorded: Path, target: str, replay: list[str]
) -> None:
    policy: Any = factory(recorded.name, "aicon")(CONDITIONS[recorded.name])
    policy.export(recorded / "policy.so", target=target)

    done = subprocess.run([*replay, str(recorded), str(STEPS)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"{STEPS} steps, every command as recorded" in done.stdout
    assert "allocations in the steps: 0" in done.stdout


def test_a_policy_for_this_processor_is_refused_there(replay: list[str], tmp_path: Path) -> None:
    subprocess.run([*RECORD, "nav2d", str(tmp_path), "--steps", "1"], check=True)
    done = subprocess.run([*replay, str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == 1
    assert "is a library for x86_64-linux, and this machine is" in done.stderr
