"""A graph for a robot of your own: follow a leader, and stay near the base.

What you learn: how sensors, an actuator, estimators and goals become a world model; how a policy
runs in a closed loop, with a memory that goes in and comes out; and how to ask it what it decided.

The robot moves in a plane. It sees the leader and the base, both relative to itself, with 5 cm of
noise. It is to follow the leader at 1 m, but never to leave the base by more than about 5 m. The
leader walks away to 8 m and comes back, so that for a while the robot cannot have both.

    python examples/01_own_graph.py
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
    NullspaceProjection,
    Policy,
    Sensor,
    WorldModel,
)

DT = 0.1  # s
SIGHT_NOISE = 0.05  # standard deviation, m


# The graph. The parameter names of a function are its wiring: `move` reads the quantity `v`.


def move(v: Tensor, dt: Tensor) -> Tensor:
    """How far the robot gets in one step, m."""
    return v * dt


def gap(leader: Tensor) -> Tensor:
    """Cost of the goal "follow": the distance to the leader should be 1 m."""
    return (leader.norm(dim=-1) - 1.0).abs()


def leash(base: Tensor) -> Tensor:
    """Cost of the goal "leash": nothing near the base, and steep beyond 5 m."""
    return torch.exp(4.0 * (base.norm(dim=-1) - 5.0))


def landmark(name: str, reading: str) -> KalmanFilter:
    """Where something is, relative to the robot: it shifts back as the robot moves forward."""
    shift = Affine(**{name: 1.0, "x": -1.0})
    agreement = Affine(**{name: 1.0, reading: -1.0})

    return KalmanFilter(
        name,
        f"P_{name}",
        predict=shift,
        noise=1e-3,
        initial=((1.0, 0.0), 9.0),
        correct=[Measurement(agreement, noise=SIGHT_NOISE**2, size=2)],
    )


def make_model() -> WorldModel:
    """The world model: two readings, one velocity, three estimates, two goals."""
    return WorldModel(
        sensors={"z_leader": Sensor(2, "m", optional=True), "z_base": Sensor(2, "m")},
        actuators={"v": Actuator(2, "m/s", limit=1.0)},
        estimators=[
            Deterministic("x", move, is_motion=True),
            landmark("leader", "z_leader"),
            landmark("base", "z_base"),
        ],
        goals=[Goal("follow", gap), Goal("leash", leash)],
        dt=DT,
    )


# The world, which the policy sees through its sensors only.


def leader_at(time: float) -> Tensor:
    """Where the leader is, m: it walks out to 8 m and comes back, on an ellipse."""
    angle = torch.tensor(2 * torch.pi * time / 60.0)
    return torch.stack((4.0 - 4.0 * angle.cos(), 3.0 * angle.sin()))


def observe(robot: Tensor, leader: Tensor, noise: torch.Generator) -> dict[str, Tensor]:
    """Leader and base relative to the robot."""
    base = torch.zeros(2)
    errors = SIGHT_NOISE * torch.randn(2, 2, generator=noise)
    return {"z_leader": leader - robot + errors[0], "z_base": base - robot + errors[1]}


def main() -> None:
    """Follow the leader for a minute."""
    policy = Policy(make_model(), NullspaceProjection(), DirectDescent(gain=10.0))
    print("Every goal reaches the actuator by a path of its own:")
    print(policy.model.paths())

    noise = torch.Generator().manual_seed(0)
    robot, memory = torch.tensor([-1.0, -1.0]), None
    gaps: list[float] = []
    farthest = 0.0

    for step in range(600):
        leader = leader_at(step * DT)
        velocity, memory = policy.predict(observe(robot, leader, noise), memory)
        robot = robot + velocity * DT

        gaps.append(float((leader - robot).norm()))
        farthest = max(farthest, float(robot.norm()))
        if step in (100, 300):
            print(f"\nAt {step * DT:.0f} s, {gaps[-1]:.1f} m from the leader:")
            print(policy.explain(memory))

    at_end = sum(gaps[-100:]) / 100
    print(f"\nIn the last 10 s the robot was {at_end:.2f} m from the leader on average.")
    print(f"It never went farther than {farthest:.2f} m from the base.")
    if at_end > 1.5 or farthest > 5.5:
        raise SystemExit("The robot lost its leader.")
    print("The robot follows its leader.")


if __name__ == "__main__":
    main()
