"""Two arms that share a table, each by a policy of its own, and each in the other's way.

Example: python scripts/two_arms.py ur5 panda --seed 319000 --episodes 50 --out runs/two_arms

An arm reads where the other's links are as it reads any object, and is not told where they go.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import product
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.statistics import group_rows
from aicon_baselines.evaluation.tables import to_markdown
from aicon_envs.reach import ROBOTS
from aicon_envs.reach.pair import TABLE_TOP, THICKNESS, ArmPair
from aicon_envs.reach.robots import draw_postures, find_file
from aicon_torch import Policy
from aicon_torch.models import make_policy
from aicon_torch.parts import CapsuleSegments, Robot, Solid, TipPose, reading_of
from aicon_torch.parts.solids import ROUND
from clutter import NEAR, RANDOM_PLACES, STRAIGHT, draw, share_of
from study_table import fill

POLICIES: dict[str, dict[str, Any]] = {
    "aicon": {},
    "random_places": {"dampers.escape": RANDOM_PLACES},
    "without_escape": {"dampers.escape": None},
}
"""What differs from the defaults."""

DISTANCE = 1.0
"""Between the bases, m."""

DT, SPEED, HORIZON = 0.02, 1.5, 30.0
"""s, rad/s and s."""

BEYOND, BESIDE = 0.3, 0.4
"""Each target is in the other's half, at most so far beyond the middle and beside it, m."""

APART, ROOM, STOP_DISTANCE = 0.04, 0.02, 0.05
"""Gaps at their targets, of the arms and all others, m, and of joints to their stops, rad."""

STUCK_FOR, STUCK = 5.0, 0.02
"""Stuck is an arm whose joints have been slower than this, rad/s, for the last s."""

DRAWS = 1000
"""So many pairs of postures are drawn until one is free."""

Array = NDArray[np.float64]


class Row(NamedTuple):
    """What became of an episode; gaps are the least of all of it, m."""

    robots: str
    policy: str
    seed: int
    time: float  # s until both tips were there; NaN where they were not
    first_missing: float  # m at the end
    second_missing: float
    stuck: int  # how many arms were, at the end
    apart: float
    self_gap: float
    table_gap: float

    @property
    def is_solved(self) -> bool:
        """Whether both arrived."""
        return self.time <= HORIZON

    @property
    def touched(self) -> bool:
        """Whether anything did."""
        return min(self.apart, self.self_gap, self.table_gap) < 0.0


class Arm:
    """One of the arms, as its policy sees it.

    Args:
        name: Of the robot.
    """

    def __init__(self, name: str) -> None:
        known = ROBOTS[name]
        srdf = None if known.srdf is None else find_file(known.srdf)
        self.robot = Robot.from_urdf(find_file(known.urdf), tip=known.tip, srdf=srdf)
        assert self.robot.shape is not None
        self.capsules = self.robot.shape.capsules
        self.segments = CapsuleSegments(self.robot.chain, self.capsules)
        self.radii = np.array([[capsule.radius] for capsule in self.capsules])
        self.pose = TipPose("full", lever=1.0)
        self.home = np.array(known.home)

    def seen_by_the_other(self, q: Array) -> Array:
        """Its capsules as objects, as the arm that faces it reads them, ``(16 m,)``."""
        ends = self.segments(torch.from_numpy(q)).numpy().reshape(-1, 2, 3)
        start, end = np.moveaxis(ends * (-1.0, -1.0, 1.0) + (DISTANCE, 0.0, 0.0), 1, 0)
        way = end - start
        lengths = np.linalg.norm(way, axis=-1, keepdims=True)
        turns = np.stack([turn_of_z(each) for each in way]).reshape(-1, 9)

        # Centre, rotation, half the lengths of the box about it, and kind: see Solid.
        half = np.concatenate((self.radii, self.radii, lengths / 2 + self.radii), axis=-1)
        kind = np.full_like(lengths, ROUND)
        numbers: Array = np.concatenate(((start + end) / 2, turns, half, kind), axis=-1)
        return numbers.ravel()

    def x_ee(self, q: Array) -> Tensor:
        """Its tip."""
        return self.pose.of_frame(self.robot.chain(torch.from_numpy(q)))

    def left(self, q: Array, target: Tensor) -> tuple[float, float]:
        """The distance, m, and the angle, rad, of its tip to a target."""
        distance, angle = self.pose.distance(self.x_ee(q), target)
        return float(distance), float(angle)


def turn_of_z(way: Array) -> Array:
    """A rotation that takes the z axis into the direction of a way ``(3,)``, ``(3, 3)``."""
    length = np.linalg.norm(way)
    if length < 1e-9:
        return np.eye(3)

    # About the axis across both; of the opposite direction any axis across will do.
    x, y, z = way / length
    if z < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    turn: Array = np.array(
        [
            [1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), x],
            [-x * y / (1.0 + z), 1.0 - y * y / (1.0 + z), y],
            [-x, -y, z],
        ]
    )
    return turn


def table() -> Solid:
    """The table, in either frame."""
    return Solid("box", (2.0, 2.0, THICKNESS), (DISTANCE / 2, 0.0, TABLE_TOP - THICKNESS / 2))


def policies_of(arms: Sequence[Arm], name: str) -> list[Policy]:
    """The policies of both arms, compiled."""
    policies = []
    for arm, other in (arms, arms[::-1]):
        own: dict[str, Any] = {"robot": arm.robot, "orientation": "full", "speed": SPEED, "dt": DT}
        count = len(other.capsules) + 1
        policy = make_policy("reach", obstacles=count, **own, **POLICIES[name])
        policies.append(policy.compile())
    return policies


def drawn(pair: ArmPair, arms: Sequence[Arm], seed: int) -> list[Array]:
    """Postures at their targets, which are free and near the middle.

    Raises:
        ValueError: If none is found.
    """
    generator = np.random.default_rng(seed)
    for _ in range(DRAWS):
        postures = []
        for arm, low, high in zip(arms, pair.low, pair.high, strict=True):
            inside = np.minimum(STOP_DISTANCE, 0.1 * (high - low))
            posture = draw_postures(low + inside, high - inside, 1, generator)[0]
            while not is_shared(arm, posture):
                posture = draw_postures(low + inside, high - inside, 1, generator)[0]
            postures.append(posture)
        gaps = pair.measure((postures[0], postures[1]))
        if gaps.apart > APART and min(gaps) > ROOM:
            return postures
    raise ValueError(f"seed {seed}: no free pair of postures in {DRAWS} draws.")


def is_shared(arm: Arm, q: Array) -> bool:
    """Whether its tip is then in the other's half, and above the table."""
    x, y, z = arm.x_ee(q)[:3].tolist()
    is_beyond = 0.0 < x - DISTANCE / 2 < BEYOND
    return bool(is_beyond and abs(y) < BESIDE and z > TABLE_TOP)


class Outcome(NamedTuple):
    """What became of both arms: distances at the end, gaps the least of all, m.

    Attributes:
        time: When both had arrived, s; NaN where they did not.
        missing: What each tip lacks to its target.
        stuck: How many are stuck.
        gaps: Between the arms, of an arm to itself, and to the table, ``(3,)``.
    """

    time: float
    missing: list[float]
    stuck: int
    gaps: Array


def episode(
    pair: ArmPair,
    arms: Sequence[Arm],
    policies: Sequence[Policy],
    seed: int,
    watch: Callable[[], None] = lambda: None,
) -> Outcome:
    """One episode, from where both arms are at home; it is watched before every step."""
    targets = [arm.x_ee(q) for arm, q in zip(arms, drawn(pair, arms, seed), strict=True)]
    told = [target_reading(target) for target in targets]
    of_table = reading_of([table()]).numpy()
    pair.start((arms[0].home, arms[1].home))
    memories: list[Any] = [None, None]
    gaps: Array = np.array(pair.gaps)
    moved: Array = np.zeros(2)
    for step in range(round(HORIZON / DT)):
        watch()
        joints = pair.joints
        left = [arm.left(q, to) for arm, q, to in zip(arms, joints, targets, strict=True)]
        missing = [distance for distance, _ in left]
        is_there = np.array([distance < NEAR and angle < STRAIGHT for distance, angle in left])
        if is_there.all():
            return Outcome(step * DT, missing, 0, gaps)

        # Each sees where the other is now.
        actions = []
        for number in range(2):
            other = arms[1 - number].seen_by_the_other(joints[1 - number])
            objects = {"obstacles": np.concatenate((other, of_table))}
            seen = {"q": joints[number], **objects, **told[number]}
            action, memories[number] = policies[number].predict(seen, memories[number])
            actions.append(np.asarray(action))
        pair.step((actions[0], actions[1]))
        gaps = np.minimum(gaps, pair.gaps)
        is_moving = [np.abs(action).max() > STUCK for action in actions]
        moved = np.where(is_moving, step * DT, moved)

    is_stuck = ~is_there & (HORIZON - moved > STUCK_FOR)
    return Outcome(math.nan, missing, int(is_stuck.sum()), gaps)


def target_reading(target: Tensor) -> dict[str, Array]:
    """What a policy is told of its target."""
    columns = target[3:].reshape(3, 3) * math.sqrt(2.0)
    turn = Rotation.from_matrix(columns.mT.numpy()).as_quat(scalar_first=True)
    return {"target_position": target[:3].numpy(), "target_orientation": turn}


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    first, second = arguments.robots
    arms = [Arm(first), Arm(second)]
    pair = ArmPair(ROBOTS[first], ROBOTS[second], DISTANCE)
    policies = cache(partial(policies_of, arms))

    def measure(robots: str, name: str, seed: int) -> list[Row]:
        found = episode(pair, arms, policies(name), seed)
        first_missing, second_missing = found.missing
        of_tips = (found.time, first_missing, second_missing, found.stuck)
        apart, to_itself, to_table = found.gaps.tolist()
        return [Row(robots, name, seed, *of_tips, apart, to_itself, to_table)]

    table = arguments.out / f"{first}_{second}.csv"
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    wanted = list(product([f"{first} and {second}"], arguments.agents, seeds))
    rows = fill(table, Row, wanted, measure, "episodes")
    report(rows)
    draw(table, rows, HORIZON)


def report(rows: Sequence[Row]) -> None:
    """Print a table."""
    groups = group_rows(rows, attrgetter("policy"))
    header = ["robots", "policy", "both arrive, %", "median time", "touched", "stuck", "least gap"]
    lines = []
    for name, own in groups.items():
        times = [row.time for row in own if row.is_solved]
        median = f"{np.median(times):.1f} s" if times else "–"
        touched, stuck = sum(row.touched for row in own), sum(row.stuck for row in own)
        gap = f"{1e3 * min(row.apart for row in own):.1f} mm"
        arrived = share_of(len(times), len(own))
        lines.append([own[0].robots, name, arrived, median, str(touched), str(stuck), gap])
    print(to_markdown(header, lines))

    for name, own in groups.items():
        late = [str(row.seed) for row in own if not row.is_solved]
        touching = [str(row.seed) for row in own if row.touched]
        print(f"{name}: not there: {', '.join(late) or 'none'}", end="; ")
        print(f"touched: {', '.join(touching) or 'none'}")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    parser.add_argument("robots", nargs=2, choices=sorted(ROBOTS), help="the two arms")
    parser.add_argument("--agents", nargs="+", choices=POLICIES, default=list(POLICIES))
    add_option(parser, "--seed", 319000, "of the first episode", type=at_least(0))
    add_option(parser, "--episodes", 50, "how many", type=at_least(1))
    add_option(parser, "--out", Path("runs/two_arms"), "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
