"""Small policies: points that are steered to a goal."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import (
    Actuator,
    Affine,
    DirectDescent,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def point() -> KalmanFilter:
    """A point whose position is measured and which moves with the action."""
    return KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, a=0.1),
        noise=0.1,
        initial=((0.0, 0.0), 1.0),
        correct=[Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)],
    )


def two_robots() -> WorldModel:
    """Two actuators, one of which moves the point and one of which places what it goes to."""

    def meet(x: Tensor, b: Tensor) -> Tensor:
        return ((x - b - 1.0) ** 2).sum(-1)

    return WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", 0.5), "b": Actuator(2, "m", (1.0, 2.0))},
        estimators=[point()],
        goals=[Goal("meet", meet)],
        dtype=torch.float64,
    )


def steered(
    constraints: Sequence[Any] = (),
    command: Any = None,
    goal: tuple[float, float] = (3.0, -1.0),
    command_range: tuple[float, float] | None = None,
    max_age: float | None = None,
) -> Policy:
    """A point that goes to a goal with at most 2 m/s."""

    def reach(x: Tensor) -> Tensor:
        return ((x - x.new_tensor(goal)) ** 2).sum(-1)

    model = WorldModel(
        sensors={"z": Sensor(2, "m", max_age=max_age), "wall": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s", 2.0, constraints, command, command_range)},
        estimators=[point()],
        goals=[Goal("reach", reach)],
        dt=0.1,
        dtype=torch.float64,
    )
    return Policy(model, Sum(), DirectDescent(10.0))


def walled(steps: int, batch: tuple[int, ...] = (), wall: float = 0.1) -> list[dict[str, Tensor]]:
    """Noisy readings of a point that stays at the origin, and of a wall to its right."""
    walls = torch.full((*batch, 1), wall, dtype=torch.float64)
    return [
        {"z": 0.1 * normal(*batch, 2, seed=seed), "wall": walls.clone()} for seed in range(steps)
    ]


# --- constraints and commands


def slower(a: Tensor) -> Tensor:
    """A constraint that halves."""
    return 0.5 * a


def rightward(a: Tensor) -> Tensor:
    """A constraint that shifts."""
    return a + torch.tensor([1.0, 0.0], dtype=a.dtype)


def off_the_wall(a: Tensor, x: Tensor, wall: Tensor, dt: float) -> Tensor:
    """No farther to the right than the wall, of which a sensor tells."""
    room = (wall - x[..., :1]) / dt
    return torch.cat((torch.minimum(a[..., :1], room), a[..., 1:]), dim=-1)


def where_to(a: Tensor, x: Tensor, dt: float) -> Tensor:
    """The command: a position instead of a velocity."""
    return x + a * dt
