"""Measurements are read once, in their order, whatever they come in."""

import math
from collections.abc import Callable
from typing import Any

import pytest
from _inputs.tracking import match, tracked_point

from aicon_torch import EKF, Affine, Deterministic, GraphError, KalmanFilter, LateEKF, Measurement
from aicon_torch.estimation.late import ekf_with_delay

PARTS: dict[str, Any] = {
    "predict": Affine(p=1.0, x=-1.0),
    "noise": 0.1,
    "initial": ((1.0, 0.0), 1.0),
}
LATE: dict[str, Any] = {**PARTS, "sensor": "z", "moved_by": {"x": 2}}


def of_z() -> Measurement:
    return Measurement(Affine(p=1.0, z=-1.0), 0.1, size=2)


KINDS: dict[str, Callable[[Any], EKF]] = {
    "EKF": lambda given: EKF("p", "P", correct=given, **PARTS),
    "KalmanFilter": lambda given: KalmanFilter("p", "P", correct=given, **PARTS),
    "LateEKF": lambda given: LateEKF("p", "P", correct=given, steps=2, **LATE),
    "prompt": lambda given: LateEKF("p", "P", prompt=given, steps=2, **LATE),
    "no delay": lambda given: ekf_with_delay("p", "P", correct=given, delay=0, **LATE),
}


@pytest.mark.parametrize("build", KINDS.values(), ids=KINDS)
def test_a_generator_of_measurements_counts_as_a_list_does(build: Callable[[Any], EKF]) -> None:
    from_list, from_generator = build([of_z()]), build(each for each in [of_z()])
    assert from_generator.inputs == from_list.inputs
    assert "z" in from_generator.inputs
    modules = [type(module) for module in from_generator.modules()]
    assert modules == [type(module) for module in from_list.modules()]


@pytest.mark.parametrize("build", KINDS.values(), ids=KINDS)
def test_a_set_has_no_order(build: Callable[[Any], EKF]) -> None:
    with pytest.raises(GraphError, match="expected a list or a tuple"):
        build({of_z()})


def test_names_have_an_order_too() -> None:
    with pytest.raises(GraphError, match="each of 'y': expected a list or a tuple"):
        Deterministic("y", lambda x: x, each={"x"})
    with pytest.raises(GraphError, match="sensor of 'p': expected a list or a tuple"):
        LateEKF("p", "P", steps=2, **{**LATE, "sensor": {"z", "y"}})


@pytest.mark.parametrize("initial", [((math.nan, 0.0), 1.0), ((math.inf, 0.0), 1.0), (("a",), 1.0)])
def test_a_prior_is_of_finite_numbers(initial: Any) -> None:
    """With others the robot would rest for ever, and nobody knew why."""
    with pytest.raises(GraphError, match=r"initial of 'p': expected \(mean, variances\)"):
        tracked_point(initial=initial)


def test_what_moves_a_late_estimate_has_a_size() -> None:
    with pytest.raises(GraphError, match="moved_by of 'p': expected sizes by name"):
        LateEKF("p", "P", steps=2, **{**LATE, "moved_by": ["x"]})


@pytest.mark.parametrize("gate", [-1.0, 0.0, "a"])
def test_a_gate_lets_something_through(gate: Any) -> None:
    with pytest.raises(GraphError, match=r"gate=.*: expected a number > 0"):
        Measurement(match, 0.1, gate=gate, size=2)
