"""An arm in clutter, and a box comes in its way: the policy beside a planner.

Example: python scripts/clutter_box.py panda --out runs/clutter_box
"""

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command
from aicon_baselines.evaluation.statistics import group_rows
from aicon_baselines.worlds.motion_bench_maker import MOST_OBJECTS, ROBOTS, Problem
from aicon_torch.parts import Robot, Solid
from clutter import (
    DT,
    REHEARSED,
    Array,
    Surroundings,
    World,
    add_problems,
    agent,
    chosen_problems,
    distances_to,
    draw_shares,
    episodes,
    group_size,
    share_of,
)
from clutter_planner import Planner
from study_table import fill_in_groups, read

CONDITIONS = ("appears", "crosses")
"""The box is there after the first step and stays, or goes to and fro from the start."""

PLANNERS = {"plan_once": False, "replan": True}
"""Whether it plans again where its way is no longer free."""

HORIZON = 20.0
SIZE = 0.15
"""Of the box, m."""

SPEED, HALFWAY = 0.15, 0.2
"""How fast it goes, m/s, and how far to each side, m."""

SHARES = (0.1, 0.8)
"""It crosses the straight way of the tip somewhere in this part."""

ROOM, KEEPS = 0.03, 0.005
"""How far it is from the robot at the start and at the goal, and stays from it as it goes, m."""

DRAWS = 300
"""So often a place for it is drawn before a problem is left out."""

PARTS = 4
"""A step is looked at in so many parts."""


@dataclass(frozen=True)
class Track:
    """Where a box goes to and fro.

    Attributes:
        box: The box in the middle.
        direction: The way it goes at first, of length one.
    """

    box: Solid
    direction: Array

    def positions(self, places: Array) -> Array:
        """The middle of the box at places along the track, ``(k, 3)``, m."""
        positions: Array = np.array(self.box.position) + places[:, None] * self.direction
        return positions

    def gap(self, centres: Array, radii: Array, places: Array) -> float:
        """The least distance of spheres ``(m, 3)`` to the box at places ``(k,)``, m."""
        local = (centres - self.positions(places)[:, None]) @ _rotation(self.box)
        return float(_gap(local, radii).min())

    def points(self, places: Array) -> Array:
        """Points all over the box at places along the track, ``(216 k, 3)``, m."""
        axis = np.linspace(-SIZE / 2, SIZE / 2, 6)
        grid = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
        points: Array = self.positions(places)[:, None] + grid @ _rotation(self.box).T
        return points.reshape(-1, 3)


class Row(NamedTuple):
    """What became of a problem; distances are the least of the whole episode."""

    robot: str
    condition: str
    policy: str
    set: str
    number: int
    time: float  # s, with what a policy thought; NaN where it did not arrive
    box_gap: float  # of the robot, as it moved, to the box as it stood, m
    clearance: float  # of the robot to all other objects, m
    self_gap: float  # of the robot to itself, m
    waited: float  # how long the box stood still, since the robot was in its way, s

    @property
    def is_solved(self) -> bool:
        """Whether it arrived, and touched nothing."""
        return self.time <= HORIZON and min(self.box_gap, self.clearance, self.self_gap) >= 0.0


class Boxes(Surroundings):
    """One box a problem; all are as large, and none is driven into a robot.

    Args:
        robot: The robot.
        tracks: Their tracks.
        cross: Whether they move.
    """

    def __init__(self, robot: Robot, tracks: Sequence[Track], cross: bool) -> None:
        self.world = World(robot, _EMPTY)
        self.radii = self.world.radii
        self.cross = cross
        self.middles = np.array([track.box.position for track in tracks])
        self.turns = np.array([_rotation(track.box) for track in tracks])
        self.directions = np.array([track.direction for track in tracks])
        self.places: Array = np.full(len(tracks), -HALFWAY if cross else 0.0)
        self.signs: Array = np.ones(len(tracks))
        self.running = np.arange(len(tracks))
        self.gaps = np.full(len(tracks), math.inf)
        self.waited = np.zeros(len(tracks))

    def gap(self, centres: Array, places: Array | None = None) -> Array:
        """The distance of spheres ``(k, spheres, 3)`` to the box of each row, ``(k,)``, m."""
        middles = self.positions(self.places if places is None else places)
        local = (centres - middles[:, None]) @ self.turns
        return _gap(local, self.radii)

    def positions(self, places: Array) -> Array:
        """The middles of the boxes, ``(k, 3)``, m."""
        positions: Array = self.middles + places[:, None] * self.directions
        return positions

    def after(self, seen: Mapping[str, Tensor], q: Tensor) -> dict[str, Tensor]:
        """The robot moves while the box stands, then the box, if it does not come too near."""
        before, after = seen["q"].numpy(), q.numpy()
        for share in np.arange(1, PARTS + 1) / PARTS:
            centres = self.world.centres(before + share * (after - before))
            gaps = self.gap(centres)
            self.gaps[self.running] = np.minimum(self.gaps[self.running], gaps)

        if self.cross:
            beyond = np.abs(self.places) >= HALFWAY
            self.signs = np.where(beyond, -np.sign(self.places), self.signs)
            moved = self.places + DT * SPEED * self.signs
            new_gaps = self.gap(centres, moved)
            stands = (new_gaps < KEEPS) & (new_gaps < gaps)
            self.places = np.where(stands, self.places, moved)
            self.waited[self.running] += DT * stands

        objects = seen["obstacles"].clone()
        objects[:, :3] = torch.from_numpy(self.positions(self.places))
        return {**seen, "q": q, "obstacles": objects}

    def keep(self, going: Tensor) -> None:
        """Drop the rows that have arrived."""
        left = going.numpy()
        for name in ("middles", "turns", "directions", "places", "signs", "running"):
            setattr(self, name, getattr(self, name)[left])


_BOX = Solid("box", (SIZE,) * 3, (0.0, 0.0, 0.0))
_EMPTY = Problem("", "", 0, np.zeros(0), np.zeros(0), ())


def _gap(local: Array, radii: Array) -> Array:
    """The least distance ``(k,)`` of spheres to a box, of their centres in its frame, m."""
    gap: Array = (distances_to([_BOX], local[:, None])[:, 0] - radii).min(-1)
    return gap


def _rotation(solid: Solid) -> Array:
    """How an object is turned."""
    return solid.numbers()[3:12].numpy().reshape(3, 3)


def track_of(robot: Robot, problem: Problem) -> Track | None:
    """A track across the straight way of the tip, free of objects; None if none is found.

    The robot has room at its goal wherever the box is, and at its start, where the box starts and
    in the middle.
    """
    number_of_set = ROBOTS[problem.robot].sets.index(problem.set)
    own = (list(ROBOTS).index(problem.robot), number_of_set, problem.index)
    generator = np.random.default_rng(own)
    ends = robot.chain(torch.from_numpy(np.stack((problem.start, problem.goal)))).numpy()
    (here, there), world = ends[:, :3, 3], World(robot, problem)
    centres = world.centres(np.stack((problem.start, problem.goal)))

    for _ in range(DRAWS):
        middle = here + generator.uniform(*SHARES) * (there - here)
        direction = generator.normal(size=3)
        direction /= np.linalg.norm(direction)
        turn = generator.uniform(-math.pi, math.pi)
        quaternion = (math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2))
        x, y, z = middle.tolist()
        box = replace(_BOX, position=(x, y, z), orientation=quaternion)
        track, places = Track(box, direction), np.array(np.linspace(-HALFWAY, HALFWAY, 17))
        at_goal = track.gap(centres[1], world.radii, places)
        at_start = track.gap(centres[0], world.radii, np.array([-HALFWAY, 0.0]))
        if min(at_goal, at_start) >= ROOM and world.gaps_of(track.points(places)[None]) > 0.0:
            return track
    return None


def with_box(problem: Problem, track: Track, cross: bool) -> Problem:
    """The problem as it is seen at first: the box comes first, and is far where it appears."""
    position = (99.0, 0.0, 0.0)
    if cross:
        x, y, z = (np.array(track.box.position) - HALFWAY * track.direction).tolist()
        position = (x, y, z)
    return replace(problem, solids=(replace(track.box, position=position), *problem.solids))


def rows_of(
    policy: Any, name: str, condition: str, robot: Robot, group: Sequence[tuple[Problem, Track]]
) -> list[Row]:
    """What becomes of some problems side by side; of a planner's one, whose computing is granted.

    Args:
        policy: It; where it is None, there is a planner of that name.
        name: Of policy or planner.
        condition: Whether the box appears or crosses.
        robot: The robot.
        group: The problems, and where their boxes go.
    """
    cross = condition == "crosses"
    boxes = Boxes(robot, [track for _, track in group], cross)
    plans = policy is None
    if plans:
        policy = planner(World(robot, group[0][0]), group[0][0], boxes, PLANNERS[name])

    seen = [with_box(problem, track, cross) for problem, track in group]
    found = episodes(policy, robot, seen, boxes, MOST_OBJECTS + 1, HORIZON)
    rows = []
    for number, ((problem, _), episode) in enumerate(zip(group, found, strict=True)):
        time = episode.time - episode.thought if plans else episode.time
        clearance, self_gap = World(robot, problem).least_gaps(np.array(episode.way))
        gaps = (float(boxes.gaps[number]), clearance, self_gap)
        own = (problem.robot, condition, name, problem.set, problem.index)
        rows.append(Row(*own, time, *gaps, float(boxes.waited[number])))
    return rows


def planner(world: World, problem: Problem, boxes: Boxes, replans: bool) -> Planner:
    """A planner, which knows nothing of a box before it appears."""
    found: Planner

    def gap(centres: Array) -> Array:
        is_unknown = found.step == 0 and not boxes.cross
        return np.full(len(centres), math.inf) if is_unknown else boxes.gap(centres)

    found = Planner(world, problem.goal, gap, replans)
    return found


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    robot, chosen = chosen_problems(arguments)
    tracks = {key: track_of(robot, problem) for key, problem in chosen.items()}
    groups = {key: (chosen[key], track) for key, track in tracks.items() if track is not None}
    table = arguments.out / f"{arguments.robot}.csv"

    @cache
    def agent_of(name: str) -> Any:
        some = next(iter(chosen.values()))
        return None if name in PLANNERS else agent(name, robot, some, MOST_OBJECTS + 1)

    def measure(group: Sequence[tuple[Any, ...]]) -> list[Row]:
        _, condition, name, *_ = group[0]
        some = [groups[begin[3:]] for begin in group]
        return rows_of(agent_of(name), name, condition, robot, some)

    for condition, name in product(arguments.conditions, arguments.agents):
        wanted = [(arguments.robot, condition, name, *key) for key in groups]
        label = f"{condition}, {name}"
        report(fill_in_groups(table, Row, wanted, measure, group_size(name), label))
    draw(table, [row for row in read(table, Row) if (row.set, row.number) in chosen])


def report(rows: Sequence[Row]) -> None:
    """Successes, in all and in each set, and what was touched."""
    if not rows:
        return

    solved = [row for row in rows if row.is_solved]
    share = share_of(len(solved), len(rows))
    touched_box = sum(row.box_gap < 0 for row in rows)
    touched = sum(min(row.clearance, row.self_gap) < 0 for row in rows)
    time = np.median([row.time for row in solved]) if solved else math.nan
    waited = np.mean([row.waited for row in rows])
    print(
        f"| {rows[0].condition} | {rows[0].policy} | {len(rows)} | {share} "
        f"| {touched_box} | {touched} | {time:.1f} s | {waited:.2f} s |"
    )

    by_set = []
    for set_name in ROBOTS[rows[0].robot].sets:
        of_set = [row.is_solved for row in rows if row.set == set_name]
        by_set.append(f"{set_name} {sum(of_set)} of {len(of_set)}")
    print("  " + ", ".join(by_set))


def draw(table: Path, rows: Sequence[Row]) -> None:
    """The share of problems that are solved over time, by policy and condition, as a picture."""
    import matplotlib.pyplot as plt

    groups = group_rows(rows, attrgetter("condition"))
    figure, every_axes = plt.subplots(
        1, len(groups), figsize=(1.8 + 3.8 * len(groups), 3.4), sharey=True, squeeze=False
    )
    for (condition, own), axes in zip(groups.items(), every_axes[0], strict=True):
        draw_shares(axes, own, HORIZON)
        axes.set_title(f"a box {condition}")
    every_axes[0, 0].set_ylabel("solved, %")
    every_axes[0, -1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    figure.tight_layout()
    figure.savefig(table.with_suffix(".png"), dpi=150)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    agents = ("aicon", REHEARSED, "random_places", "without_escape", *PLANNERS)
    add_problems(parser, Path("runs/clutter_box"))
    parser.add_argument("--agents", nargs="+", choices=agents, default=list(agents))
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS))


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
