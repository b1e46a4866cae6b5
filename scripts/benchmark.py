"""Time one control step on one thread: navigation beside the same law by hand in plain torch, pushT beside navigation.

Example: python scripts/benchmark.py --out runs/benchmark

The programs take turns, and what is measured is the processor time of this process, so that a busy machine slows all of
them alike; what counts is the ratio and its spread.
"""

import argparse
import json
import os
import statistics
import time
from pathlib import Path
from typing import Any, cast

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import gymnasium as gym
import numpy as np
import torch
from torch import Tensor

import aicon_envs  # noqa: F401  # registers the environments
import plain_navigation
from aicon_torch import (
    ActionLaw,
    Actuator,
    Deterministic,
    Goal,
    Interconnection,
    Policy,
    Sensor,
    Sum,
    WorldModel,
    make_policy,
)
from timing import Step, spread, take_turns

BOUNDS = {
    "library, batch 1 / by hand, autograd along each path, batch 1": 1.5,
    "library, batch 256 / library, batch 1": 3.0,
    "pushT, batch 1 / navigation, batch 1": 2.0,
    "pushT, batch 256 / pushT, batch 1": 5.0,
}


def main() -> None:
    """Parse the arguments, measure, print and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=60, help="rounds in which the programs take turns (default: 60)")
    parser.add_argument("--steps", type=int, default=20, help="steps of each program a round (default: 20)")
    parser.add_argument("--out", type=Path, help="folder for benchmark.json")
    parser.add_argument("--check", action="store_true", help="fail if a median misses its bound")
    parser.add_argument("--peers", action="store_true", help="time the tools of others beside ours instead")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    if arguments.peers:
        import benchmark_peers  # what it needs is optional

        benchmark_peers.compare(arguments.rounds, arguments.steps, arguments.out)
        return
    steps, rungs = navigation(arguments.rounds, arguments.steps), ladder(arguments.rounds, arguments.steps)
    pushes = pushing(arguments.rounds, arguments.steps)
    speed = environment(gym.make("aicon/Nav2D-v0", map="clutter"), arguments.rounds)
    pushed = pushing_environments(arguments.rounds)
    for title, measured in (("navigation", steps), ("pushT", pushes)):
        print(f"\none {title} step, one thread, ms: median (5 % to 95 %)")
        for name, times in measured["times"].items():
            print(f"  {name:44} {spread(times, 1e3)}")
        print("ratios, taken round by round")
        for name, ratios in measured["ratios"].items():
            print(f"  {name:44} {spread(ratios)}")
    print("a ladder whose paths double with every rung")
    for row in rungs:
        per_edge = spread([1e6 * t / row["edges"] for t in row["times"]])
        print(f"  {row['rungs']:3} rungs, {row['edges']:4} edges, {row['paths']:.2g} paths: {per_edge} µs an edge")
    print(f"aicon/Nav2D-v0 alone: {spread(speed)} steps/s")
    for name, speeds in pushed["speeds"].items():
        print(f"{name} alone: {spread(speeds)} steps/s")
    print(f"  ratio, round by round: {spread(pushed['ratio'])}")
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        path = arguments.out / "benchmark.json"
        content = {"navigation": steps, "pusht": pushes, "ladder": rungs, "environment": speed, "pusht_env": pushed}
        path.write_text(json.dumps(content, indent=2) + "\n")
        print(f"\nsaved in {path}")
    medians = {name: statistics.median((steps["ratios"] | pushes["ratios"])[name]) for name in BOUNDS}
    missed = [f"{name}: {medians[name]:.3g} > {bound}\n" for name, bound in BOUNDS.items() if medians[name] > bound]
    if statistics.median(pushed["ratio"]) < 1:
        missed.append("aicon/PushT-v0 is slower than upstream's environment\n")
    if arguments.check and missed:
        parser.exit(1, "".join(missed))


def navigation(rounds: int, steps: int) -> dict[str, Any]:
    """The library's navigation step and the hand-written one, at batch 1 and 256."""
    programs: dict[str, Step] = {}
    for batch in (1, 256):
        programs[f"library, batch {batch}"] = _library(batch)
        programs[f"by hand, autograd along each path, batch {batch}"] = _by_hand(batch, closed_form=False)
        programs[f"by hand, all in closed form, batch {batch}"] = _by_hand(batch, closed_form=True)
    times = take_turns(programs, rounds, steps, "navigation")
    ratios = {
        f"{first} / {second}": [a / b for a, b in zip(times[first], times[second], strict=True)]
        for first, second in (
            ("library, batch 1", "by hand, autograd along each path, batch 1"),
            ("library, batch 1", "by hand, all in closed form, batch 1"),
            ("library, batch 256", "library, batch 1"),
        )
    }
    return {"times": times, "ratios": ratios}


def pushing(rounds: int, steps: int) -> dict[str, Any]:
    """The step of pushT at batch 1 and 256, beside that of navigation."""
    programs = {"navigation, batch 1": _library(1)}
    programs |= {f"pushT, batch {batch}": _pushing(batch) for batch in (1, 256)}
    times = take_turns(programs, rounds, steps, "pushT")
    pairs = (("pushT, batch 1", "navigation, batch 1"), ("pushT, batch 256", "pushT, batch 1"))
    ratios = {f"{a} / {b}": [x / y for x, y in zip(times[a], times[b], strict=True)] for a, b in pairs}
    return {"times": times, "ratios": ratios}


def environment(env: gym.Env[Any, Any], rounds: int, steps: int = 200) -> list[float]:
    """Steps per second of one environment without rendering, round by round."""
    action = np.zeros(2, np.float32)
    speeds = []
    for _ in range(rounds):
        env.reset(seed=0)
        start = time.process_time()
        for _ in range(steps):
            env.step(action)
        speeds.append(steps / (time.process_time() - start))
    return speeds


def pushing_environments(rounds: int) -> dict[str, Any]:
    """Steps per second of aicon/PushT-v0 and of upstream's, in turns, and their ratio."""
    names = ("aicon/PushT-v0", "gym_pusht:gym_pusht/PushT-v0")
    envs = {name: gym.make(name, obs_type="environment_state_agent_pos") for name in names}
    speeds: dict[str, list[float]] = {name: [] for name in envs}
    for _ in range(rounds):
        for name, env in envs.items():
            speeds[name] += environment(env, 1)
    ours, theirs = speeds.values()
    return {"speeds": speeds, "ratio": [a / b for a, b in zip(ours, theirs, strict=True)]}


def ladder(rounds: int, steps: int) -> list[dict[str, Any]]:
    """Steps of graphs in which every rung reads both sides of the one below it."""
    models = {rungs: _ladder(rungs) for rungs in (4, 8, 16, 32, 64)}
    programs: dict[str, Step] = {
        str(rungs): _stepper(policy, {"z": torch.zeros(1)}) for rungs, policy in models.items()
    }
    times = take_turns(programs, max(1, rounds // 6), max(1, steps // 4), "ladder")
    return [
        {
            "rungs": rungs,
            "edges": sum(len(edges) for edges in policy.model.edges.values()),
            "paths": policy.model.paths().count(),
            "times": times[str(rungs)],
        }
        for rungs, policy in models.items()
    ]


def _library(batch: int) -> Step:
    observation = {"bearing": torch.zeros(batch, 1), "range": torch.full((batch, 1), 0.15)}
    return _stepper(make_policy("nav2d"), observation)


def _pushing(batch: int) -> Step:
    observation, _ = gym.make("aicon/PushT-v0").reset(seed=0)
    readings = {key: torch.as_tensor(value).expand(batch, -1) for key, value in observation.items()}
    return _stepper(make_policy("pusht"), readings)


def _by_hand(batch: int, closed_form: bool) -> Step:
    bearing = torch.zeros(batch, 1, dtype=torch.float64)
    clearance = torch.full((batch, 1), 0.15, dtype=torch.float64)
    state = plain_navigation.begin(bearing, clearance)

    def step() -> None:
        nonlocal state
        state = plain_navigation.step(state, bearing, clearance, closed_form)

    return step


def _ladder(rungs: int) -> Policy:
    estimators = [Deterministic("u0", Interconnection(torch.sin, ["a"])), Deterministic("v0", Interconnection(torch.cos, ["a"]))]
    for rung in range(1, rungs):
        below = (f"u{rung - 1}", f"v{rung - 1}")
        estimators += [Deterministic(f"{side}{rung}", Interconnection(_blend, below)) for side in "uv"]
    goal = Goal("rest", Interconnection(_distance, [f"u{rungs - 1}", f"v{rungs - 1}"]))
    actuators, sensors = {"a": Actuator(2, "m/s", limit=1.0)}, {"z": Sensor(1, "m")}
    model = WorldModel(sensors=sensors, actuators=actuators, estimators=estimators, goals=[goal])
    return Policy(model, Sum(), ActionLaw(gain=1.0))


def _blend(u: Tensor, v: Tensor) -> Tensor:
    return torch.sin(u + v)


def _distance(u: Tensor, v: Tensor) -> Tensor:
    return cast(Tensor, torch.linalg.vector_norm(u - v, dim=-1))


def _stepper(policy: Policy, observation: dict[str, Tensor]) -> Step:
    memory = policy.predict(observation)[1]

    def step() -> None:
        nonlocal memory
        _, memory = policy.predict(observation, memory)

    return step


if __name__ == "__main__":
    main()
