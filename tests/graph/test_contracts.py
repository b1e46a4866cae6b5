"""What a user's own estimators, functions and numbers have to keep to is checked when built."""

from collections.abc import Callable
from typing import Any

import pytest
import torch
from _inputs.tracking import MOVE, match, tracked_point, tracking_model
from torch import Tensor
from torch.masked import masked_tensor

from aicon_torch import (
    Affine,
    Deterministic,
    Estimator,
    Goal,
    GraphError,
    Interconnection,
    KalmanFilter,
    Measurement,
    Sensor,
)
from aicon_torch.interconnections import Values


class Own(Estimator):
    """A point that is where it was read first, and moves from there."""

    outputs = ("p",)
    inputs = ("p", "x", "z")

    def initial(self, values: Values) -> dict[str, Tensor]:
        return {"p": values["z"]}

    def update(self, values: Values) -> dict[str, Tensor]:
        return {"p": values["p"] - values["x"]}

    def forward(self, values: Values, output: str) -> Tensor:
        return values["p"] - values["x"]


class WithoutPrior(Estimator):
    """It has no method initial."""

    outputs = ("p",)
    inputs = ("p", "x")
    update, forward = Own.update, Own.forward


class Nameless(Estimator):
    """It owns nothing."""

    inputs = ("x",)


def own(**methods: Any) -> Estimator:
    """The estimator with some of its methods, or of its names, changed."""
    kept = {name: value for name, value in methods.items() if not callable(value)}
    changed = {name: staticmethod(value) for name, value in methods.items() if callable(value)}
    return type("Own", (Own,), {**kept, **changed})()


BROKEN: dict[str, tuple[Callable[[], Any], str]] = {
    "an update without names": (
        lambda: own(update=lambda values: values["p"]),
        "update of Own 'p': expected a dictionary with the values of 'p', got Tensor",
    ),
    "an update of another name": (
        lambda: own(update=lambda values: {"pp": values["p"]}),
        "update of Own 'p': expected .* of 'p', got those of 'pp'",
    ),
    "a prior that lacks a value": (lambda: own(initial=lambda values: {}), "initial of Own 'p'"),
    "no prior": (WithoutPrior, "WithoutPrior of 'p' lacks one of the methods initial"),
    "names in what is foreseen": (
        lambda: own(forward=lambda values, output: {"p": values["p"]}),
        "forward of Own 'p': expected a tensor of shape .*, got dict",
    ),
    "fewer components in what is foreseen": (
        lambda: own(forward=lambda values, output: values["p"][..., :1]),
        r"forward of Own 'p': expected a tensor of shape \(7, 5, 2\), .* got \(7, 5, 1\)",
    ),
    "no outputs": (Nameless, "Nameless has outputs=None; expected a tuple of names"),
    "outputs that are a word": (lambda: own(outputs="p"), "Own has outputs='p'"),
    "inputs that are none": (lambda: own(inputs=None), "Own has inputs=None"),
}


@pytest.mark.parametrize(("make", "told"), BROKEN.values(), ids=BROKEN.keys())
def test_an_estimator_that_breaks_its_contract_is_named_with_the_method(
    make: Callable[[], Any], told: str
) -> None:
    assert tracking_model(MOVE, Own()).quantities["p"].shape == (2,)
    with pytest.raises(GraphError, match=told):
        tracking_model(MOVE, make())


# --- functions


def seen_if(is_possible: Any) -> Any:
    return tracking_model(sensors={"z": Sensor(2, "m", is_possible=is_possible)})


NO_FUNCTIONS: dict[str, tuple[Callable[[], Any], str]] = {
    "a goal": (lambda: Goal("near", None), "Goal 'near': expected a function .*, got None"),  # type: ignore[arg-type]
    "a relation": (lambda: Deterministic("x", 3), "Deterministic 'x': .*, got 3"),  # type: ignore[arg-type]
    "a prediction": (lambda: tracked_point(predict=3), "predict of 'p': .*, got 3"),
    "a residual": (lambda: Measurement(3, 0.1), "Measurement: .*, got 3"),  # type: ignore[arg-type]
    "an interconnection": (lambda: Interconnection(3), "Interconnection: .*, got 3"),  # type: ignore[arg-type]
    "a measurement": (lambda: tracked_point(correct=[match]), "correct of 'p': .*Measurement"),
    "a prior": (lambda: tracked_point(initial=3), r"initial of 'p': .*\(mean, variances\).* got 3"),
    "a prior of words": (lambda: tracked_point(initial=("ab", 1)), "initial of 'p': .*'ab'"),
    "what can be": (lambda: seen_if(3), "Sensor is_possible=3: expected a function"),
    "what can be, by component": (
        lambda: seen_if(lambda z: z > 0),
        r"is_possible of Sensor 'z': expected .* \(7, 5\), got torch.bool \(7, 5, 2\)",
    ),
    "what can be, in numbers": (
        lambda: seen_if(lambda z: z.sum(-1)),
        "is_possible of Sensor 'z': expected .*, got torch.float64",
    ),
    "what can be, masked": (
        lambda: seen_if(lambda z: masked_tensor(z[..., 0] > 0, z[..., 1] >= 0)),
        "is_possible of Sensor 'z': expected .*, got MaskedTensor",
    ),
    "what can be, misspelt": (lambda: seen_if(lambda z: z.summ()), "'z' cannot be evaluated.*summ"),
}


@pytest.mark.filterwarnings("ignore:The PyTorch API of MaskedTensors")
@pytest.mark.parametrize(("make", "told"), NO_FUNCTIONS.values(), ids=NO_FUNCTIONS.keys())
def test_what_is_no_function_is_named(make: Callable[[], Any], told: str) -> None:
    assert seen_if(lambda z: z[..., 0] > 0).sensors["z"].size == 2
    with pytest.raises(GraphError, match=told):
        make()


# --- sizes


def linear(shift: Any = -1.0, mean: tuple[float, ...] = (1.0, 0.0), size: int = 2) -> KalmanFilter:
    return KalmanFilter(
        "p",
        "P",
        predict=Affine(p=1.0, x=shift),
        noise=0.1,
        initial=(mean, 1.0),
        correct=[Measurement(Affine(p=1.0, z=-1.0), 0.1, size=size)],
    )


SMALL = Deterministic("x", lambda a, dt: a[..., :1] * dt)

MISSIZED: dict[str, tuple[Callable[[], Any], str]] = {
    "a measurement": (
        lambda: tracking_model(MOVE, linear(size=1)),
        "measurement 0 of 'p' gives 2 components, size=1",
    ),
    "a measurement of more": (
        lambda: tracking_model(MOVE, linear(size=3)),
        r"measurement 0 of 'p' gives 2 .* expected Measurement\(..., size=2\)",
    ),
    "a matrix": (
        lambda: tracking_model(MOVE, linear(shift=torch.eye(3))),
        r"predict of 'p'.*: the matrix of 'x' has shape \(3, 3\); expected \(m, 2\)",
    ),
    "a prior": (
        lambda: tracking_model(MOVE, linear(mean=(1.0, 0.0, 0.0))),
        "predict of 'p'.*: the term of 'p' has 3 components, that of 'x' 2",
    ),
    "one component for two": (
        lambda: tracking_model(SMALL, linear()),
        "predict of 'p'.*: the term of 'p' has 2 components, that of 'x' 1",
    ),
    "one component for two, without memory": (
        lambda: tracking_model(SMALL, Deterministic("p", Affine(z=1.0, x=1.0))),
        "Deterministic 'p': the term of 'z' has 2 components, that of 'x' 1",
    ),
    "a prior that is a function": (
        lambda: tracking_model(
            MOVE, tracked_point(initial=lambda z: (z, torch.eye(2).to(z)), size=3)
        ),
        "initial of 'p' gives 2 components; expected size=3",
    ),
}


@pytest.mark.parametrize(("make", "told"), MISSIZED.values(), ids=MISSIZED.keys())
def test_sizes_that_differ_are_told_with_the_argument(make: Callable[[], Any], told: str) -> None:
    assert tracking_model(MOVE, linear()).quantities["p"].shape == (2,)
    with pytest.raises(GraphError, match=told):
        make()


# --- rows of a batch


def mixed(p: Tensor) -> Tensor:
    return p - 0.5 * p.mean(0, keepdim=True)


def of_all(p: Tensor, z: Tensor) -> Tensor:
    return p - z.mean()


MIXING: dict[str, tuple[Callable[[], Any], str]] = {
    "a goal by a mean": (
        lambda: tracking_model(goals=[Goal("far", lambda p: mixed(p).norm(dim=-1))]),
        "'far' mixes",
    ),
    "a goal by the largest": (
        lambda: tracking_model(goals=[Goal("far", lambda p: (p / p.abs().max()).norm(dim=-1))]),
        "'far' mixes",
    ),
    "a relation": (
        lambda: tracking_model(Deterministic("x", lambda a: a + a.mean(0)), tracked_point()),
        "'x' mixes",
    ),
    "a prediction": (
        lambda: tracking_model(MOVE, tracked_point(predict=lambda p, x: mixed(p) - x)),
        "'p' foreseen mixes",
    ),
    "a residual": (
        lambda: tracking_model(
            MOVE,
            tracked_point(correct=[Measurement(of_all, 0.1, size=2)]),
        ),
        "'p' mixes",
    ),
}


@pytest.mark.parametrize(("make", "told"), MIXING.values(), ids=MIXING.keys())
def test_functions_that_mix_the_rows_of_a_batch_are_found(
    make: Callable[[], Any], told: str
) -> None:
    with pytest.raises(GraphError, match=told):
        make()


# --- modes of torch


def test_a_model_is_built_with_gradients_whatever_the_mode() -> None:
    expected = str(tracking_model().paths())
    with torch.no_grad():
        assert str(tracking_model().paths()) == expected
    with torch.inference_mode(), pytest.raises(GraphError, match=r"torch.inference_mode\(\)"):
        tracking_model()
