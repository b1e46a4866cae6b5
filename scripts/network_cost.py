"""What a convolutional network costs in pushT's compiled step, and whether it computes the same.

Example: python scripts/network_cost.py --rounds 30

A network that is not trained reads the keypoints and moves the residual of the object's pose by a
little; another one, which is, sees the pose in pictures of 48 × 48 pixels. Readable, compiled and
exported steps are compared from the same memories in an episode. Times are those of the processor;
the policies take turns.
"""

import argparse
import os
import tempfile
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, add_option, run_command

STEPS = 50
"""Of the episode in which steps are compared."""

SIDE = 48
"""Of a picture, pixels."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how long to measure."""
    add_option(parser, "--rounds", 30, "rounds in which the two take turns")
    add_option(parser, "--steps", 100, "steps of each in a round")


def run(arguments: argparse.Namespace) -> None:
    """Print a line for pushT without a network, and one with each."""
    import torch

    from aicon_baselines.cli.bench import observations_of_one
    from aicon_baselines.evaluation.tables import to_markdown
    from aicon_baselines.evaluation.timing import replay, spread, take_turns
    from aicon_torch import make_policy

    torch.set_num_threads(1)
    corners = observations_of_one("pusht", "deterministic", STEPS)
    pictures = [
        {**seen, "pixels": seen["pixels"].reshape(-1).astype(float)}
        for seen in observations_of_one("pusht", "pixels_48", STEPS)
    ]
    cases: dict[str, Any] = {
        "without": (lambda: make_policy("pusht"), corners),
        "with": (with_network, corners),
        "of pictures": (with_picture, pictures),
    }
    lines, programs = [], {}
    for name, (build, observations) in cases.items():
        with tempfile.TemporaryDirectory() as cache:  # nothing is compiled there yet
            os.environ["XDG_CACHE_HOME"] = cache
            compiled, seconds = compile_here(build(), observations[0])
            policy = build()
            policy.export(Path(cache) / "policy.so")
            off = [largest_difference(policy, other, observations) for other in (compiled, cache)]
        programs[name] = replay(compiled, observations)
        lines.append([name, f"{seconds:.1f} s", *(f"{each:.1e}" for each in off)])

    times = take_turns(programs, arguments.rounds, arguments.steps, "steps")
    for line in lines:
        line.append(spread(times[line[0]], 1e3))
    header = ["network", "compiles in", "compiled differs by", "exported by", "step, ms"]
    print(to_markdown(header, lines))


def with_network() -> Any:
    """PushT's policy with a network of some 30,000 weights in its graph."""
    import torch
    from torch import Tensor, nn

    from aicon_torch import Interconnection, Measurement, make_policy
    from aicon_torch.interconnections import Constant

    torch.manual_seed(0)
    layers = (
        *(nn.Linear(16, 144), nn.Unflatten(-1, (1, 12, 12))),
        *(nn.Conv2d(1, 16, 3, padding=1), nn.ReLU(), nn.AvgPool2d(2)),
        *(nn.Conv2d(16, 32, 3, padding=2, dilation=2), nn.ReLU()),
        *(nn.Conv2d(32, 64, 3, stride=2, padding=1), nn.GELU(), nn.Flatten()),
        *(nn.LayerNorm(576), nn.Linear(576, 8), nn.Tanh(), nn.Linear(8, 3)),
    )

    class Moved(nn.Module):
        """The residual of a pose and of keypoints, moved by a network."""

        def __init__(self, residual: Any) -> None:
            super().__init__()
            self.residual, self.network = residual, nn.Sequential(*layers).eval()

        def forward(self, x_pose: Tensor, z_keypoints: Tensor) -> Tensor:
            moved: Tensor = self.residual(x_pose, z_keypoints) + 1e-4 * self.network(z_keypoints)
            return moved

    policy: Any = make_policy("pusht")
    pose = _pose(policy)
    moved = Moved(pose.measurements[0].residual.function)
    residual = Interconnection(moved, x_pose=Constant(torch.eye(3)))
    noise = pose.measurements[0].noise.constant.diagonal().tolist()
    process = pose.noise.constant.diagonal().tolist()
    print(f"{sum(weight.numel() for weight in moved.network.parameters())} weights")
    return _changed(policy, pose, process, pose.prior, Measurement(residual, noise, size=3))


def with_picture() -> Any:
    """PushT's policy with pictures as readings, and the network that sees them in its graph."""
    import torch
    from torch import Tensor, nn

    from aicon_baselines.tasks import load
    from aicon_torch import Interconnection, Measurement, Sensor, make_policy
    from aicon_torch.interconnections import Constant
    from aicon_torch.models.pusht.picture import first_sight, seen_off, seen_variances

    class Seen(nn.Module):
        """What is made of the pose that a network sees in a picture."""

        def __init__(self, make: Any) -> None:
            super().__init__()
            self.make, self.network = make, network

        def forward(self, z_picture: Tensor, *others: Tensor) -> Any:
            pictures = z_picture.reshape(-1, SIDE, SIDE, 3).movedim(-1, -3)
            return self.make(*others, self.network(pictures / 255).pose)

    policy: Any = make_policy("pusht", **load("pusht").policy_options("pixels_48"))
    network, pose = policy.perception.network, _pose(policy)
    residual = Interconnection(
        Seen(seen_off), inputs=["z_picture", "x_pose"], x_pose=Constant(torch.eye(3))
    )
    noise = Interconnection(Seen(seen_variances), inputs=["z_picture"])
    first = Interconnection(Seen(first_sight), inputs=["z_picture"])
    picture = Sensor(SIDE * SIDE * 3, "grey levels", key="pixels", optional=True)
    measurement = Measurement(residual, noise, size=3)
    return _changed(policy, pose, pose.noise.relation, first, measurement, z_picture=picture)


def _pose(policy: Any) -> Any:
    """The estimator of the object's pose."""
    return next(each for each in policy.model.declaration.estimators if "x_pose" in each.outputs)


def _changed(
    policy: Any, pose: Any, noise: Any, initial: Any, measurement: Any, **sensors: Any
) -> Any:
    """A policy whose object is estimated otherwise, and seen by other sensors if any are given."""
    import torch

    from aicon_torch import EKF, Policy, WorldModel

    model = policy.model
    estimator = EKF(
        "x_pose",
        "P_pose",
        predict=pose.predict,
        noise=noise,
        initial=initial,
        size=3,
        correct=[measurement],
    )
    changed = WorldModel(
        sensors={"z_pusher": model.sensors["z_pusher"], **sensors} if sensors else model.sensors,
        actuators=model.actuators,
        estimators=[estimator if e is pose else e for e in model.declaration.estimators],
        goals=list(model.goals.values()),
        dt=model.dt,
        dtype=torch.float64,
    )
    return Policy(changed, policy.resolution, policy.law)


def compile_here(policy: Any, observation: dict[str, Any]) -> tuple[Any, float]:
    """The compiled policy, and the processor seconds, the compiler's among them, that took."""
    from aicon_baselines.evaluation.timing import processor_seconds

    before = processor_seconds()
    compiled = policy.compile()
    compiled.predict(observation)
    return compiled, processor_seconds() - before


def largest_difference(policy: Any, other: Any, observations: list[dict[str, Any]]) -> float:
    """Of the actions and estimates of two forms of a policy, in m and rad, step by step."""
    from aicon_torch import load_exported

    if isinstance(other, str):
        other = load_exported(Path(other) / "policy.so")
    memory, largest = None, 0.0
    for observation in observations:
        _, found = other.predict(observation, memory)
        _, memory = policy.predict(observation, memory)
        for name in ("a", "x_pose", "P_pose", "x_pusher"):
            largest = max(largest, float((found[name] - memory[name]).abs().max()))
    return largest


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
