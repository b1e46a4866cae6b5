"""A hand between two stops, so that one of the two ways to a target is closed."""

import functools

import torch
from torch import Tensor

from _inputs.shipped import quick
from _inputs.walls import place
from aicon_torch import (
    Actuator,
    Affine,
    DirectDescent,
    Goal,
    Interconnection,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.dampers import PlaceEscape, VelocityDampers
from aicon_torch.parts import JointLimits, SquaredHinge

DT, STOP = 0.05, 3.0


def angle_to_target(q: Tensor, z_target: Tensor) -> Tensor:
    """The angle between a hand and its target, rad, in [0, π]; the hand may go either way round."""
    sine, cosine = torch.sin(q - z_target), torch.cos(q - z_target)
    return torch.atan2(sine.abs(), cosine)[..., 0]


class Slowed:
    """Half as fast on the way to a target."""

    slows_for_targets = True

    def __call__(self, a: Tensor) -> Tensor:
        return a / 2.0


def readable_hand(
    escape: PlaceEscape | None, speed: float = 1.0, dt: float = DT, slowed: bool = False
) -> Policy:
    """A hand that turns between two stops, so that one of the two ways to a target is closed."""
    stops = JointLimits((-STOP,), (STOP,), SquaredHinge(0.02, 1.0))
    joint = KalmanFilter(
        "q",
        "P",
        predict=Affine(q=1.0, a=dt),
        noise=1e-4,
        initial=((0.0,), 1.0),
        correct=[Measurement(Affine(q=1.0, z=-1.0), 1e-8)],
    )
    limits = Goal("stops", Interconnection(stops, inputs=["q"]), safety=True)

    model = WorldModel(
        sensors={"z": Sensor(1, "rad"), "z_target": Sensor(1, "rad")},
        actuators={
            "a": Actuator(
                1,
                "rad/s",
                limit=(speed,),
                constraints=[Slowed()] if slowed else [],
                dampers=VelocityDampers(escape=escape),
            )
        },
        estimators=[joint],
        goals=[Goal("point", angle_to_target, tolerance=0.02), limits],
        dt=dt,
        dtype=torch.float64,
    )
    return Policy(model, law=DirectDescent(smoothing=0.0))


@functools.cache
def hand(
    escape: PlaceEscape | None, speed: float = 1.0, dt: float = DT, slowed: bool = False
) -> Policy:
    """The same, compiled where there is a C compiler."""
    return quick(readable_hand(escape, speed, dt, slowed))


def turn(policy: Policy, start: float, target: float, steps: int) -> tuple[Tensor, Tensor]:
    """The angles ``(steps + 1,)`` and whether the hand was escaping ``(steps,)``."""
    q, memory = [place(start)], None
    escaping: list[Tensor] = []
    for _ in range(steps):
        action, memory = policy.predict({"z": q[-1], "z_target": place(target)}, memory)
        q.append(q[-1] + policy.model.dt * action)
        escaping.append(memory.get("a/escape/escaping", torch.tensor(False)))
    return torch.stack(q)[:, 0], torch.stack(escaping)
