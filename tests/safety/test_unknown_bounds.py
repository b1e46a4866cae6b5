"""A safety goal bounds nothing where it is no number: then nothing moves."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from _inputs.shipped import quick
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Goal,
    Interconnection,
    Policy,
    Sensor,
    WorldModel,
)

DT = 0.1


class Stops(nn.Module):
    """Joints stay within ±1; what their gaps are is as somebody wrote it."""

    def __init__(self, written: Callable[[Tensor], Tensor]) -> None:
        super().__init__()
        self.written = written

    def forward(self, x: Tensor) -> Tensor:
        return (x.abs() - 1.0).clamp(min=0.0).sum(-1)

    def gaps(self, x: Tensor) -> Tensor:
        return self.written(torch.cat((1.0 - x, 1.0 + x), dim=-1))


def policy(written: Callable[[Tensor], Tensor], dt: float = DT) -> Policy:
    """It wants to go far beyond the stops; where it is follows from what it reads and does."""
    stops = Interconnection(Stops(written), inputs=["x"])
    model = WorldModel(
        sensors={"z": Sensor(2, "rad")},
        actuators={"a": Actuator(2, "rad/s", limit=1.0)},
        estimators=[Deterministic("x", Affine(z=1.0, a="dt"))],
        goals=[
            Goal("stops", stops, safety=True),
            Goal("far", lambda x: (x - 3.0).square().sum(-1)),
        ],
        dt=dt,
        dtype=torch.float64,
    )
    return Policy(model)


def farthest(policy: Policy, steps: int = 30) -> float:
    """The largest angle on the way."""
    memory, q, largest = None, np.zeros(2), 0.0
    for _ in range(steps):
        action, memory = policy.predict({"z": q}, memory)
        q = q + policy.model.dt * action
        largest = max(largest, float(np.abs(q).max()))
    return largest


WRITTEN: dict[str, tuple[Callable[[Tensor], Tensor], float]] = {
    "no number anywhere": (lambda gaps: gaps * torch.nan, 0.0),
    "one of four no number": (
        lambda gaps: torch.cat((gaps[..., :1] * torch.nan, gaps[..., 1:]), dim=-1),
        0.0,
    ),
    "no number near a stop": (lambda gaps: torch.where(gaps < 0.3, torch.nan, gaps), 0.8),
    "infinitely far beyond": (lambda gaps: torch.where(gaps < 0.3, -torch.inf, gaps), 0.8),
    "a root": (lambda gaps: gaps.sqrt(), 1.0),
}


OFTEN = ("no number anywhere", "a root")
"""What runs compiled in the quick tests as well."""

CASES = [
    pytest.param(
        *WRITTEN[name],
        is_compiled,
        id=f"{name}-{'compiled' if is_compiled else 'readable'}",
        marks=[pytest.mark.slow] * (is_compiled and name not in OFTEN),
    )
    for name in WRITTEN
    for is_compiled in (False, True)
]


@pytest.mark.parametrize(("written", "most", "is_compiled"), CASES)
def test_nothing_moves_where_a_bound_is_no_number(
    written: Callable[[Tensor], Tensor], most: float, is_compiled: bool
) -> None:
    moving = policy(written)
    assert farthest(quick(moving) if is_compiled else moving) <= most + 1e-6


def test_one_row_that_knows_nothing_stops_no_other() -> None:
    moving = policy(lambda gaps: torch.where(gaps[..., :1] < 0.5, torch.nan, gaps))
    _, memory = moving.predict({"z": torch.zeros(2, 2, dtype=torch.float64)})
    apart = torch.tensor([[0.0, 0.0], [0.9, 0.0]], dtype=torch.float64)
    action, _ = moving.predict({"z": apart}, memory)
    assert action[0].norm() > 0.5 and not action[1].any()


@pytest.mark.parametrize("dt", [0.1, 0.3])
def test_what_has_no_memory_is_bounded_from_where_it_is(dt: float) -> None:
    """Its value has moved on by the last action already."""
    found = farthest(policy(lambda gaps: gaps, dt), steps=round(6 / dt))
    assert 0.95 < found <= 1.0 + 1e-9
