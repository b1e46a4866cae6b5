"""What a shield is worth: policies of others with nothing, a clamp, bounds alone, and a shield.

Example: python scripts/shield.py nav2d --episodes 100 --seed 300000 --out runs/shield
"""

import argparse
import math
import time
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.agents.registry import diffusion_policy, saved_agent
from aicon_baselines.agents.shields import arm, nav2d, pusht
from aicon_baselines.agents.shields.clamped import shortened
from aicon_baselines.agents.shields.world import World, guards, seeded
from aicon_baselines.agents.shipped import shipped_folder
from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.episodes import Step, run_episodes
from aicon_baselines.evaluation.errors import ComparisonError, check_known
from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.named import find
from aicon_baselines.palette import OBSTACLE, ROBOT, TARGET
from aicon_baselines.tasks import load
from aicon_envs.nav2d import Physics, make_map
from aicon_torch import load_exported
from aicon_torch.errors import choices
from study_table import fill


class Heard:
    """A policy that remembers what it proposed last."""

    def __init__(self, policy: Predictor) -> None:
        self.policy, self.proposal = policy, np.zeros(2)

    def predict(self, *arguments: Any, **named: Any) -> tuple[Any, Any]:
        """Propose, and remember it."""
        self.proposal, state = self.policy.predict(*arguments, **named)
        return self.proposal, state


def navigation() -> World:
    """Who goes straight, and PPO, among walls."""
    ppo = saved_agent("nav2d", shipped_folder("sb3", "nav2d"))[1]
    proposers = {"straight": nav2d.Straight, "PPO": lambda: ppo("range")}
    return World(
        proposers,
        guards(nav2d.clamped, nav2d.shielded),
        _navigation,
        time_step=0.05,
        still=(600, 0.5),
        longest=Physics().max_speed,
        ends_at_touch=True,
    )


def pushing(is_moving: bool = False) -> World:
    """PPO and LeRobot's student, with a region in the way, or one that moves."""
    ppo = saved_agent("pusht", shipped_folder("sb3", "pusht"), sampled=True)[1]
    student = diffusion_policy("pusht", str(shipped_folder("diffusion", "pusht")))[1]
    proposers = {
        "PPO": lambda: ppo("deterministic"),
        "student": lambda: student("deterministic"),
    }
    start = seeded(lambda count: pusht.make_env(count, 1000, is_moving))
    guarded = guards(pusht.clamped, pusht.shielded)
    return World(proposers, guarded, start, time_step=0.1, still=(50, 20.0))


def posing(is_moving: bool = False) -> World:
    """An arm whose joints go straight, with a ball in the way, or several that move."""
    start = seeded(lambda count: arm.make_env(count, 1000, is_moving))
    shielded = partial(arm.shielded, balls=arm.MOVING) if is_moving else arm.shielded
    guarded = guards(arm.clamped, shielded)
    return World(
        {"straight": arm.Straight}, guarded, start, time_step=0.02, still=(100, 0.1), at_once=25
    )


WORLDS: dict[str, Callable[[], World]] = {
    "nav2d": navigation,
    "pusht": pushing,
    "pusht_moving": partial(pushing, is_moving=True),
    "arm": posing,
    "arm_moving": partial(posing, is_moving=True),
}
"""The tasks, by name; each loads its own policies."""


def _world(name: str) -> World:
    """A world of ours by its name, or MODULE:WORLD of somebody else."""
    if name in WORLDS:
        return WORLDS[name]()
    if ":" not in name:
        whole = choices((*WORLDS, "random", "time", "draw"))
        raise ComparisonError(f"{name!r}: expected {whole} or MODULE:WORLD.")
    world: World = find(name)()
    return world


def _navigation(first: int, count: int) -> tuple[Any, Any]:
    task = load("nav2d")
    episodes = [task.episode(seed) for seed in range(first, first + count)]
    env = task.make_env(count, "range", task.horizon)
    return env, env.reset(**task.reset_arguments(episodes))


class Outcome(NamedTuple):
    """What became of some episodes side by side, each of which ends at a success.

    Attributes:
        success: Which succeeded, ``(B,)``.
        touched: In which something was touched, ``(B,)``.
        stuck: Which stayed where they were, ``(B,)``.
        duration: How many steps each took, ``(B,)``.
        change: By how much the guard changed all actions together.
        steps: How many steps there were.
    """

    success: Any
    touched: Any
    stuck: Any
    duration: Any
    change: float
    steps: int


class Row(NamedTuple):
    """What became of all episodes of a policy under a guard.

    Attributes:
        success: How many succeeded.
        clean: How many of these touched nothing.
        touched: In how many something was touched.
        stuck: How many stayed where they were.
        steps: How many steps a success took, at the median; NaN without any.
        change: By how much the guard changed an action, at the mean.
        failed: The seeds of those that were not clean.
    """

    seed: int
    episodes: int
    horizon: int
    policy: str
    guard: str
    success: int
    clean: int
    touched: int
    stuck: int
    steps: float
    change: float
    failed: str


def compare(task: str, out: Path, first: int, count: int, horizon: int, only: list[str]) -> None:
    """Run every policy with every guard, and print a row of the table each."""
    world = _world(task)
    for name in only:
        check_known("proposer", name, world.proposers)

    def measure(seed: int, episodes: int, horizon: int, proposer: str, guard: str) -> list[Row]:
        heard = Heard(world.proposers[proposer]())
        policy = world.guards[guard](heard)  # compiled once for all episodes

        outcomes = []
        for begin in range(seed, seed + episodes, world.at_once):
            number = min(world.at_once, seed + episodes - begin)
            env, start = world.start(begin, number)
            outcomes.append(outcome_of(world, run_episodes(policy, env, start), heard, horizon))
            env.close()
        return [Row(seed, episodes, horizon, proposer, guard, **summary(outcomes, seed))]

    settings = product([first], [count], [horizon], only or world.proposers, world.guards)
    table = out / f"{task.replace(':', '.')}.csv"
    for row in fill(table, Row, list(settings), measure, task):
        print(_in_words(row, world.time_step))


def outcome_of(world: World, steps: Iterator[Step], heard: Heard, horizon: int) -> Outcome:
    """Run some episodes, until the horizon at the latest."""
    success, touched, change = False, False, 0.0
    running: list[NDArray[Any]] = []
    places: list[NDArray[Any]] = []
    for step in islice(steps, horizon):
        on = step.running
        proposal = shortened(heard.proposal, world.longest)
        difference = shortened(step.action, world.longest) - proposal
        change += float(np.linalg.norm(difference, axis=-1)[on].sum())
        touched |= on & np.asarray(step.info["collision"], bool)
        success |= on & np.asarray(step.info["is_success"], bool)
        running.append(on)
        places.append(np.asarray(step.info["position"], float))

    still, near = world.still
    spread = np.ptp(np.stack(places)[-still:], axis=0).max(-1)
    failed = ~success & ~(touched & world.ends_at_touch)
    stuck = failed & (spread < near)
    duration = np.sum(running, axis=0)
    return Outcome(success, touched, stuck, duration, change, int(duration.sum()))


def summary(outcomes: list[Outcome], first: int) -> dict[str, Any]:
    """What became of all episodes, of which some were run side by side."""
    *of_each, changes, steps = zip(*outcomes, strict=True)
    success, touched, stuck, duration = (np.concatenate(parts) for parts in of_each)
    clean = success & ~touched

    return {
        "success": int(success.sum()),
        "clean": int(clean.sum()),
        "touched": int(touched.sum()),
        "stuck": int(stuck.sum()),
        "steps": float(np.median(duration[success])) if success.any() else math.nan,
        "change": sum(changes) / max(sum(steps), 1),
        "failed": " ".join(map(str, first + np.flatnonzero(~clean))),
    }


def _in_words(row: Row, time_step: float) -> str:
    low, high = (100 * bound for bound in wilson_interval(row.clean, row.episodes))
    seconds = "-" if math.isnan(row.steps) else f"{row.steps * time_step:.0f} s"
    return (
        f"| {row.policy} | {row.guard} | {row.touched} | {row.clean} "
        f"({low:.1f} to {high:.1f} %) | {row.stuck} | {seconds} | {row.change:.3g} |"
    )


def wander(first: int, count: int, horizon: int) -> None:
    """Random policies in navigation, until so many steps were taken."""
    total, touched, least = 0, 0, np.inf
    for hold in (1.0, 10.0, 40.0, 200.0):
        env, start = _navigation(first, count)
        shield = nav2d.shielded(nav2d.Wandering(hold, seed=int(hold)))
        for step in islice(run_episodes(shield, env, start), horizon):
            on = step.running
            total += int(on.sum())
            touched += int((on & step.info["collision"]).sum())
            if "clearance" in step.info:
                least = min(least, float(step.info["clearance"][on].min()))
    print(f"nav2d: {total} steps, {touched} collisions, least clearance {least:.3f} m")


def timed(out: Path, count: int) -> None:
    """How long a step of an exported shield takes, µs of the processor, Python's call included."""
    generator = np.random.default_rng(0)
    for name, module, seen in (
        ("nav2d", nav2d, {"range": 1, "proposal": 2}),
        ("pusht", pusht, {"agent_pos": 2, "region": 2, "proposal": 2}),
    ):
        module.shielded(lambda observation: 0).export(out / f"{name}.so")

        shield = load_exported(out / f"{name}.so")
        reading = {key: generator.random(size) for key, size in seen.items()}
        _, memory = shield.predict(reading)  # the first begins an episode, and allocates

        taken = []
        for _ in range(count):
            before = time.thread_time_ns()
            _, memory = shield.predict(reading, memory)
            taken.append((time.thread_time_ns() - before) / 1e3)
        median, tail = np.percentile(taken, (50, 99.9))
        print(f"{name}: median {median:.1f}, 99.9 % {tail:.1f}, largest {max(taken):.1f} µs")


def draw(out: Path, seed: int, horizon: int) -> None:
    """One map, and the ways under each guard, as shield.png."""
    import matplotlib.pyplot as plt

    world, task = navigation(), load("nav2d")
    episode = task.episode(seed)
    _, obstacles, begin, target = make_map(episode.map, np.random.default_rng(seed))
    figure, axes = plt.subplots(1, 4, figsize=(12, 3.4), sharex=True, sharey=True)
    for axis, (name, guard) in zip(axes, world.guards.items(), strict=True):
        env, start = world.start(seed, 1)
        steps = run_episodes(guard(nav2d.Straight()), env, start)
        way = np.array([begin] + [step.info["position"][0] for step in islice(steps, horizon)])
        for obstacle in obstacles:
            axis.fill(*np.asarray(obstacle).T, color=OBSTACLE)
        axis.plot(*way.T, color=ROBOT, linewidth=2)
        axis.plot(*target, "*", color=TARGET, markersize=14)
        axis.set(title=name, aspect="equal")
    figure.savefig(out / "shield.png", dpi=110, bbox_inches="tight")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    parser.add_argument(
        "what", help=f"{', '.join(WORLDS)}, a world of others, MODULE:WORLD, random, time or draw"
    )
    add_option(parser, "--episodes", 100, "how many", type=at_least(1))
    add_option(parser, "--seed", 300_000, "first seed", type=at_least(0))
    add_option(parser, "--horizon", 1000, "steps", type=at_least(1))
    parser.add_argument("--proposers", nargs="*", default=[], help="who proposes (default: all)")
    parser.add_argument("--out", type=Path, default=Path("runs/shield"))


def run(asked: argparse.Namespace) -> None:
    """Run what is asked for."""
    torch.set_num_threads(1)
    asked.out.mkdir(parents=True, exist_ok=True)
    if asked.what == "random":
        wander(asked.seed, asked.episodes, asked.horizon)
    elif asked.what == "time":
        timed(asked.out, asked.horizon)
    elif asked.what == "draw":
        draw(asked.out, asked.seed, asked.horizon)
    else:
        compare(asked.what, asked.out, asked.seed, asked.episodes, asked.horizon, asked.proposers)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
