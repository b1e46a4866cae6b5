"""How a step grows with the graph, and whether memory grows with the steps.

Example: python scripts/benchmark_scaling.py --out runs/benchmark

Processor time of one uncompiled step on one thread, against the number of sides of the pushed object (each brings two
paths) and the number of goals (each brings an estimator and a path); then the process's resident memory over many
compiled steps of navigation. Graphs whose paths double with every rung are in scripts/benchmark.py.
"""

import argparse
import json
import math
import os
import resource
import statistics
import time
from pathlib import Path
from typing import Any, cast

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import torch
from tqdm import tqdm

from aicon_torch import (
    ActionLaw,
    Actuator,
    Affine,
    Deterministic,
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

SIDES = (4, 8, 32, 128, 512)
GOALS = (1, 4, 16, 64)


def main() -> None:
    """Parse the arguments, measure, print and save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--rounds", type=int, default=30, help="rounds in which the graphs take turns (default: 30)"
    )
    parser.add_argument(
        "--steps", type=int, default=1_000_000, help="steps whose memory is watched (default: 10^6)"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for scaling.json")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    arguments.out.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {}
    for name, numbers, make in (("sides", SIDES, pushing), ("goals", GOALS, landmarks)):
        results[name] = measure(
            {number: make(number) for number in numbers}, arguments.rounds, name
        )
        for number, milliseconds in results[name].items():
            print(f"{number:6} {name}: {milliseconds:.2f} ms a step")
        _save(arguments.out, results)
    results["memory"] = watch_memory(arguments.steps)
    _save(arguments.out, results)
    for steps, size in results["memory"]:
        print(f"{steps:10,} steps: {size:.1f} MiB at most")


def measure(
    cases: dict[int, tuple[Policy, dict[str, torch.Tensor]]], rounds: int, name: str
) -> dict[int, float]:
    """Median processor time of a step, ms; the cases take turns."""
    memories = {number: policy.predict(readings)[1] for number, (policy, readings) in cases.items()}
    times: dict[int, list[float]] = {number: [] for number in cases}
    for _ in tqdm(range(rounds), desc=name, disable=None):
        for number, (policy, readings) in cases.items():
            start = time.process_time()
            for _ in range(5):
                memories[number] = policy.predict(readings, memories[number])[1]
            times[number].append((time.process_time() - start) / 5)
    return {number: 1e3 * statistics.median(taken) for number, taken in times.items()}


def pushing(sides: int) -> tuple[Policy, dict[str, torch.Tensor]]:
    """Pushing a regular polygon of 60 px radius."""
    angles = torch.arange(sides, dtype=torch.float64) * 2 * math.pi / sides
    corners = 60.0 * torch.stack((angles.cos(), angles.sin()), dim=-1)
    readings = {
        "agent_pos": torch.tensor([120.0, 260.0], dtype=torch.float64),
        "environment_state": (corners + torch.tensor([200.0, 300.0])).flatten(),
    }
    return make_policy("pusht", keypoints=corners.tolist()), readings


def landmarks(goals: int) -> tuple[Policy, dict[str, torch.Tensor]]:
    """A point that is to be near each of several landmarks."""
    names = [f"p{index}" for index in range(goals)]
    estimators = [
        KalmanFilter(
            name,
            f"P_{name}",
            predict=Affine(**{name: 1.0, "x": -1.0}),
            noise=1e-4,
            initial=((1.0, 0.0), 1.0),
            correct=[Measurement(Affine(**{name: 1.0, f"z_{name}": -1.0}), noise=0.01, size=2)],
        )
        for name in names
    ]
    model = WorldModel(
        sensors={f"z_{name}": Sensor(2, "m") for name in names},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[Deterministic("x", _displacement, is_motion=True), *estimators],
        goals=[_near(name) for name in names],
        dt=0.1,
        dtype=torch.float64,
    )
    readings = {f"z_{name}": torch.randn(2, dtype=torch.float64) for name in names}
    return Policy(model, NullspaceProjection(), ActionLaw(gain=1.0)), readings


def watch_memory(steps: int) -> list[tuple[int, float]]:
    """The largest resident memory so far, MiB, after a tenth of the steps, two tenths, and so on."""
    policy = make_policy("nav2d").compile()
    readings = {"bearing": torch.zeros(1), "range": torch.full((1,), 0.15)}
    memory, seen = policy.predict(readings)[1], []
    for step in tqdm(range(1, steps + 1), desc="memory", disable=None):
        memory = policy.predict(readings, memory)[1]
        if step % max(1, steps // 10) == 0:
            seen.append((step, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))
    return seen


def _displacement(a: torch.Tensor, dt: float) -> torch.Tensor:
    return a * dt


def _near(name: str) -> Goal:
    return Goal(f"near {name}", Interconnection(_length, [name]))


def _length(p: torch.Tensor) -> torch.Tensor:
    return cast(torch.Tensor, torch.linalg.vector_norm(p, dim=-1))


def _save(out: Path, results: dict[str, Any]) -> None:
    (out / "scaling.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
