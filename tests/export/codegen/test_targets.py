"""Libraries for other machines: what is asked for, what comes out, and where it is refused."""

import platform
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from _inputs import observation_with

from aicon_torch import Foresight, OptionError, Policy, load_exported, make_policy
from aicon_torch.export.codegen import compiler
from aicon_torch.export.codegen.seal import read_seal
from aicon_torch.export.codegen.targets import TARGETS, this_machine

needs_zig = pytest.mark.skipif(not find_spec("ziglang"), reason="no ziglang (pip install ziglang)")

MAGIC = {"linux": b"\x7fELF", "macos": b"\xcf\xfa\xed\xfe", "windows": b"MZ", "web": b"\0asm"}
"""How a library begins on each system."""


@pytest.fixture(scope="module")
def policy() -> Policy:
    return make_policy("nav2d", law=Foresight(iterations=1))


@pytest.mark.parametrize(
    ("machine", "system", "largest", "expected"),
    [
        ("x86_64", "Linux", 2**63 - 1, "x86_64-linux"),
        ("aarch64", "Linux", 2**63 - 1, "aarch64-linux"),
        ("aarch64", "Linux", 2**31 - 1, "armv7-linux"),
        ("armv7l", "Linux", 2**31 - 1, "armv7-linux"),
        ("armv6l", "Linux", 2**31 - 1, "armv6l-linux"),
        ("riscv64", "Linux", 2**63 - 1, "riscv64-linux"),
        ("arm64", "Darwin", 2**63 - 1, "aarch64-macos"),
        ("AMD64", "Windows", 2**63 - 1, "x86_64-windows"),
    ],
)
def test_a_machine_is_called_by_its_processor_and_system(
    machine: str, system: str, largest: int, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platform, "machine", lambda: machine)
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(sys, "maxsize", largest)
    assert this_machine() == expected


def test_a_target_that_there_is_not_is_an_error_with_those_that_there_are(
    policy: Policy, tmp_path: Path
) -> None:
    with pytest.raises(OptionError, match="no target 'arm64'.*'aarch64-linux'.*'x86_64-windows'"):
        policy.export(tmp_path / "policy.so", target="arm64")


@pytest.mark.parametrize(
    ("target", "name", "suffix"),
    [
        ("aarch64-linux", "policy.dll", "so"),
        ("aarch64-macos", "policy.so", "dylib"),
        ("x86_64-windows", "policy.so", "dll"),
        ("x86_64-windows", "policy.c", "dll"),
        ("wasm32-web", "policy.so", "wasm"),
    ],
)
def test_a_name_ends_as_those_of_libraries_do_there(
    target: str, name: str, suffix: str, policy: Policy, tmp_path: Path
) -> None:
    with pytest.raises(OptionError, match=rf"{name}.*ends in \.{suffix}, as .* {target}"):
        policy.export(tmp_path / name, target=target)


def test_without_the_compiler_its_package_is_named(
    policy: Policy, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiler, "_has_zig", lambda: False)
    with pytest.raises(OptionError, match=r"armv7-linux.*ziglang.*aicon-torch\[compiler\]"):
        policy.export(tmp_path / "policy.so", target="armv7-linux")


@needs_zig
@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize("target", TARGETS)
def test_a_library_needs_no_other_and_says_which_machine_it_is_for(
    target: str, policy: Policy, tmp_path: Path
) -> None:
    path = (tmp_path / "policy").with_suffix(TARGETS[target].suffix)
    policy.export(path, target=target)
    content = path.read_bytes()
    assert content.startswith(MAGIC[target.split("-")[1]])
    assert b"libc.so" not in content and b"msvcrt" not in content and b"libm." not in content

    seal = read_seal(content, str(path))
    assert seal is not None and seal.target == target
    if target != this_machine():
        with pytest.raises(OptionError, match=f"is a library for {target}, and this machine"):
            load_exported(path)


@needs_zig
@pytest.mark.slow
@pytest.mark.skipif(this_machine() not in TARGETS, reason="no target is this machine")
def test_a_library_for_this_machine_computes_the_same(policy: Policy, tmp_path: Path) -> None:
    """Another compiler, and the same numbers to the last bit."""
    there = (tmp_path / "there").with_suffix(TARGETS[this_machine()].suffix)
    policy.export(tmp_path / "here.so")
    policy.export(there, target=this_machine())
    first, second = load_exported(tmp_path / "here.so"), load_exported(there)

    memory, same = None, None
    for distance in np.linspace(1.0, 0.5, 50):
        observation = observation_with(range=np.array([distance]))
        _, memory = first.predict(observation, memory)
        _, same = second.predict(observation, same)
        np.testing.assert_array_equal(memory.flat, same.flat)
