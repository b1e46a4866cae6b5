"""An arm in clutter: MotionBenchMaker's problems, by a policy that knows no plan.

Example: python scripts/clutter.py panda --indices 51 100 --out runs/clutter
"""

import argparse
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.errors import check_known
from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.statistics import group_rows
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.worlds.motion_bench_maker import (
    MOST_OBJECTS,
    ROBOTS,
    SPEED,
    Problem,
    problems,
    resources,
    robot_of,
)
from aicon_torch import ExportedPolicy, Policy, Rehearsal
from aicon_torch.dampers import PlaceEscape
from aicon_torch.models import make_policy
from aicon_torch.parts import Robot, Solid, TipPose, reading_of
from aicon_torch.ways import OtherPlaces
from study_table import fill_in_groups, read

RANDOM_PLACES = PlaceEscape(patience=1.2, remembers=False, seeks=False)
"""The most trivial escape."""

POLICIES: dict[str, dict[str, Any]] = {
    "aicon": {},
    "rehearsed": {"dampers.haste": 2.0},
    "random_places": {"dampers.escape": RANDOM_PLACES, "advances_within": None},
    "without_escape": {"dampers.escape": None, "advances_within": None},
}
"""What differs from the preset "clutter". What is rehearsed may go askew: it is tried before."""

REHEARSED = "rehearsed"
"""This one tries on its own model first: see aicon_torch.Rehearsal."""

ESCAPES = "a/escape/escapes"
"""Under which the memory has how often it went elsewhere."""

PLACES, AHEAD, ROUNDS = 31, 4.5, 6
"""It looks 4.5 s ahead, at 32 ways at a time, and up to six times for one that arrives."""

CACHE = Path.home() / ".cache" / "aicon"
"""Where what is downloaded is kept."""

DT, HORIZON = 0.02, 60.0
NEAR, STRAIGHT = 0.010, 0.05
"""Success: m and rad of the tip."""

SIDE_BY_SIDE = 300
"""Robots whose steps are timed together."""

TIMES = (5, 10, 20, 40, 60)
PARTS, CLOSE = 4, 0.03
"""A step is looked at in so many parts where an object is so close, m."""

AT_ONCE = 200
"""So many steps are looked at at once."""

Array = NDArray[np.float64]


class Row(NamedTuple):
    """What became of a problem; distances are the least of the whole episode."""

    robot: str
    policy: str
    set: str
    number: int
    time: float  # s, with what it thought; NaN where it did not arrive
    thought: float  # s of computing
    clearance: float  # of spheres and objects, m
    self_gap: float  # of the robot to itself, m
    stop_gap: float  # of a joint to its stop, rad
    missing: float  # distance at the end, m
    angle: float  # rad
    escapes: int

    @property
    def is_solved(self) -> bool:
        """Whether it arrived."""
        return self.time <= HORIZON


class World:
    """A robot as spheres among objects, its joints moving at the velocities commanded.

    Args:
        robot: The robot.
        problem: The problem.
    """

    def __init__(self, robot: Robot, problem: Problem) -> None:
        assert robot.shape is not None
        capsules, self.chain = robot.shape.capsules, robot.chain
        self.links = [capsule.link for capsule in capsules]
        self.points = np.array([(*capsule.start, 1.0) for capsule in capsules])
        self.radii = np.array([capsule.radius for capsule in capsules])
        self.moving = np.array(self.links) > 0
        self.pairs = np.array(robot.shape.pairs)
        self.low, self.high = robot.chain.low.numpy(), robot.chain.high.numpy()
        boxes = [each for each in problem.solids if each.kind == "box"]
        cylinders = [each for each in problem.solids if each.kind == "cylinder"]
        self.objects = [(kind, *_frames(kind)) for kind in (boxes, cylinders) if kind]

    def centres(self, q: Array) -> Array:
        """Where the spheres are at joint angles ``(k, n)``, ``(k, spheres, 3)``, m."""
        frames = self.chain.frames(torch.from_numpy(q)).numpy()
        base = np.broadcast_to(np.eye(4), (len(q), 1, 4, 4))
        of_links = np.concatenate((base, frames), axis=1)[:, self.links]
        centres: Array = np.einsum("kmij,mj->kmi", of_links[..., :3, :], self.points)
        return centres

    def gaps(self, q: Array) -> tuple[Array, Array]:
        """The least distance to an object and to itself at joint angles ``(k, n)``, m."""
        centres = self.centres(q)
        first, second = self.pairs.T
        apart = np.linalg.norm(centres[:, first] - centres[:, second], axis=-1)
        of_itself = (apart - self.radii[first] - self.radii[second]).min(-1)
        return self.gaps_of(centres[:, self.moving], self.radii[self.moving]), of_itself

    def gaps_of(self, points: Array, radii: Array | float = 0.0) -> Array:
        """The least distance of points ``(k, m, 3)``, or of spheres, to an object, ``(k,)``, m."""
        least = np.full(len(points), math.inf)
        for solids, middles, rotations in self.objects:
            local = (points[:, None] - middles[:, None]) @ rotations
            distances = distances_to(solids, local) - radii
            least = np.minimum(least, distances.min((-1, -2)))
        return least

    def least_gaps(self, way: Array) -> tuple[float, float]:
        """The least distance to an object and to itself on a way ``(k, n)``, m."""
        least = [math.inf, math.inf]
        for first in range(0, len(way), AT_ONCE):
            here, after = way[first : first + AT_ONCE], way[first + 1 : first + 1 + AT_ONCE]
            found = [self.gaps(here)]

            # Where an object is close, also between the steps.
            close = np.flatnonzero(found[0][0][: len(after)] < CLOSE)
            for share in np.arange(1, PARTS) / PARTS if len(close) else ():
                found.append(self.gaps(here[close] + share * (after[close] - here[close])))
            for gaps in found:
                least = [min(old, float(new.min())) for old, new in zip(least, gaps, strict=True)]
        return least[0], least[1]


def _frames(solids: Sequence[Solid]) -> tuple[Array, Array]:
    """Where objects are, and how they are turned."""
    turned = Rotation.from_quat([solid.orientation for solid in solids], scalar_first=True)
    return np.array([solid.position for solid in solids]), turned.as_matrix()


def distances_to(solids: Sequence[Solid], points: Array) -> Array:
    """The exact signed distances of points ``(k, objects, m, 3)`` in the frames of objects, m."""
    sizes = np.array([solid.size for solid in solids])[:, None]
    if solids[0].kind == "box":
        beyond = np.abs(points) - sizes / 2
    else:
        across = np.hypot(points[..., 0], points[..., 1]) - sizes[..., 1]
        beyond = np.stack((across, np.abs(points[..., 2]) - sizes[..., 0] / 2), axis=-1)
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    signed: Array = outside + np.minimum(beyond.max(-1), 0.0)
    return signed


@dataclass
class Episode:
    """What became of a problem so far.

    Attributes:
        way: The joints after every step, rad.
        thought: How long the robot has stood and thought, s.
        time: When it arrived, s; NaN where it has not.
        missing: The distance of the tip from its target, m.
        angle: And its angle, rad.
        escapes: How often it went elsewhere.
    """

    way: list[Array] = field(default_factory=list)
    thought: float = 0.0
    time: float = math.nan
    missing: float = math.inf
    angle: float = math.inf
    escapes: int = 0

    def row(self, name: str, robot: Robot, problem: Problem) -> Row:
        """What is known of it, and what its way touched."""
        way = np.array(self.way)
        world = World(robot, problem)
        to_stop = float(np.minimum(way - world.low, world.high - way).min())
        distances = (*world.least_gaps(way), to_stop, self.missing, self.angle)
        own = (problem.robot, name, problem.set, problem.index)
        return Row(*own, self.time, self.thought, *distances, self.escapes)


class Surroundings:
    """Objects that stay where they are; its rows are the problems still running."""

    def after(self, seen: Mapping[str, Tensor], q: Tensor) -> dict[str, Tensor]:
        """What is seen after a step to other joints ``(k, n)``, of what was seen before it."""
        return {**seen, "q": q}

    def keep(self, going: Tensor) -> None:
        """Drop the rows that have arrived."""


def episodes(
    policy: Any,
    robot: Robot,
    chosen: Sequence[Problem],
    surroundings: Surroundings | None = None,
    most_objects: int = MOST_OBJECTS,
    horizon: float = HORIZON,
) -> list[Episode]:
    """Some problems side by side, until each tip is where it is to be.

    What a step takes a robot beyond 20 ms counts into its time: so long it stands and thinks.
    """
    surroundings = surroundings or Surroundings()
    pose = TipPose("full", lever=1.0)
    goals = torch.from_numpy(np.stack([problem.goal for problem in chosen]))
    target = pose.of_frame(robot.chain(goals))
    found = [Episode() for _ in chosen]
    running, memory = list(found), None

    each = [sees(robot, problem, most_objects) for problem in chosen]
    seen = {name: torch.from_numpy(np.stack([one[name] for one in each])) for name in each[0]}
    for step in range(round(horizon / DT) + 1):
        x_ee = pose.of_frame(robot.chain(seen["q"]))
        missing, angle = pose.distance(x_ee, target)
        here = zip(running, seen["q"].numpy(), missing.tolist(), angle.tolist(), strict=True)
        for episode, q, *left in here:
            episode.way.append(q)
            episode.missing, episode.angle = left

        # Those that have arrived leave.
        going = (missing >= NEAR) | (angle >= STRAIGHT)
        for number in torch.nonzero(~going).flatten().tolist():
            running[number].time = step * DT + running[number].thought
        running = [episode for episode in running if math.isnan(episode.time)]
        if not running:
            break
        if not going.all():
            target, seen = target[going], rows_of(seen, going)
            surroundings.keep(going)
            memory = None if memory is None else rows_of(memory, going)

        before = time.process_time()
        action, memory = policy.predict(seen, memory)
        took = (time.process_time() - before) / len(running)
        seen = surroundings.after(seen, seen["q"] + DT * action)
        for number, episode in enumerate(running):
            episode.thought += max(0.0, took - DT)
            if ESCAPES in memory:
                episode.escapes = int(memory[ESCAPES][number])
    return found


def rows_of(values: Mapping[str, Tensor], which: Tensor) -> dict[str, Tensor]:
    """Some rows of a batch."""
    return {name: value[which] for name, value in values.items()}


def policy_of(robot_name: str, robot: Robot, name: str, most_objects: int = MOST_OBJECTS) -> Policy:
    """One of the policies, of a robot with its name."""
    target = {"orientation": "full", "axis": ROBOTS[robot_name].axis}
    own = {"robot": robot, "speed": SPEED, "dt": DT, **target, **POLICIES[name]}
    return make_policy("reach", preset="clutter", obstacles=most_objects, **own)


def agent(name: str, robot: Robot, problem: Problem, most_objects: int = MOST_OBJECTS) -> Any:
    """One of the policies, compiled before the first step that counts; says how long one takes."""
    policy = policy_of(problem.robot, robot, name, most_objects).compile()
    print(f"{name}: {time_of_a_step(policy, robot, problem, most_objects):.0f} µs a step")
    return rehearsed(policy) if name == REHEARSED else policy


def rehearsed(policy: Policy) -> Rehearsal:
    """The policy, rehearsed on its own kinematics, among the objects as they are seen."""

    def imagine(seen: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
        return {**seen, "q": seen["q"] + DT * memory["a"]}

    def to_go(memory: Mapping[str, Tensor]) -> Tensor:
        away = memory["x_target"] - memory["x_ee"]  # 20 cm for 1 rad
        distance: Tensor = torch.linalg.vector_norm(away, dim=-1)
        return distance

    ways, steps = OtherPlaces(policy, PLACES), round(AHEAD / DT)
    return Rehearsal(policy, imagine, to_go, NEAR, steps, ways, ROUNDS)


def time_of_a_step(
    policy: Policy | ExportedPolicy,
    robot: Robot,
    problem: Problem,
    most_objects: int = MOST_OBJECTS,
) -> float:
    """The processor time of a step in C, µs: the least of ten, each of many robots side by side."""
    of_one = sees(robot, problem, most_objects)
    seen = {name: np.repeat(value[None], SIDE_BY_SIDE, 0) for name, value in of_one.items()}
    memory: Any = None
    _, memory = policy.predict(seen, memory)
    times = []
    for _ in range(10):
        before = time.process_time()
        _, memory = policy.predict(seen, memory)
        times.append(time.process_time() - before)
    return 1e6 * min(times) / SIDE_BY_SIDE


def sees(robot: Robot, problem: Problem, most_objects: int = MOST_OBJECTS) -> dict[str, Array]:
    """What the policy observes at the start."""
    tip = robot.chain(torch.from_numpy(problem.goal)).numpy()
    return {
        "q": problem.start,
        "target_position": tip[:3, 3],
        "target_orientation": Rotation.from_matrix(tip[:3, :3]).as_quat(scalar_first=True),
        "obstacles": reading_of(problem.solids, most_objects).numpy(),
    }


def is_valid(robot: Robot, problem: Problem) -> bool:
    """Whether start and goal are free of objects and of the robot itself."""
    both = np.stack((problem.start, problem.goal))
    return float(np.min(World(robot, problem).gaps(both))) > 0.0


def chosen_problems(
    arguments: argparse.Namespace,
) -> tuple[Robot, dict[tuple[str, int], Problem]]:
    """The robot, and by set and number the problems asked for whose start and goal are free."""
    folder = resources(CACHE)
    robot = robot_of(arguments.robot, folder)
    sets = arguments.sets or ROBOTS[arguments.robot].sets
    for name in sets:
        check_known("set", name, ROBOTS[arguments.robot].sets)
    low, high = arguments.indices
    numbers = range(low, high + 1)
    given = problems(arguments.robot, folder, robot.chain.names, sets, numbers)
    return robot, {(each.set, each.index): each for each in given if is_valid(robot, each)}


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    robot, chosen = chosen_problems(arguments)
    table = arguments.out / f"{arguments.robot}.csv"

    @cache
    def agent_of(name: str) -> Any:
        return agent(name, robot, next(iter(chosen.values())))

    def measure(group: Sequence[tuple[Any, ...]]) -> list[Row]:
        name = group[0][1]
        some = [chosen[begin[2:]] for begin in group]
        found = episodes(agent_of(name), robot, some)
        both = zip(some, found, strict=True)
        return [episode.row(name, robot, problem) for problem, episode in both]

    for name in arguments.agents:
        wanted = [(arguments.robot, name, *key) for key in chosen]
        report(name, fill_in_groups(table, Row, wanted, measure, group_size(name), name))
    draw(table, [row for row in read(table, Row) if (row.set, row.number) in chosen])


def group_size(name: str) -> int:
    """How many robots there are side by side; one that thinks is alone: its time is its own."""
    return SIDE_BY_SIDE if name in POLICIES and name != REHEARSED else 1


def report(name: str, rows: Sequence[Row]) -> None:
    """Successes within some times, in all and in each set, and what was touched."""
    if not rows:
        return

    print(f"\n{name}: {len(rows)} problems")
    lines = []
    for set_name, own in group_rows(rows, attrgetter("set")).items():
        lines.append([set_name, str(len(own)), *map(str, counts_of(own))])
    shares = [share_of(count, len(rows)) for count in counts_of(rows)]
    lines.append(["all, %", str(len(rows)), *shares])
    print(to_markdown(["set", "of", *(f"{limit} s" for limit in TIMES)], lines))

    touching = [
        f"{r.set} {r.number} ({-1e3 * r.clearance:.1f} mm)" for r in rows if r.clearance < 0
    ]
    print(f"penetrations: {len(touching)} {', '.join(touching)}")
    print(f"least gap to itself: {1e3 * min(r.self_gap for r in rows):.1f} mm")
    print(f"least distance to a stop: {min(r.stop_gap for r in rows):.3f} rad")
    failed = [f"{row.set} {row.number}" for row in rows if not row.is_solved]
    print(f"failed: {', '.join(failed)}")


def counts_of(rows: Sequence[Row]) -> list[int]:
    """How many arrived within each of the times."""
    return [sum(row.time <= limit for row in rows) for limit in TIMES]


def share_of(count: int, total: int) -> str:
    """A share in %, with an interval (95 %, Wilson)."""
    low, high = wilson_interval(count, total)
    return f"{100 * count / total:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def draw(table: Path, rows: Sequence[Any], horizon: float = HORIZON) -> None:
    """The share that is solved over time, by policy, as a picture beside a table."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    draw_shares(axes, rows, horizon)
    axes.set_ylabel("solved, %")
    axes.legend(loc="lower right", frameon=False)
    figure.savefig(table.with_suffix(".png"), dpi=150)


def draw_shares(axes: Any, rows: Sequence[Any], horizon: float) -> None:
    """The share that is solved over time, a curve for each policy of rows that tell it."""
    for name, own in group_rows(rows, attrgetter("policy")).items():
        times = np.sort([row.time for row in own if row.is_solved])
        shares = 100 * np.arange(len(times) + 1) / len(own)
        axes.step([0.0, *times, horizon], [*shares, shares[-1]], where="post", label=name)
    axes.set(xlim=(0, horizon), ylim=(0, 100), xlabel="time, s")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_problems(parser, Path("runs/clutter"))
    parser.add_argument("--agents", nargs="+", choices=POLICIES, default=["aicon"])


def add_problems(parser: argparse.ArgumentParser, out: Path) -> None:
    """Declare whose problems are run, which of them, and where results are kept."""
    parser.add_argument("robot", choices=ROBOTS, help="whose problems")
    sets = dict.fromkeys(name for robot in ROBOTS.values() for name in robot.sets)
    parser.add_argument("--sets", nargs="+", choices=sets, help="which (default: all of the robot)")
    parser.add_argument(
        "--indices",
        nargs=2,
        type=int,
        default=(51, 100),
        metavar=("FIRST", "LAST"),
        help="of each set: 1 to 50 are for tuning, 51 to 100 for the report (default: 51 100)",
    )
    add_option(parser, "--out", out, "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
