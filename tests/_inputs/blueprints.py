"""Blueprints of world models: what a random model is like, and the model itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import torch
from hypothesis import assume

from _inputs.random_numbers import normal
from _inputs.smooth import Anchors, Cost, Smooth
from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    Estimator,
    Goal,
    GraphError,
    KalmanFilter,
    Measurement,
    Sensor,
    WorldModel,
)

Shapes = dict[str, tuple[int, ...]]


@dataclass(frozen=True)
class Part:
    """What a random estimator is like."""

    kind: str
    name: str
    size: int
    reads: tuple[str, ...]
    feedback: tuple[str, ...] = ()
    seed: int = 0
    derivative: Any = "model"
    rows: int = 0
    each: tuple[str, ...] = ()

    @property
    def is_filter(self) -> bool:
        """Whether it owns a covariance."""
        return self.kind in ("ekf", "linear")

    @property
    def covariance(self) -> str:
        """The name of its covariance."""
        return f"P_{self.name}"


@dataclass(frozen=True)
class Blueprint:
    """What a random world model is like; the same blueprint builds the same model."""

    actuators: dict[str, int]
    parts: tuple[Part, ...]
    goals: dict[str, tuple[str, ...]]

    @property
    def shapes(self) -> Shapes:
        """The shape of every quantity."""
        shapes: Shapes = {name: (size,) for name, size in self.actuators.items()}

        for part in self.parts:
            shapes[part.name] = (part.rows, part.size) if part.rows else (part.size,)
            if part.is_filter:
                shapes[part.covariance] = (part.size, part.size)

        return shapes | {"z": (2,)}

    def build(self, goals: Sequence[str] | None = None) -> WorldModel:
        """The model in float64, with its goals in an order of choice."""
        costs = {
            name: Goal(name, Cost({read: self.shapes[read] for read in reads}, 3, 500 + i))
            for i, (name, reads) in enumerate(self.goals.items())
        }

        return WorldModel(
            sensors={"z": Sensor(2, "m")},
            actuators={name: Actuator(size, "m") for name, size in self.actuators.items()},
            estimators=[_estimator(part, self.shapes) for part in self.parts],
            goals=[costs[name] for name in goals or costs],
            dt=0.1,
            dtype=torch.float64,
        )


def built(blueprint: Blueprint) -> WorldModel:
    """The model, unless feedback has cut an actuator off: then the example is none."""
    try:
        return blueprint.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise


def _estimator(part: Part, shapes: Shapes) -> Estimator:
    reads = {name: shapes[name] for name in (*part.reads, *part.feedback)}

    match part.kind:
        case "function":
            return Deterministic(part.name, Smooth(reads, part.size, part.seed))
        case "anchors":
            return Deterministic(part.name, Anchors(part.rows, part.size, part.seed))
        case "rowed":
            return _of_each_row(part, reads)
        case "affine":
            return Deterministic(part.name, Affine(**_matrices(part, reads)))
        case "linear":
            return _linear_filter(part, reads)
        case _:
            return _extended_filter(part, reads)


def _of_each_row(part: Part, reads: Shapes) -> Deterministic:
    """A function that is written for one row."""
    row_shapes = {name: shape[-1:] if name in part.each else shape for name, shape in reads.items()}
    return Deterministic(part.name, Smooth(row_shapes, part.size, part.seed), each=part.each)


def _matrices(part: Part, reads: Shapes) -> dict[str, torch.Tensor]:
    return {
        name: 0.5 * normal(part.size, *shape, seed=part.seed + i)
        for i, (name, shape) in enumerate(reads.items())
    }


def _prior(part: Part) -> Any:
    return normal(part.size, seed=part.seed).tolist(), 0.5


def _linear_filter(part: Part, reads: Shapes) -> KalmanFilter:
    prediction = Affine(**{part.name: 0.9}, **_matrices(part, reads))
    reading = Affine(**{part.name: normal(2, part.size, seed=part.seed), "z": -1.0})

    return KalmanFilter(
        part.name,
        part.covariance,
        predict=prediction,
        noise=0.05,
        initial=_prior(part),
        correct=[Measurement(reading, 0.4, size=2)],
    )


def _extended_filter(part: Part, reads: Shapes) -> EKF:
    own = {part.name: (part.size,)}
    prediction = Smooth(own | reads, part.size, part.seed, around=part.name)
    residual = Smooth(own | {"z": (2,)}, 1, part.seed + 1)

    return EKF(
        part.name,
        part.covariance,
        predict=prediction,
        noise=0.05,
        initial=_prior(part),
        correct=[Measurement(residual, 0.3)],
        derivative=part.derivative,
    )
