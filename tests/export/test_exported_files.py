"""What is loaded is what the file holds now, and only if it is whole and unchanged."""

import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import MOVE, tracked_point, tracking_model
from _inputs.following import follower

from aicon_torch import (
    DirectDescent,
    Interconnection,
    Measurement,
    OptionError,
    Policy,
    Sensor,
    Sum,
    load_exported,
)
from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

FLIPS = 40
"""How many bits are flipped: as many anywhere as at the end, where the checksum is."""


SEEN = {"z": np.array([2.0, 1.0])}


def speed(path: Path) -> Any:
    action, _ = load_exported(path).predict(SEEN)
    return np.linalg.norm(action)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("good") / "policy.so"
    follower(limit=0.02).export(path)
    follower(limit=0.004).export(path.with_name("slow.so"))
    return path


def test_a_policy_exported_to_the_same_name_is_the_one_that_runs(
    good: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copy(good, tmp_path))
    before, fingerprint = speed(path), load_exported(path).metadata["fingerprint"]

    follower(limit=0.004).export(path)
    assert load_exported(path).metadata["fingerprint"] != fingerprint
    np.testing.assert_allclose(speed(path) / before, 0.2, rtol=1e-6)


def test_a_policy_that_is_loaded_stays_what_it_is(good: Path, tmp_path: Path) -> None:
    """Another one is copied over its file, in place, while it runs."""
    path, other = Path(shutil.copy(good, tmp_path)), good.with_name("slow.so")
    policy = load_exported(path)
    before, _ = policy.predict(SEEN)

    path.write_bytes(other.read_bytes())
    np.testing.assert_array_equal(policy.predict(SEEN)[0], before)
    path.write_bytes(b"")
    np.testing.assert_array_equal(policy.predict(SEEN)[0], before)


def test_many_policies_are_loaded_without_keeping_files_open(good: Path) -> None:
    resource = pytest.importorskip("resource", reason="no limits of open files")
    usual = resource.getrlimit(resource.RLIMIT_NOFILE)
    with good.open("rb") as file:  # the lowest number that is free
        few = file.fileno() + 20
    resource.setrlimit(resource.RLIMIT_NOFILE, (few, usual[1]))
    try:
        for _ in range(40):
            load_exported(good)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, usual)


def test_where_no_file_in_memory_may_run_a_private_copy_does(
    good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(os, "memfd_create")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = tmp_path / "policy.so"
    for source in (good, good.with_name("slow.so")):
        path.write_bytes(source.read_bytes())
        assert load_exported(path).metadata == load_exported(source).metadata
    assert [file.name for file in tmp_path.iterdir()] == ["policy.so"]


def test_a_flipped_bit_is_an_error_before_anything_runs(good: Path, tmp_path: Path) -> None:
    content, path = good.read_bytes(), tmp_path / "policy.so"
    bits = 8 * len(content)
    anywhere = np.random.default_rng(0).integers(bits, size=FLIPS)
    for place in (*anywhere, *range(bits - FLIPS, bits)):
        spoilt = bytearray(content)
        spoilt[place // 8] ^= 1 << (place % 8)
        path.write_bytes(bytes(spoilt))
        with pytest.raises(OptionError, match=r"policy\.so is (damaged|cut off)"):
            load_exported(path)


def test_a_file_that_lost_its_end_is_an_error(good: Path, tmp_path: Path) -> None:
    content, path = good.read_bytes(), tmp_path / "policy.so"
    for lost in (1, 10, 100, 1000, 10000):
        path.write_bytes(content[:-lost])
        with pytest.raises(OptionError, match="damaged|cut off"):
            load_exported(path)
        path.write_bytes(content[:-lost] + bytes(lost))
        with pytest.raises(OptionError, match="damaged|cut off"):
            load_exported(path)


@pytest.mark.parametrize("name", ["policy.so", "policy.c"])
def test_a_folder_that_is_not_there_is_named(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "missing"
    with pytest.raises(OptionError) as raised:
        follower().export(folder / name)
    assert f"no folder {str(folder)!r}" in str(raised.value)


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    path = tmp_path / "policy.so"
    path.mkdir()
    with pytest.raises(OptionError) as raised:
        follower().export(path)
    assert str(path) in str(raised.value) and "tmp" not in str(raised.value).replace(str(path), "")


def test_a_range_without_an_end_is_told_in_what_every_reader_of_json_takes(tmp_path: Path) -> None:
    sensors = {"z": Sensor(2, "m", range=(-1.0, np.inf))}
    model = tracking_model(MOVE, tracked_point(), sensors=sensors)
    Policy(model, Sum(), DirectDescent(1.0)).export(tmp_path / "policy.so")
    assert b"Infinity" not in (tmp_path / "policy.so").read_bytes()
    (sensor,) = load_exported(tmp_path / "policy.so").metadata["sensors"]
    assert sensor["range"] == [-1.0, None]


def test_a_step_that_would_run_out_of_stack_is_refused(tmp_path: Path) -> None:
    """As with a picture among the readings; it ended the process as it was loaded."""
    sensors = {"z": Sensor(300_000, "grey levels", optional=True)}
    seen = Interconnection(first_two, p=lambda p: torch.eye(2, dtype=p.dtype))
    point = tracked_point(correct=[Measurement(seen, 0.1, size=2)])
    policy = Policy(tracking_model(MOVE, point, sensors=sensors), Sum(), DirectDescent(1.0))
    with pytest.raises(OptionError, match="MiB of stack.*perception"):
        policy.export(tmp_path / "policy.so")


def first_two(p: torch.Tensor, z: torch.Tensor) -> torch.Tensor:
    return p - z[..., :2]
