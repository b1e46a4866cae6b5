"""What happens in episodes of the arm, in numbers: errors, heights, views, limits, conflicts and explorations.

The rows of a comparison say whether an episode succeeded and when; these say how.
"""

import csv
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks.panda_push import TASK
from aicon_torch import Policy
from aicon_torch.models.panda_push import SCALE
from aicon_torch.models.panda_push.robot import PANDA
from aicon_torch.parts.camera import Visibility
from aicon_torch.parts.chain import Kinematics

MEETINGS = ("x_pusher", "x_ee", "x_joints")
"""Where gradients meet: the sides of the object, the goals of the end effector, all goals."""

AMPLITUDE = 0.3
"""How far up or down the tip must go to have turned, mm: three times the noise of the height that is seen."""


class EpisodeNumbers(NamedTuple):
    """One episode.

    Attributes:
        seed: Seed of the episode.
        success: Whether it succeeded.
        fallen: Whether the object fell off.
        time: Duration, s.
        distance: Distance at the end, mm.
        angle: Angle at the end, degrees.
        height_error: Root mean square of the tip's deviation from 20 mm after the first second, mm.
        height_low: Lowest tip after that, mm.
        height_high: Highest tip, mm.
        turns: How often per second the tip turned from rising to sinking or back, by more than `AMPLITUDE`.
        in_view: Share of steps with the object's centre in the image.
        pose_error: Median error of the estimated position, mm.
        pose_error_95: 95th percentile, mm.
        limit_margin: Smallest distance of a joint to its limits, rad.
        self_distance: Smallest gap between capsules that can meet, m.
        collisions: Steps in which the robot touched itself or the table.
        conflicts: How often exploring began, by where and between which goals: ``x_ee:push/heights=2``.
        exploring: Share of steps in which any quantity explored.
        rises: Share of the other steps whose action raises, to first order, the cost of the gradient that leads.
    """

    seed: int
    success: bool
    fallen: bool
    time: float
    distance: float
    angle: float
    height_error: float
    height_low: float
    height_high: float
    turns: float
    in_view: float
    pose_error: float
    pose_error_95: float
    limit_margin: float
    self_distance: float
    collisions: int
    conflicts: str
    exploring: float
    rises: float

    def to_fields(self) -> list[str]:
        """The row as text."""
        return [
            value
            if isinstance(value, str)
            else f"{value:.4g}"
            if isinstance(value, float)
            else str(int(value))
            for value in self
        ]

    @classmethod
    def from_fields(cls, fields: Iterable[str]) -> "EpisodeNumbers":
        """The row of such a text."""
        kinds: dict[str, Callable[[str], Any]] = {
            "bool": lambda text: text == "1",
            "str": str,
            "int": int,
        }
        values = zip(fields, cls.__annotations__.values(), strict=True)
        return cls(
            *(kinds.get(getattr(kind, "__name__", str(kind)), float)(text) for text, kind in values)
        )


def watch(
    policy: Policy,
    condition: str,
    episodes: list[Episode],
    horizon: int,
    on_finished: Callable[[EpisodeNumbers], None] = lambda numbers: None,
    wanted: Collection[int] | None = None,
) -> list[EpisodeNumbers]:
    """Run episodes together and take their numbers.

    Args:
        policy: The policy.
        condition: A condition of the task.
        episodes: The episodes; those of a chunk take the same way as in a comparison.
        horizon: Steps after which an episode ends.
        on_finished: Called with the numbers of each as it ends.
        wanted: Seeds whose numbers are wanted; the others only keep them company. By default all.
    """
    wanted = [episode.seed for episode in episodes] if wanted is None else wanted
    env = TASK.make_env(len(episodes), condition, horizon)
    try:
        observation, _ = env.reset(**TASK.reset_arguments(episodes))
        histories = [_History(episode.seed) for episode in episodes]
        found: dict[int, EpisodeNumbers] = {}
        memory, forget = None, np.ones(len(episodes), np.bool_)
        ended = np.zeros_like(forget)
        while not all(episode.seed in found for episode in episodes if episode.seed in wanted):
            action, memory = policy.predict(observation, memory, forget)
            observation, _, terminated, truncated, info = env.step(action)
            facts = _facts(policy, memory)
            for row in np.nonzero(~ended)[0].tolist():
                one = {key: value[row] for key, value in info.items() if not key.startswith("_")}
                histories[row].add(one, {key: value[row] for key, value in facts.items()})
                if terminated[row] or truncated[row]:
                    numbers = found[episodes[row].seed] = histories[row].sum_up(one)
                    if numbers.seed in wanted:
                        on_finished(numbers)
            forget = ended = ended | terminated | truncated
        return [found[seed] for seed in sorted(found) if seed in wanted]
    finally:
        env.close()


def load(path: Path) -> list[EpisodeNumbers]:
    """The rows of a table, none if there is no such file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [EpisodeNumbers.from_fields(fields) for fields in list(csv.reader(file))[1:]]


def save(numbers: Iterable[EpisodeNumbers], path: Path) -> None:
    """Write a row for each episode."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EpisodeNumbers._fields)
        writer.writerows(row.to_fields() for row in sorted(numbers))


def in_words(numbers: list[EpisodeNumbers]) -> str:
    """A few lines on several episodes."""
    solved = [row for row in numbers if row.success]

    def middle(name: str, rows: list[EpisodeNumbers] = numbers) -> float:
        return float(np.median([getattr(row, name) for row in rows])) if rows else math.nan

    failures = ", ".join(
        f"{row.seed}{' (fallen)' if row.fallen else ''}" for row in numbers if not row.success
    )
    conflicts = ", ".join(f"{name} {count}" for name, count in conflicts_of(numbers).most_common())
    return (
        f"{len(solved)}/{len(numbers)} solved, median {middle('time', solved):.1f} s, longest "
        f"{max((row.time for row in solved), default=math.nan):.1f} s; failures: {failures or 'none'}\n"
        f"  at the end {middle('distance', solved):.1f} mm and {middle('angle', solved):.1f} deg; height within "
        f"{middle('height_error'):.2f} mm rms, {middle('turns'):.2f} turns/s; in view {middle('in_view'):.0%}, "
        f"seen within {middle('pose_error'):.1f} mm\n"
        f"  least margin of a joint {min(row.limit_margin for row in numbers):.3f} rad, of the body "
        f"{1e3 * min(row.self_distance for row in numbers):.0f} mm; episodes with a collision: "
        f"{sum(row.collisions > 0 for row in numbers)}\n"
        f"  exploring {middle('exploring'):.0%} of the time; conflicts: {conflicts or 'none'}; "
        f"the leader's cost rises in {middle('rises'):.2%} of the other steps"
    )


def conflicts_of(numbers: Iterable[EpisodeNumbers]) -> Counter[str]:
    """How often exploring began in all episodes, by where and between which goals."""
    total: Counter[str] = Counter()
    for row in numbers:
        for entry in row.conflicts.split():
            name, _, count = entry.partition("=")
            total[name] += int(count)
    return total


def _facts(policy: Policy, memory: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """What the memory says of the step, for each row."""
    facts = {"estimate": memory["x_pose"].numpy()}
    if "x_cam" in memory:
        facts["camera"] = memory["x_cam"].numpy()
    exploring = {
        place: memory[f"{place}/exploring"] for place in MEETINGS if f"{place}/exploring" in memory
    }
    for place, flags in exploring.items():
        facts[f"{place}/exploring"] = flags.numpy()
        if flags.any():
            facts[f"{place}/between"] = _opponents(policy, memory, place)
    if "x_joints/rank" in memory:
        facts["rise"] = (_change_of_leader(policy, memory) > 1e-9).numpy()
    return facts


def _opponents(policy: Policy, memory: dict[str, Any], place: str) -> NDArray[Any]:
    """Names of the goals of the leading gradient and of the strongest that opposes it, ``(B,)``."""
    gradients, rank = memory[f"{place}/gradients"], memory[f"{place}/rank"]
    names = ["+".join(sorted(arrival.goals)) for arrival in policy.backward_pass.arrivals[place]]
    norms = gradients.norm(dim=-1)
    units = gradients / norms.clamp(min=1e-300).unsqueeze(-1)
    leaders = rank[..., 0].clamp(min=0)
    cosines = (units * units[torch.arange(len(leaders)), leaders].unsqueeze(-2)).sum(-1)
    others = norms.masked_fill(cosines > _BOUND, -1.0).argmax(-1)
    return np.array(
        [f"{names[one]}/{names[other]}" for one, other in zip(leaders, others, strict=True)]
    )


def _change_of_leader(policy: Policy, memory: dict[str, Any]) -> Tensor:
    """Predicted change of the cost whose gradient leads, ``(B,)``, per s.

    Where that gradient came from the end effector, it is the one that leads there, by the motion that the action gives
    the end effector: what the joints see of it is its pull-back, no derivative of the cost.
    """
    rows, action = torch.arange(len(memory["a"])), memory["a"]
    stack, rank = memory["x_joints/gradients"], memory["x_joints/rank"][..., 0].clamp(min=0)
    change: Tensor = (stack[rows, rank] * action).sum(-1)
    if "x_ee/rank" in memory:
        jacobian = _ARM.jacobian(_ARM.frames(memory["x_joints"]))
        motion = (jacobian @ action.unsqueeze(-1)).squeeze(-1)
        there = (
            memory["x_ee/gradients"][rows, memory["x_ee/rank"][..., 0].clamp(min=0)] * motion
        ).sum(-1)
        merged = [
            arrival.trace[-1] == "x_ee" for arrival in policy.backward_pass.arrivals["x_joints"]
        ]
        change = torch.where(torch.tensor(merged)[rank], there, change)
    return change


def count_turns(values: NDArray[np.float64], amplitude: float) -> int:
    """How often a curve turns back by more than an amplitude."""
    turns, direction = 0, 0
    extreme = values[0]
    for value in values:
        if direction * (value - extreme) > 0:
            extreme = value
        elif abs(value - extreme) > amplitude:
            turns += direction != 0
            direction, extreme = (1 if value > extreme else -1), value
    return turns


_ARM = Kinematics(PANDA)
_VIEW = Visibility(PANDA, SCALE, (1.0, 1.0, 1.0), 0.0, 0.02)
_BOUND = -0.4  # above this cosine a conflict ends


class _History:
    """The steps of one episode so far."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.heights: list[float] = []
        self.errors: list[float] = []
        self.seen: list[bool] = []
        self.explored: list[bool] = []
        self.exploring: set[str] = set()
        self.conflicts: Counter[str] = Counter()
        self.rises: list[bool] = []
        self.margin = self.gap = math.inf
        self.collisions = 0

    def add(self, info: dict[str, Any], facts: dict[str, Any]) -> None:
        """Take the numbers of a step."""
        pose = info["object_pose"]
        self.heights.append(1e3 * float(info["tip"][2]))
        self.errors.append(1e3 * float(np.hypot(*(facts["estimate"][:2] / SCALE - pose[:2]))))
        self.margin = min(self.margin, float(info["limit_margin"]))
        self.gap = min(self.gap, float(info["self_distance"]))
        self.collisions += int(info["collision"])
        if "camera" in facts:
            truth = torch.tensor([SCALE * pose[0], SCALE * pose[1], pose[2]], dtype=torch.float64)
            u, v = _VIEW.image(truth, torch.as_tensor(facts["camera"]))
            self.seen.append(bool(max(abs(u), abs(v)) < 1))
        exploring = {place for place in MEETINGS if facts.get(f"{place}/exploring", False)}
        self.conflicts.update(
            f"{place}:{facts[f'{place}/between']}" for place in exploring - self.exploring
        )
        self.exploring = exploring
        self.explored.append(bool(exploring))
        if not exploring:
            self.rises.append(bool(facts.get("rise", False)))

    def sum_up(self, info: dict[str, Any]) -> EpisodeNumbers:
        """The numbers of the episode, which ended with this."""
        later = np.array(self.heights[100:] or self.heights)
        return EpisodeNumbers(
            seed=self.seed,
            success=bool(info["is_success"]),
            fallen=bool(info["fallen"]),
            time=len(self.heights) * TASK.time_step,
            distance=1e3 * float(info["distance"]),
            angle=math.degrees(float(info["angle"])),
            height_error=float(np.sqrt(((later - 20.0) ** 2).mean())),
            height_low=float(later.min()),
            height_high=float(later.max()),
            turns=count_turns(later, AMPLITUDE) / (len(later) * TASK.time_step),
            in_view=float(np.mean(self.seen)) if self.seen else math.nan,
            pose_error=float(np.median(self.errors)),
            pose_error_95=float(np.percentile(self.errors, 95)),
            limit_margin=self.margin,
            self_distance=self.gap,
            collisions=self.collisions,
            conflicts=" ".join(f"{name}={count}" for name, count in sorted(self.conflicts.items())),
            exploring=float(np.mean(self.explored)),
            rises=float(np.mean(self.rises)) if self.rises else math.nan,
        )
