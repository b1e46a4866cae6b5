"""A robot on wheels that slip learns from a log how they slip, and then arrives in the dark.

What you learn: a network may stand in a motion model, beside what is known. The model says how
wheels roll; the network says by how much each of them turns in vain, and learns it from a log by
the likelihood of its readings. No reading tells the slip itself.

Afterwards the camera sees the robot in its first second only, and what the model predicts is all
that it knows of its place.

    python examples/08_learned_motion.py
"""

import torch
from torch import Tensor, nn

from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.parts import DifferentialDrive

DT = 0.1  # s
NOISE = 0.005  # of the camera, m and rad
TARGET = torch.tensor([0.0, 0.0], dtype=torch.float64)
DRIVE = DifferentialDrive(track=0.3)  # m


class Slipping(nn.Module):
    """How the robot moves in a step: as its wheels roll, less the share by which they slip."""

    def __init__(self) -> None:
        super().__init__()
        self.gain = nn.Sequential(nn.Linear(2, 16), nn.Tanh(), nn.Linear(16, 2))
        nn.init.zeros_(self.gain[-1].weight)
        nn.init.zeros_(self.gain[-1].bias)

    def forward(self, a: Tensor, dt: Tensor) -> Tensor:
        """x_rob ``(*B, 2)``, m."""
        return DRIVE.motion(a * (1 + self.gain(2 * a)), dt)


def distance(x_point: Tensor) -> Tensor:
    """Cost of the goal "reach", m."""
    return (x_point - TARGET).norm(dim=-1)


def make_policy() -> Policy:
    """A policy whose model does not know of any slip yet."""
    torch.manual_seed(0)
    model = WorldModel(
        sensors={"z_pose": Sensor(3, "m, m and rad", optional=True)},
        actuators={"a": Actuator(2, "m/s", limit=(0.5, 0.5))},
        estimators=[
            Deterministic("x_rob", Slipping(), is_motion=True),
            DRIVE.pose_estimator(
                "x_pose", "z_pose", noise=(NOISE, NOISE, NOISE), motion_noise=0.002
            ),
            Deterministic("x_point", DRIVE.point_ahead),
        ],
        goals=[Goal("reach", distance)],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model)


def roll(pose: Tensor, wheels: Tensor) -> Tensor:
    """The world: the left tyre is flat, and both slip in turns."""
    left, right = wheels.unbind(-1)
    grip = 1 - 0.5 * (left - right) ** 2
    speed, turn = DRIVE.twist(torch.stack((0.8 * grip * left, grip * right), dim=-1)).unbind(-1)
    direction = pose[..., 2] + 0.5 * DT * turn
    step = torch.stack((speed * direction.cos(), speed * direction.sin(), turn), dim=-1)
    return pose + DT * step


def seen(pose: Tensor, generator: torch.Generator) -> Tensor:
    """A reading of the camera."""
    noise = torch.randn(pose.shape, generator=generator, dtype=pose.dtype)
    return pose + NOISE * noise


def starts(count: int, generator: torch.Generator) -> Tensor:
    """Poses about 2 m from the target."""
    angle = 2 * torch.pi * torch.rand((2, count), generator=generator, dtype=torch.float64)
    return torch.stack((2 * angle[0].cos(), 2 * angle[0].sin(), angle[1]), dim=-1)


def record(count: int, steps: int, seed: int) -> tuple[dict[str, Tensor], dict[str, Tensor]]:
    """A log of random driving under the camera: readings and actions ``(count, steps, n)``."""
    generator = torch.Generator().manual_seed(seed)
    pose, readings, actions = starts(count, generator), [], []
    for step in range(steps):
        if step % 10 == 0:
            wheels = torch.rand((count, 2), generator=generator, dtype=torch.float64) - 0.5
        readings.append(seen(pose, generator))
        actions.append(wheels)
        pose = roll(pose, wheels)
    return {"z_pose": torch.stack(readings, 1)}, {"a": torch.stack(actions, 1)}


def learn(policy: Policy) -> Policy:
    """The policy whose network makes the readings of a log likeliest."""
    learner = policy.learn("x_rob.relation")
    readings, actions = record(count=100, steps=20, seed=0)
    optimizer = torch.optim.LBFGS(learner.parameters(), max_iter=40, line_search_fn="strong_wolfe")

    def surprise() -> Tensor:
        filtered = learner.filter(readings, actions)
        loss = -filtered.log_likelihood().sum() / filtered.readings().sum()
        optimizer.zero_grad()
        loss.backward()
        return loss

    optimizer.step(surprise)
    return learner


def prediction_error(policy: Policy) -> float:
    """By how much it is off after two seconds without a camera, on a log of its own, m."""
    readings, actions = record(count=50, steps=40, seed=1)
    truth = readings["z_pose"].clone()
    readings["z_pose"][:, 20:] = torch.nan
    with torch.no_grad():
        believed = policy.filter(readings, actions).estimates["x_pose"]
    return float((believed - truth)[:, -1, :2].norm(dim=-1).mean())


def arrivals(policy: Policy, count: int = 50) -> int:
    """How many come within 5 cm of the target, where the camera sees the first second only."""
    generator = torch.Generator().manual_seed(300_000)
    pose, memory = starts(count, generator), None
    for step in range(150):
        reading = seen(pose, generator) if step < 10 else torch.full_like(pose, torch.nan)
        action, memory = policy.predict({"z_pose": reading}, memory)
        pose = roll(pose, action)
    return int((distance(DRIVE.point_ahead(pose)) < 0.05).sum())


def main() -> None:
    """Drive as wheels roll, and as they were learned to."""
    rolling = make_policy()
    arrived = []
    for name, policy in (("as wheels roll", rolling), ("as was learned", learn(rolling))):
        off = 100 * prediction_error(policy)
        arrived.append(arrivals(policy))
        print(f"{name}: {off:.1f} cm off after 2 s in the dark, {arrived[-1]} of 50 arrive")
    if arrived[0] < 5 and arrived[1] >= 48:
        print("What was learned brings the robots to their target.")


if __name__ == "__main__":
    main()
