"""The beacon's filter by hand, and derivatives of filters."""

from collections.abc import Callable
from typing import NamedTuple

import torch
from _inputs import bearing, drive
from torch import Tensor

from aicon_torch import EKF, Estimator

Values = dict[str, Tensor]


def update(node: Estimator, values: Values) -> Values:
    """As the graph runs it: filtering is not differentiated."""
    with torch.no_grad():
        return node.update(values)


class BeaconStep(NamedTuple):
    """One step of the beacon's filter."""

    predicted_mean: Tensor
    predicted_covariance: Tensor
    slope: Tensor
    spread: Tensor
    gain: Tensor
    mean: Tensor
    covariance: Tensor


def beacon_step(values: Values) -> BeaconStep:
    """The textbook's formulas with F = I and H = (−y, x)/‖x‖² written out."""
    mean = drive(values["x"], values["a"])
    covariance = values["P"] + 0.01 * torch.eye(2, dtype=torch.float64)

    x, y = mean.unbind(-1)
    slope = (torch.stack((-y, x), dim=-1) / (mean**2).sum(-1, keepdim=True)).unsqueeze(-2)
    spread = slope @ covariance @ slope.mT + 0.04

    gain = covariance @ slope.mT / spread
    corrected = mean - (gain * bearing(mean, values["z"]).unsqueeze(-1)).squeeze(-1)
    return BeaconStep(
        mean, covariance, slope, spread, gain, corrected, covariance - gain @ slope @ covariance
    )


def slopes(node: EKF, output: str, values: Values) -> Tensor:
    """∂output/∂a as the graph differentiates it, the full Jacobian."""

    def ahead(a: Tensor) -> Tensor:
        out: Tensor = node({**values, "a": a}, output)
        return out

    jacobian: Tensor = torch.autograd.functional.jacobian(ahead, values["a"])
    return jacobian


def central_differences(
    function: Callable[[Values], Tensor], values: Values, step: float = 1e-6
) -> Tensor:
    """∂function/∂a by central differences."""
    columns: list[Tensor] = []

    for shift in step * torch.eye(2, dtype=torch.float64):
        up = function({**values, "a": values["a"] + shift})
        down = function({**values, "a": values["a"] - shift})
        columns.append((up - down) / (2 * step))

    return torch.stack(columns, dim=-1)
