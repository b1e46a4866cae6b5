"""Time a control step on one thread: the library beside the same law by hand in plain torch.

Example: python scripts/benchmark.py --out runs/benchmark

Navigation is held against the hand-written law, pushT against navigation, a graph whose paths
double with every rung against its number of edges, and our pushT environment against gym-pusht. The
programs take turns, and what is measured is the processor time of this process, so that a busy
machine slows all of them alike; what counts is the ratio and its spread.
"""

import argparse
import json
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, run_command

# isort: split

import gymnasium as gym
import numpy as np
import torch
from torch import Tensor

import aicon_envs  # noqa: F401  # registers the environments
import ladder
import plain_navigation
from aicon_baselines.evaluation.timing import Step, ratios, replay, spread, take_turns
from aicon_torch import make_policy
from aicon_torch.control import DirectDescent

PUSHT, GYM_PUSHT = "aicon/PushT-v0", "gym_pusht:gym_pusht/PushT-v0"
RUNGS = (4, 8, 16, 32, 64)

BOUNDS = {
    "library, batch 1 / by hand, autograd along each path, batch 1": 1.5,
    "library, batch 256 / library, batch 1": 3.0,
    "pushT, batch 1 / navigation, batch 1": 2.0,
    "pushT, batch 256 / pushT, batch 1": 5.0,
}
"""The largest median that each ratio may have with ``--check``."""

Measured = dict[str, dict[str, list[float]]]
"""Seconds per step of programs, "times", and "ratios" of some of them, round by round."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how long to measure, and what."""
    parser.add_argument(
        "--rounds", type=int, default=60, help="rounds in which programs take turns (default: 60)"
    )
    parser.add_argument(
        "--steps", type=int, default=20, help="steps of each program in a round (default: 20)"
    )
    parser.add_argument("--out", type=Path, help="folder for benchmark.json")
    parser.add_argument("--check", action="store_true", help="fail if a median misses its bound")
    parser.add_argument(
        "--peers", action="store_true", help="time the tools of others beside ours instead"
    )


def run(arguments: argparse.Namespace) -> None:
    """Measure, print and save."""
    torch.set_num_threads(1)
    rounds, steps = arguments.rounds, arguments.steps
    if arguments.peers:
        import benchmark_peers  # what it needs is optional

        benchmark_peers.compare(rounds, steps, arguments.out)
        return

    results = {
        "navigation": navigation(rounds, steps),
        "pusht": pushing(rounds, steps),
        "ladder": ladders(rounds, steps),
        "environment": environment(gym.make("aicon/Nav2D-v0", map="clutter"), rounds),
        "pusht_env": pushing_environments(rounds),
    }

    print_results(results)
    if arguments.out:
        save(results, arguments.out)
    if arguments.check:
        check_bounds(results)


def navigation(rounds: int, steps: int) -> Measured:
    """The library's navigation step and the hand-written one, at batch 1 and 256."""
    programs: dict[str, Step] = {}
    for batch in (1, 256):
        autograd = f"by hand, autograd along each path, batch {batch}"
        closed_form = f"by hand, all in closed form, batch {batch}"

        programs[f"library, batch {batch}"] = _navigation_step(batch)
        programs[autograd] = _plain_navigation_step(batch, closed_form=False)
        programs[closed_form] = _plain_navigation_step(batch, closed_form=True)

    pairs = (
        ("library, batch 1", "by hand, autograd along each path, batch 1"),
        ("library, batch 1", "by hand, all in closed form, batch 1"),
        ("library, batch 256", "library, batch 1"),
    )
    return _with_ratios(take_turns(programs, rounds, steps, "navigation"), pairs)


def pushing(rounds: int, steps: int) -> Measured:
    """The step of pushT at batch 1 and 256, beside that of navigation."""
    programs = {
        "navigation, batch 1": _navigation_step(1),
        "pushT, batch 1": _pushing_step(1),
        "pushT, batch 256": _pushing_step(256),
    }
    pairs = (
        ("pushT, batch 1", "navigation, batch 1"),
        ("pushT, batch 256", "pushT, batch 1"),
    )
    return _with_ratios(take_turns(programs, rounds, steps, "pushT"), pairs)


def ladders(rounds: int, steps: int) -> list[dict[str, Any]]:
    """Steps of graphs in which every rung reads both sides of the one below it."""
    policies = {str(rungs): ladder.build(rungs) for rungs in RUNGS}
    programs = {name: replay(policy, [ladder.READING]) for name, policy in policies.items()}
    times = take_turns(programs, max(1, rounds // 6), max(1, steps // 4), "ladder")

    rows = []
    for name, policy in policies.items():
        edges = sum(len(edges) for edges in policy.model.edges.values())
        paths = policy.model.paths().count()
        row = {"rungs": int(name), "edges": edges, "paths": paths, "times": times[name]}
        rows.append(row)
    return rows


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
    """Steps per second of aicon/PushT-v0 and of gym-pusht's, in turns, and their ratio."""
    observed = "environment_state_agent_pos"
    envs = {name: gym.make(name, obs_type=observed) for name in (PUSHT, GYM_PUSHT)}

    speeds: dict[str, list[float]] = {name: [] for name in envs}
    for _ in range(rounds):
        for name, env in envs.items():
            speeds[name] += environment(env, rounds=1)
    return {"speeds": speeds, "ratio": ratios(speeds[PUSHT], speeds[GYM_PUSHT])}


def print_results(results: dict[str, Any]) -> None:
    """Print medians and spreads."""
    for title in ("navigation", "pusht"):
        print(f"\none step of {title}, one thread, ms: median (5 % to 95 %)")
        for name, times in results[title]["times"].items():
            print(f"  {name:44} {spread(times, 1e3)}")
        print("ratios, taken round by round")
        for name, values in results[title]["ratios"].items():
            print(f"  {name:44} {spread(values)}")

    print("a ladder whose paths double with every rung")
    for row in results["ladder"]:
        size = f"{row['rungs']:3} rungs, {row['edges']:4} edges, {row['paths']:.2g} paths"
        print(f"  {size}: {spread(row['times'], 1e6 / row['edges'])} µs an edge")

    print(f"aicon/Nav2D-v0 alone: {spread(results['environment'])} steps/s")
    for name, speeds in results["pusht_env"]["speeds"].items():
        print(f"{name} alone: {spread(speeds)} steps/s")
    print(f"  ratio, round by round: {spread(results['pusht_env']['ratio'])}")


def save(results: dict[str, Any], out: Path) -> None:
    """Write benchmark.json."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / "benchmark.json"
    path.write_text(json.dumps(results, indent=2) + "\n")
    print(f"\nsaved in {path}")


def check_bounds(results: dict[str, Any]) -> None:
    """End the script with status 1, and say which, if medians miss their bounds."""
    measured = results["navigation"]["ratios"] | results["pusht"]["ratios"]
    missed = []
    for name, bound in BOUNDS.items():
        median = statistics.median(measured[name])
        if median > bound:
            missed.append(f"{name}: {median:.3g} > {bound}")

    if statistics.median(results["pusht_env"]["ratio"]) < 1:
        missed.append(f"{PUSHT} is slower than upstream's environment")
    if missed:
        sys.exit("\n".join(missed))


def _with_ratios(times: dict[str, list[float]], pairs: tuple[tuple[str, str], ...]) -> Measured:
    """Return the times with the ratios of these pairs of programs."""
    divided = {}
    for first, second in pairs:
        divided[f"{first} / {second}"] = ratios(times[first], times[second])
    return {"times": times, "ratios": divided}


def _navigation_step(batch: int) -> Step:
    bearing, clearance = torch.zeros(batch, 1), torch.full((batch, 1), 0.15)
    # The law that is written out by hand.
    law = DirectDescent(plain_navigation.GAIN, smoothing=plain_navigation.SMOOTHING)
    return replay(make_policy("nav2d", law=law), [{"bearing": bearing, "range": clearance}])


def _pushing_step(batch: int) -> Step:
    observation, _ = gym.make(PUSHT).reset(seed=0)
    readings: dict[str, Tensor] = {}
    for name, reading in observation.items():
        readings[name] = torch.as_tensor(reading).expand(batch, -1)
    policy = make_policy("pusht", law=DirectDescent())  # one gradient a step, as in navigation
    return replay(policy, [readings])


def _plain_navigation_step(batch: int, closed_form: bool) -> Step:
    bearing = torch.zeros(batch, 1, dtype=torch.float64)
    clearance = torch.full((batch, 1), 0.15, dtype=torch.float64)
    state = plain_navigation.begin(bearing, clearance)

    def step() -> None:
        nonlocal state
        state = plain_navigation.step(state, bearing, clearance, closed_form)

    return step


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
