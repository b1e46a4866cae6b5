"""One goal more: a graph grows without a change to what is there.

What you learn: `policy.with_estimator` and `policy.with_goal` give a policy with one thing more.
Nothing that stands there is touched, no weight is tuned, no order of priorities is written down.
The paths that were there stay, one comes to them, and the action changes only as far as the new
goal has something to say.

A robot goes to a door. Then it is told of a puddle to the left of its way, which it is to keep
away from. Far from the puddle both graphs do the same; beside it the new one turns aside.

    python examples/03_add_a_goal.py
"""

import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)


def move(v: Tensor, dt: Tensor) -> Tensor:
    """How far the robot gets in one step, m."""
    return v * dt


def landmark(name: str, reading: str) -> KalmanFilter:
    """Where something is, relative to the robot, m."""
    shift = Affine(**{name: 1.0, "x": -1.0})
    agreement = Affine(**{name: 1.0, reading: -1.0})

    return KalmanFilter(
        name,
        f"P_{name}",
        predict=shift,
        noise=1e-4,
        initial=((1.0, 0.0), 9.0),
        correct=[Measurement(agreement, noise=0.01**2, size=2)],
    )


# What there is: the way to the door.


def far_from_the_door(door: Tensor) -> Tensor:
    """Cost of the goal "arrive", m."""
    return door.norm(dim=-1)


def make_policy() -> Policy:
    """The way to the door."""
    model = WorldModel(
        sensors={"z_door": Sensor(2, "m")},
        actuators={"v": Actuator(2, "m/s", limit=1.0)},
        estimators=[Deterministic("x", move, is_motion=True), landmark("door", "z_door")],
        goals=[Goal("arrive", far_from_the_door)],
        dt=0.1,
    )
    return Policy(model, law=DirectDescent(smoothing=0.0))


# What is added: the puddle.


def near_the_puddle(puddle: Tensor) -> Tensor:
    """Cost of the goal "stay dry": it rises toward the middle, and is nothing from 1 m on.

    Nothing means exactly zero, not next to it: what counts is how strong a gradient is beside the
    others, so that even a weak one has a say.
    """
    return torch.relu(1.0 - puddle.norm(dim=-1)) ** 2


def told_of_the_puddle(policy: Policy) -> Policy:
    """The same policy with a sensor, an estimator and a goal more."""
    seen = policy.with_estimator(landmark("puddle", "z_puddle"), z_puddle=Sensor(2, "m"))
    return seen.with_goal(Goal("stay dry", near_the_puddle))


def main() -> None:
    """Compare paths and actions of the two graphs."""
    before = make_policy()
    after = told_of_the_puddle(before)

    print("paths before")
    print(before.model.paths())
    print("\npaths after")
    print(after.model.paths())

    door = torch.tensor([5.0, 0.0])
    far, near = torch.tensor([1.5, 1.0]), torch.tensor([0.3, 0.6])

    print("\nfar from the puddle")
    far_before, far_after = compare(before, after, door, far)
    print("\nbeside it")
    near_before, near_after = compare(before, after, door, near)

    old_paths, new_paths = set(before.model.paths()), set(after.model.paths())
    is_silent_elsewhere = torch.allclose(far_after, far_before)
    turns_aside = near_after[1] < near_before[1] - 0.1

    if not (old_paths < new_paths and is_silent_elsewhere and turns_aside):
        raise SystemExit("\nThe new goal did not do what was announced.")
    print("\nThe new goal acts where it has something to say, and nothing else has changed.")


def compare(before: Policy, after: Policy, door: Tensor, puddle: Tensor) -> tuple[Tensor, Tensor]:
    """The velocities of both policies on the same readings, and what met in the new one."""
    old_velocity, _ = before.predict({"z_door": door})
    new_velocity, memory = after.predict({"z_door": door, "z_puddle": puddle})

    print(f"  velocity before {as_text(old_velocity)} m/s, after {as_text(new_velocity)} m/s")
    displacement = after.trace(memory).quantities["x"]
    magnitudes, weights = displacement.magnitudes.tolist(), displacement.weights.tolist()
    for path, magnitude, weight in zip(displacement.labels, magnitudes, weights, strict=True):
        print(f"  {path}: magnitude {magnitude:.2f}, weight {weight:.2f}")

    return old_velocity, new_velocity


def as_text(velocity: Tensor) -> str:
    """(x, y) with two digits."""
    x, y = (round(component, 2) + 0.0 for component in velocity.tolist())  # no -0.00
    return f"({x:+.2f}, {y:+.2f})"


if __name__ == "__main__":
    main()
