"""What happens in episodes of the arm, in numbers: errors, heights, views, limits, conflicts and explorations.

The rows of a comparison say whether an episode succeeded and when; these say how.
"""

import csv
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.panda import TASK
from aicon_baselines.task import Episode
from aicon_torch import Policy
from aicon_torch.models.panda import SCALE
from aicon_torch.models.panda.body import SelfCollision
from aicon_torch.models.panda.camera import Visibility
from aicon_torch.models.panda.robot import PANDA

MEETINGS = ("x_pusher", "x_ee", "x_joints")
"""Where gradients meet: the sides of the object, the goals of the end effector, all goals."""


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
        in_view: Share of steps with the object's centre in the image.
        pose_error: Median error of the estimated position, mm.
        pose_error_95: 95th percentile, mm.
        limit_margin: Smallest distance of a joint to its limits, rad.
        self_distance: Smallest gap between capsules that can meet, m.
        collisions: Steps in which the robot touched itself or the table.
        explorations: How often exploring began at `x_pusher`, `x_ee` and `x_joints`.
        exploring: Share of steps in which any of them explored.
        rises: Share of steps in which the predicted change of the top goal's own cost was positive, at `x_joints`.
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
    in_view: float
    pose_error: float
    pose_error_95: float
    limit_margin: float
    self_distance: float
    collisions: int
    explorations: tuple[int, ...]
    exploring: float
    rises: float

    def to_fields(self) -> list[str]:
        """The row as text."""
        return [
            " ".join(map(str, value))
            if isinstance(value, tuple)
            else f"{value:.4g}"
            if isinstance(value, float)
            else str(int(value))
            for value in self
        ]


def watch(
    policy: Policy,
    condition: str,
    seeds: Iterable[int],
    horizon: int,
    on_finished: Callable[[EpisodeNumbers], None] = lambda numbers: None,
) -> list[EpisodeNumbers]:
    """Run episodes together and take their numbers.

    Args:
        policy: The policy.
        condition: A condition of the task.
        seeds: Their seeds.
        horizon: Steps after which an episode ends.
        on_finished: Called with the numbers of each as it ends.
    """
    episodes = [Episode(seed, 0, "table") for seed in seeds]
    env = TASK.make_env(len(episodes), condition, horizon)
    try:
        observation, _ = env.reset(**TASK.reset_arguments(episodes))
        histories = [_History(episode.seed) for episode in episodes]
        found: dict[int, EpisodeNumbers] = {}
        memory, forget = None, np.zeros(len(episodes), np.bool_)
        for _ in range(horizon):
            action, memory = policy.predict(observation, memory, forget)
            observation, _, terminated, truncated, info = env.step(action)
            facts = _facts(policy, memory)
            for row in np.nonzero(~forget)[0].tolist():
                one = {key: value[row] for key, value in info.items() if not key.startswith("_")}
                histories[row].add(one, {key: value[row] for key, value in facts.items()})
                if terminated[row] or truncated[row]:
                    found[row] = histories[row].sum_up(one)
                    on_finished(found[row])
            forget = forget | terminated | truncated
            if forget.all():
                break
        return [found[row] for row in sorted(found)]
    finally:
        env.close()


def save(numbers: Iterable[EpisodeNumbers], path: Path) -> None:
    """Write a row for each episode."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EpisodeNumbers._fields)
        writer.writerows(row.to_fields() for row in sorted(numbers))


def in_words(numbers: list[EpisodeNumbers]) -> str:
    """A line on several episodes."""
    solved = [row for row in numbers if row.success]

    def middle(name: str, rows: list[EpisodeNumbers] = numbers) -> float:
        return float(np.median([getattr(row, name) for row in rows])) if rows else math.nan

    return (
        f"{len(solved)}/{len(numbers)} solved, median {middle('time', solved):.1f} s; final error "
        f"{middle('distance', solved):.1f} mm, {middle('angle', solved):.1f} deg; height within "
        f"{middle('height_error'):.1f} mm rms; in view {middle('in_view'):.0%}, "
        f"seen within {middle('pose_error'):.1f} mm; "
        f"margin {min(row.limit_margin for row in numbers):.3f} rad, "
        f"{1e3 * min(row.self_distance for row in numbers):.0f} mm; "
        f"{sum(row.collisions > 0 for row in numbers)} with collisions"
    )


def _facts(policy: Policy, memory: dict[str, Any]) -> dict[str, NDArray[Any]]:
    """What the memory says of the step, for each row."""
    facts = {"estimate": memory["x_pose"].numpy()}
    exploring = [memory[f"{name}/exploring"] for name in MEETINGS if f"{name}/exploring" in memory]
    if exploring:
        facts["exploring"] = torch.stack(exploring, dim=-1).numpy()
    if "x_body" in memory:
        facts["gap"] = _SHAPE.distances(memory["x_body"]).amin(-1).numpy()
    if "x_cam" in memory:
        facts["camera"] = memory["x_cam"].numpy()
    if "x_joints/gradients" in memory:
        stack = memory["x_joints/gradients"]
        top = stack.norm(dim=-1).argmax(-1, keepdim=True)
        leading = stack.gather(-2, top.unsqueeze(-1).expand(*top.shape, stack.shape[-1])).squeeze(-2)
        facts["rise"] = ((leading * memory["a"]).sum(-1) > 1e-9).numpy()
    return facts


_SHAPE = SelfCollision(PANDA, 0.05, 1.0)
_VIEW = Visibility(PANDA, SCALE, (1.0, 1.0, 1.0), 0.0, 0.02)


class _History:
    """The steps of one episode so far."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.heights: list[float] = []
        self.errors: list[float] = []
        self.seen: list[bool] = []
        self.explored: list[NDArray[np.bool_]] = []
        self.rises: list[bool] = []
        self.margin = self.gap = math.inf
        self.collisions = 0

    def add(self, info: dict[str, Any], facts: dict[str, Any]) -> None:
        """Take the numbers of a step."""
        pose = info["object_pose"]
        self.heights.append(1e3 * float(info["tip"][2]))
        self.errors.append(1e3 * float(np.hypot(*(facts["estimate"][:2] / SCALE - pose[:2]))))
        self.margin = min(self.margin, float(info["limit_margin"]))
        self.gap = min(self.gap, float(facts.get("gap", math.inf)))
        self.collisions += int(info["collision"])
        if "camera" in facts:
            truth = torch.tensor([SCALE * pose[0], SCALE * pose[1], pose[2]], dtype=torch.float64)
            u, v = _VIEW.image(truth, torch.as_tensor(facts["camera"]))
            self.seen.append(bool(max(abs(u), abs(v)) < 1))
        if "exploring" in facts:
            self.explored.append(facts["exploring"])
        self.rises.append(bool(facts.get("rise", False)))

    def sum_up(self, info: dict[str, Any]) -> EpisodeNumbers:
        """The numbers of the episode, which ended with this."""
        later = np.array(self.heights[100:] or self.heights)
        explored = np.array(self.explored) if self.explored else np.zeros((1, len(MEETINGS)), np.bool_)
        began = explored & ~np.vstack((np.zeros_like(explored[:1]), explored[:-1]))
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
            in_view=float(np.mean(self.seen)) if self.seen else math.nan,
            pose_error=float(np.median(self.errors)),
            pose_error_95=float(np.percentile(self.errors, 95)),
            limit_margin=self.margin,
            self_distance=self.gap,
            collisions=self.collisions,
            explorations=tuple(began.sum(0).tolist()),
            exploring=float(explored.any(1).mean()),
            rises=float(np.mean(self.rises)),
        )
