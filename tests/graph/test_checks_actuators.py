"""What cannot work is refused at construction, each with its culprit: constraints and commands."""

from collections.abc import Callable
from typing import Any

import pytest
import torch
from _inputs import slower, tracking_model

from aicon_torch import Actuator, GraphError, WorldModel


def constrained(*constraints: Any) -> WorldModel:
    return tracking_model(actuators={"a": Actuator(2, "m/s", constraints=constraints)})


def measured(metric: Any) -> WorldModel:
    return tracking_model(actuators={"a": Actuator(2, "m/s", metric=metric)})


def dithered(dither: Any) -> WorldModel:
    return tracking_model(actuators={"a": Actuator(2, "m/s", dither=dither)})


def commanded(command: Any) -> WorldModel:
    return tracking_model(actuators={"a": Actuator(2, "m/s", command=command)})


CONSTRAINTS: dict[str, tuple[Callable[[], Any], str]] = {
    "a constraint of another size": (
        lambda: constrained(slower, lambda a: a[..., :1]),
        r"of actuator 'a' returns shape \(7, 5, 1\)",
    ),
    "a constraint that is no tensor": (
        lambda: constrained(lambda a: 0.0),
        "of actuator 'a' cannot be evaluated",
    ),
    "a constraint that sums over the batch": (
        lambda: constrained(lambda a: a.sum()),
        r"of actuator 'a' returns shape \(\)",
    ),
    "a constraint that cannot be evaluated": (
        lambda: constrained(lambda a, P: a + P[..., :1]),
        "of actuator 'a' cannot be evaluated",
    ),
    "a constraint that is no function": (
        lambda: constrained(0.5),
        "Actuator 'a': constraints",
    ),
    "a misspelt constraint": (
        lambda: constrained(slower, lambda aa: aa),
        r"of actuator 'a' reads 'aa', which is not in the graph. "
        r"Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
    "a constraint on a cost": (
        lambda: constrained(lambda a, near: a),
        r"'near', which is not in the graph",
    ),
    "a constraint that takes anything": (
        lambda: constrained(lambda *inputs: inputs[0]),
        r"'\*inputs' names no quantity",
    ),
}


METRICS: dict[str, tuple[Callable[[], Any], str]] = {
    "a metric that is no function": (
        lambda: measured(2.0),
        "Actuator 'a': constraints",
    ),
    "a metric that is no matrix": (
        lambda: measured(lambda a: a),
        r"returns shape \(7, 5, 2\); expected \(7, 5, 2, 2\)",
    ),
    "a misspelt metric": (
        lambda: measured(lambda aa: aa),
        "of actuator 'a' reads 'aa', which is not in the graph",
    ),
}


DITHERS: dict[str, tuple[Callable[[], Any], str]] = {
    "a dither that is no function": (
        lambda: dithered(0.5),
        "Actuator 'a': constraints",
    ),
    "a dither that is no matrix": (
        lambda: dithered(lambda a: a),
        r"returns shape \(7, 5, 2\); expected \(7, 5, 2, 1\)",
    ),
    "a dither of another size": (
        lambda: dithered(lambda a: a[..., :1, None]),
        r"returns shape \(7, 5, 1, 1\); expected \(7, 5, 2, 1\)",
    ),
}


COMMANDS: dict[str, tuple[Callable[[], Any], str]] = {
    "a command that is no function": (
        lambda: commanded(0.5),
        "Actuator 'a'",
    ),
    "a command that leaves no batch free": (
        lambda: commanded(lambda a: torch.zeros(2)),
        r"of actuator 'a' returns shape \(2,\)",
    ),
    "a misspelt command": (
        lambda: commanded(lambda a, x_rob: a + x_rob),
        r"of actuator 'a' reads 'x_rob', which is not in the graph. "
        r"Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
}


@pytest.mark.parametrize(("make", "culprit"), CONSTRAINTS.values(), ids=CONSTRAINTS.keys())
def test_constraints_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


@pytest.mark.parametrize(("make", "culprit"), COMMANDS.values(), ids=COMMANDS.keys())
def test_commands_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


@pytest.mark.parametrize(("make", "culprit"), METRICS.values(), ids=METRICS.keys())
def test_metrics_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


@pytest.mark.parametrize(("make", "culprit"), DITHERS.values(), ids=DITHERS.keys())
def test_dithers_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()
