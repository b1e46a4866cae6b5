"""What a convolutional network costs in pushT's compiled step, and whether it computes the same.

Example: python scripts/network_cost.py --rounds 30

The network, which is not trained, reads the keypoints and moves the residual of the object's pose
by a little. Readable, compiled and exported steps are compared from the same memories in an
episode. Times are those of the processor; with and without the network take turns.
"""

import argparse
import os
import tempfile
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, add_option, run_command

STEPS = 50
"""Of the episode in which steps are compared."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how long to measure."""
    add_option(parser, "--rounds", 30, "rounds in which the two take turns")
    add_option(parser, "--steps", 100, "steps of each in a round")


def run(arguments: argparse.Namespace) -> None:
    """Print a line for pushT without the network, and one with it."""
    import torch

    from aicon_baselines.cli.bench import observations_of_one
    from aicon_baselines.evaluation.tables import to_markdown
    from aicon_baselines.evaluation.timing import replay, spread, take_turns
    from aicon_torch import make_policy

    torch.set_num_threads(1)
    observations = observations_of_one("pusht", "deterministic", STEPS)
    lines, programs = [], {}
    for name, build in {"without": lambda: make_policy("pusht"), "with": with_network}.items():
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

    from aicon_torch import EKF, Interconnection, Measurement, Policy, WorldModel, make_policy
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

    policy = make_policy("pusht")
    model, estimators = policy.model, list(policy.model.declaration.estimators)
    place = next(place for place, each in enumerate(estimators) if "x_pose" in each.outputs)
    pose: Any = estimators[place]
    moved = Moved(pose.measurements[0].residual.function)
    residual = Interconnection(moved, x_pose=Constant(torch.eye(3)))
    noise = pose.measurements[0].noise.constant.diagonal().tolist()
    estimators[place] = EKF(
        "x_pose",
        "P_pose",
        predict=pose.predict,
        noise=pose.noise.constant.diagonal().tolist(),
        initial=pose.prior,
        size=3,
        correct=[Measurement(residual, noise, size=3)],
    )
    print(f"{sum(weight.numel() for weight in moved.network.parameters())} weights")
    changed = WorldModel(
        sensors=model.sensors,
        actuators=model.actuators,
        estimators=estimators,
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
