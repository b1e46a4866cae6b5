"""World models whose quantities have rows."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import (
    Actuator,
    Deterministic,
    Estimator,
    Goal,
    Interconnection,
    NullspaceProjection,
    Sensor,
    WorldModel,
)


def bent(a: Tensor) -> Tensor:
    """A nonlinear motion."""
    return a + 0.3 * torch.sin(2.0 * a)


class Row:
    """One row, nonlinear in both, and different for every seed."""

    def __init__(self, seed: int) -> None:
        self.scale = 1.0 + 0.3 * seed

    def __call__(self, x: Tensor, r: Tensor) -> Tensor:
        return torch.sin(self.scale * x * r) + 0.5 * (x - r) ** 2


def anchors(count: int) -> Callable[..., Tensor]:
    """Rows of points that the reading shifts."""
    points = normal(count, 2, seed=4)

    def placed(z: Tensor) -> Tensor:
        return points + 0.1 * z.unsqueeze(-2)

    return placed


def distances(*names: str, beside: str | None = None) -> Interconnection:
    """A cost on all rows of some quantities, each row and component at a weight of its own, and on
    a vector.
    """

    def cost(*values: Tensor) -> Tensor:
        total = torch.zeros((), dtype=torch.float64)
        for seed, rows in enumerate(values[: len(names)], start=7):
            weights = normal(*rows.shape[-2:], seed=seed)
            total = total + (rows * weights).sum((-1, -2)) ** 2

        return total + torch.cos(values[-1]).sum(-1) if beside else total

    return Interconnection(cost, inputs=[*names, beside] if beside else names)


def rows_of(of: str = "r", /, **families: int) -> list[Estimator]:
    """Rowed functions of x, each with its number of rows.

    Those with equally many read the same anchors, ``r3``.
    """
    estimators: list[Estimator] = [
        Deterministic(f"{of}{count}", anchors(count)) for count in dict.fromkeys(families.values())
    ]

    for seed, (name, count) in enumerate(families.items()):
        row = Interconnection(Row(seed), inputs=["x", f"{of}{count}"])
        estimators.append(Deterministic(name, row, each=[f"{of}{count}"]))

    return estimators


def rowed_model(*estimators: Estimator, goals: Sequence[Goal]) -> WorldModel:
    """A bent motion x, and what reads it."""
    return WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", bent), *estimators],
        goals=goals,
        dtype=torch.float64,
    )


def plain_sum(by_row: bool = True) -> NullspaceProjection:
    """Gradients are added as they are."""
    return NullspaceProjection(
        temperature=None, margin=0.0, projector="none", by_row=by_row, exploration=None
    )
