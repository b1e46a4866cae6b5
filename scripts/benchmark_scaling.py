"""How a step grows with the graph, and whether memory grows with the steps.

Example: python scripts/benchmark_scaling.py --out runs/benchmark

Processor time of one uncompiled step on one thread, against the number of sides of the pushed
object (each brings two paths) and the number of goals (each brings an estimator and a path); then
the process's resident memory over many compiled steps of navigation. Graphs whose paths double with
every rung are in scripts/benchmark.py.
"""

import argparse
import json
import math
import resource
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from aicon_baselines.cli.command_line import Command, run_command

# isort: split

import torch
from torch import Tensor
from tqdm import tqdm

from aicon_baselines.evaluation.timing import Step, replay, take_turns
from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    Interconnection,
    KalmanFilter,
    Measurement,
    NullspaceProjection,
    Policy,
    Sensor,
    WorldModel,
    make_policy,
)
from aicon_torch.models.pusht import PIXEL

SIDES = (4, 8, 32, 128, 512)
GOALS = (1, 4, 16, 64)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much to measure."""
    parser.add_argument(
        "--rounds", type=int, default=30, help="rounds in which the graphs take turns (default: 30)"
    )
    parser.add_argument(
        "--steps", type=int, default=1_000_000, help="steps whose memory is watched (default: 10^6)"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for scaling.json")


def run(arguments: argparse.Namespace) -> None:
    """Measure, print and save."""
    torch.set_num_threads(1)
    arguments.out.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {}

    cases: dict[str, tuple[tuple[int, ...], Callable[[int], Step]]] = {
        "sides": (SIDES, pushing),
        "goals": (GOALS, landmarks),
    }
    for name, (numbers, build) in cases.items():
        results[name] = measure(numbers, build, arguments.rounds, name)
        for number, milliseconds in results[name].items():
            print(f"{number:>6} {name}: {milliseconds:.2f} ms a step")
        save(results, arguments.out)

    results["memory"] = watch_memory(arguments.steps)
    save(results, arguments.out)
    for steps, size in results["memory"]:
        print(f"{steps:10,} steps: {size:.1f} MiB at most")


def measure(
    numbers: tuple[int, ...], build: Callable[[int], Step], rounds: int, name: str
) -> dict[str, float]:
    """Median processor time of a step, ms, for each size of the graph; they take turns."""
    programs = {str(number): build(number) for number in numbers}
    times = take_turns(programs, rounds, steps=5, name=name)
    return {number: 1e3 * statistics.median(taken) for number, taken in times.items()}


def pushing(sides: int) -> Step:
    """A step of pushing a regular polygon of 60 px radius."""
    angles = torch.arange(sides, dtype=torch.float64) * 2 * math.pi / sides
    corners = 60.0 * torch.stack((angles.cos(), angles.sin()), dim=-1)
    policy = make_policy("pusht", keypoints=(PIXEL * corners).tolist())

    readings = {
        "agent_pos": torch.tensor([120.0, 260.0], dtype=torch.float64),
        "environment_state": (corners + torch.tensor([200.0, 300.0])).flatten(),
    }
    return replay(policy, [readings])


def landmarks(goals: int) -> Step:
    """A step of a point that is to be near each of several landmarks."""
    names = [f"p{index}" for index in range(goals)]
    model = WorldModel(
        sensors={f"z_{name}": Sensor(2, "m") for name in names},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[
            Deterministic("x", _displacement, is_motion=True),
            *(_landmark(name) for name in names),
        ],
        goals=[Goal(f"near {name}", Interconnection(_length, [name])) for name in names],
        dt=0.1,
        dtype=torch.float64,
    )
    policy = Policy(model, NullspaceProjection(), DirectDescent(gain=1.0))

    readings = {f"z_{name}": torch.randn(2, dtype=torch.float64) for name in names}
    return replay(policy, [readings])


def watch_memory(steps: int) -> list[tuple[int, float]]:
    """The largest resident memory so far, MiB, after a tenth of the steps, two tenths, ..."""
    policy = make_policy("nav2d").compile()
    readings = {"bearing": torch.zeros(1), "range": torch.full((1,), 0.15)}
    memory, sizes = policy.predict(readings)[1], []

    for step in tqdm(range(1, steps + 1), desc="memory", disable=None):
        memory = policy.predict(readings, memory)[1]
        if step % max(1, steps // 10) == 0:
            kibibytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            sizes.append((step, kibibytes / 1024))
    return sizes


def save(results: dict[str, Any], out: Path) -> None:
    """Write scaling.json."""
    (out / "scaling.json").write_text(json.dumps(results, indent=2) + "\n")


def _landmark(name: str) -> KalmanFilter:
    """Estimate the position of a landmark relative to the point, which moves by x."""
    return KalmanFilter(
        name,
        f"P_{name}",
        predict=Affine(**{name: 1.0, "x": -1.0}),
        noise=1e-4,
        initial=((1.0, 0.0), 1.0),
        correct=[Measurement(Affine(**{name: 1.0, f"z_{name}": -1.0}), noise=0.01, size=2)],
    )


def _displacement(a: Tensor, dt: float) -> Tensor:
    return a * dt


def _length(p: Tensor) -> Tensor:
    return cast(Tensor, torch.linalg.vector_norm(p, dim=-1))


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
