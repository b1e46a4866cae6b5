"""How an arm in clutter is timed, and the share of problems that are solved is drawn."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch
from matplotlib.figure import Figure

import clutter
import reach_rehearsed
import reach_study


class Solved(NamedTuple):
    policy: str
    time: float
    is_solved: bool


def test_a_policy_that_solves_nothing_is_drawn_at_zero() -> None:
    rows = [Solved("one", 4.0, True), Solved("one", np.nan, False), Solved("other", np.nan, False)]
    axes = Figure().subplots()

    clutter.draw_shares(axes, rows, horizon=10.0)
    curves = [line.get_xydata() for line in axes.get_lines()]
    np.testing.assert_array_equal(curves[0], [(0, 0), (4, 50), (10, 50)])
    np.testing.assert_array_equal(curves[1], [(0, 0), (10, 0)])


class Counting:
    """A policy that counts its steps."""

    steps = 0

    def compile(self) -> "Counting":
        return self

    def predict(self, seen: Any, memory: Any = None) -> tuple[Any, Any]:
        self.steps += 1
        return seen["q"], {}


def test_a_policy_is_compiled_before_its_first_step_is_timed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A compiled policy compiles in its first step."""
    robot: Any = None
    policy = Counting()
    monkeypatch.setattr(clutter, "policy_of", lambda *_: policy)
    monkeypatch.setattr(clutter, "sees", lambda *_: {"q": np.zeros(3)})
    problem = clutter.Problem("panda", "cage", 1, np.zeros(3), np.zeros(3), ())
    assert clutter.agent("aicon", robot, problem).steps > 0

    policy.steps, counted = 0, []
    places = torch.zeros(1, 3)
    found = reach_study.Targets(robot, robot, {"q": torch.zeros(1, 3)}, places)
    monkeypatch.setattr(reach_rehearsed, "targets", lambda *_: found)
    monkeypatch.setattr(reach_rehearsed, "make_policy", lambda *_, **__: policy)
    monkeypatch.setattr(reach_rehearsed, "rehearsed", lambda policy: policy)

    def follow(agent: Counting, *_: Any) -> tuple[float, float, int]:
        counted.append(agent.steps)
        return 1.0, 0.0, 0

    monkeypatch.setattr(reach_rehearsed, "follow", follow)
    table = tmp_path / "table.csv"
    reach_rehearsed.rows_of_condition("ur5_pose_home", range(1000, 1001), table)
    assert min(counted) > 0
