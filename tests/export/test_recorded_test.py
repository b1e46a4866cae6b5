"""The test that a library brings along: readings, and what comes of them but for rounding."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from _inputs import MOVE, match, tracked_point, tracking_model
from torch import Tensor

from aicon_torch import (
    Actuator,
    DirectDescent,
    Goal,
    Measurement,
    Policy,
    Sensor,
    load_exported,
)
from aicon_torch.export import exporting
from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


def policy_with(**costs: Callable[[Tensor], Tensor]) -> Policy:
    """A policy that brings a point ``p`` in four dimensions to where its goals are met."""
    place = tracked_point(
        initial=((1.0, 2.0, 3.0, 4.0), 1.0), correct=[Measurement(match, 0.1, size=4)]
    )
    model = tracking_model(
        MOVE,
        place,
        sensors={"z": Sensor(4, "m")},
        actuators={"a": Actuator(4, "m/s")},
        goals=[Goal(name, cost) for name, cost in costs.items()],
        dtype=torch.float32,
    )
    return Policy(model, law=DirectDescent(gain=1.0))


def settled(policy: Policy, folder: Path) -> list[str]:
    """For each number of what is recorded, whether it is compared: "1" or "0"."""
    policy.export(folder / "policy.c")
    found = re.search(r"settled\[.*\] = {(.*)}", (folder / "policy.c").read_text())
    assert found
    return found[1].split(", ")


def test_it_does_not_hang_on_rounding(tmp_path: Path) -> None:
    """Two goals whose gradients are orthogonal and equally long: which is first is not compared."""

    def first(p: Tensor) -> Tensor:
        return torch.linalg.vector_norm(p[..., :2] - 3.0, dim=-1)

    def second(p: Tensor) -> Tensor:
        return torch.linalg.vector_norm(p[..., 2:] + 2.0, dim=-1)

    policy = policy_with(first=first, second=second)
    assert settled(policy, tmp_path).count("0") == len(policy.model.goals)

    policy.export(tmp_path / "policy.so")
    loaded = load_exported(tmp_path / "policy.so")  # where the test is run
    assert loaded.metadata["goals"] == ["first", "second"]


def test_few_steps_are_taken_where_all_that_is_drawn_hangs_on_rounding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = []

    def counted(stages: Any, groups: Any) -> Any:
        taken.append(stages)
        return run(stages, groups)

    run = exporting.run
    monkeypatch.setattr(exporting, "run", counted)
    policy = policy_with(rough=lambda p: torch.cos(1e9 * p).sum(-1))
    assert settled(policy, tmp_path)[-4:] == ["0"] * 4  # the command
    assert len(taken) <= 6
