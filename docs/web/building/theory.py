"""The policies that the page about theory runs: small graphs, each for one question."""

from typing import Any

import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Foresight,
    Goal,
    Interconnection,
    NullspaceProjection,
    Policy,
    Resolution,
    Sensor,
    Sum,
    WorldModel,
    make_policy,
)
from building import navigation
from building.packing import pack
from concepts import world as corridor

PULLS, SLACK, MARGIN = 12, 0.02, 0.1
"""Most pulls on the floor; where one pulls less, and how far above it the floor is felt, m."""

PLAIN = NullspaceProjection(temperature=None, exploration=None)
"""Projection by itself: magnitudes as they are, and nobody explores."""

STEPS = range(1, 21)
"""How many gradients there may be in a step."""


def data() -> dict[str, Any]:
    """What the page holds."""
    policies = {
        "floor sum": floor(Sum()),
        "floor projection": floor(PLAIN),
        "wall sum": at_wall(Sum()),
        "wall projection": at_wall(PLAIN),
        "wall explore": at_wall(NullspaceProjection()),
        "two sum": two_gradients(Sum()),
        "two projection": two_gradients(PLAIN),
        "two explore": two_gradients(NullspaceProjection(temperature=None)),
        "one gradient": corridor.make_policy(law=DirectDescent(smoothing=0.0)),
        **{f"foresight {count}": foresight(count) for count in STEPS},
        "potential": make_policy("nav2d", law=DirectDescent()),
    }
    return {
        "policies": {name: pack(policy) for name, policy in policies.items()},
        "map": navigation.map_of("u_trap_1", 1000),
        "physics": navigation.physics(),
        "floor": {"pulls": PULLS, "margin": MARGIN},
    }


def floor(resolution: Resolution) -> Policy:
    """A point above a floor, and what pulls it down with slope 1, of which any are switched on."""
    sensors = {"z": Sensor(2, "m"), "z_slope": Sensor(1, "1")}
    estimators = [
        Deterministic("x", displacement, is_motion=True),
        Deterministic("place", place),
    ]
    goals = [Goal("floor", sinking)]
    for index in range(PULLS):
        reading, gap = f"z_pull_{index}", f"pull_{index}"
        sensors[reading] = Sensor(2, "m")
        estimators.append(Deterministic(gap, Interconnection(offset, [reading, "x"])))
        goals.append(Goal(f"pull {index}", Interconnection(nearness, [gap])))

    actuators = {"v": Actuator(2, "m/s", limit=1.0)}
    model = WorldModel(
        sensors=sensors,
        actuators=actuators,
        estimators=estimators,
        goals=goals,
        dt=0.02,
        dtype=torch.float64,
    )
    return Policy(model, resolution, Foresight())


def displacement(v: Tensor, dt: Tensor) -> Tensor:
    """How far the point gets in one step, m."""
    return v * dt


def place(z: Tensor, x: Tensor) -> Tensor:
    """Where it is, with its height above the floor as second component, m."""
    return z + x


def offset(z_pull: Tensor, x: Tensor) -> Tensor:
    """Where what pulls is, relative to the point, m."""
    return z_pull - x


def nearness(gap: Tensor) -> Tensor:
    """√(d² + ε²): its slope is 1 wherever it is not near."""
    return (gap.square().sum(-1) + SLACK**2).sqrt()


def sinking(place: Tensor, z_slope: Tensor) -> Tensor:
    """Slope s from a margin above the floor downward: s max(0, m − h)."""
    return z_slope[..., 0] * torch.relu(MARGIN - place[..., 1])


def at_wall(resolution: Resolution) -> Policy:
    """The robot of the concepts before a wall; it slows down where little pulls."""
    return corridor.make_policy(resolution, DirectDescent(gain=5.0, smoothing=0.0))


def two_gradients(resolution: Resolution) -> Policy:
    """Two gradients that are read; the action is minus what comes of them."""
    model = WorldModel(
        sensors={"z_first": Sensor(2, "1"), "z_second": Sensor(2, "1")},
        actuators={"a": Actuator(2, "1", limit=10.0)},
        estimators=[Deterministic("x", Interconnection(displacement, ["a", "dt"]), is_motion=True)],
        goals=[
            Goal("first", Interconnection(along, ["x", "z_first"])),
            Goal("second", Interconnection(along, ["x", "z_second"])),
        ],
        dt=1.0,
        dtype=torch.float64,
    )
    return Policy(model, resolution, DirectDescent(gain=1.0, smoothing=0.0))


def along(x: Tensor, gradient: Tensor) -> Tensor:
    """A cost whose gradient is what is read."""
    return (x * gradient).sum(-1)


def foresight(count: int) -> Policy:
    """The robot of the concepts with so many gradients in a step."""
    return corridor.make_policy(law=Foresight(iterations=count, smoothing=0.0))
