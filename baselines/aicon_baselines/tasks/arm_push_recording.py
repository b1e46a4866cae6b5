"""Running episodes of the arm, and taking the numbers that say how it pushed."""

import math
from collections import Counter
from collections.abc import Callable, Collection
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks.arm_push import TASK
from aicon_baselines.tasks.arm_push_numbers import EpisodeNumbers
from aicon_torch import Policy, StepTrace
from aicon_torch.inspection import QuantityTrace
from aicon_torch.models.arm_push import PANDA, Options, end_effector
from aicon_torch.parts.camera import Visibility
from aicon_torch.parts.end_effector import EndEffector

CONFLICT_QUANTITIES = ("x_pusher", "x_ee", "x_joints")
"""Where gradients meet: the sides of the object, the goals of the end effector, all goals."""

AMPLITUDE = 0.3
"""How far the tip must go up or down to have turned, mm: three times the noise of its height."""

_HEIGHT = 0.02  # m, at which the tip is to be, and the object's centre is
_SETTLING_STEPS = 100  # in which the tip comes down to it
_MILLIMETRES = 1e3

_VISIBILITY = Visibility(PANDA.intrinsics, (1.0, 1.0, 1.0), edge_growth=0.0, height=_HEIGHT)


def _ignore(numbers: EpisodeNumbers) -> None:
    """Do nothing with the numbers of an episode that ended."""


def watch(
    policy: Policy,
    condition: str,
    episodes: list[Episode],
    horizon: int,
    on_finished: Callable[[EpisodeNumbers], None] = _ignore,
    wanted: Collection[int] | None = None,
) -> list[EpisodeNumbers]:
    """Run episodes together and take their numbers.

    Args:
        policy: The policy.
        condition: A condition of the task.
        episodes: The episodes; those of a chunk go as they go in a comparison.
        horizon: Steps after which an episode ends.
        on_finished: Called with the numbers of each as it ends.
        wanted: Seeds whose numbers are wanted; the others only keep them company. By default all.
    """
    seeds = [episode.seed for episode in episodes]
    missing = set(seeds if wanted is None else wanted)
    histories = [_History(seed) for seed in seeds]

    found: dict[int, EpisodeNumbers] = {}

    arm = end_effector(Options(robot=TASK.policy_options(condition)["robot"]))
    with closing(TASK.make_env(len(episodes), condition, horizon)) as env:
        start = env.reset(**TASK.reset_arguments(episodes))
        for number, history in enumerate(histories):
            history.add_margins({name: values[number] for name, values in start[1].items()})

        for step in run_episodes(policy, env, start):
            facts = read_facts(policy.trace(step.memory), arm)

            # Each episode that was still going on takes its numbers of this step.
            for row in np.flatnonzero(step.running):
                own_info = {name: values[row] for name, values in step.info.items()}
                histories[row].add(own_info, facts, int(row))

                if step.ended[row]:
                    numbers = histories[row].sum_up(own_info)
                    if numbers.seed in missing:
                        found[numbers.seed] = numbers
                        on_finished(numbers)
            if missing <= set(found):
                break
    return [found[seed] for seed in sorted(found)]


@dataclass(frozen=True)
class StepFacts:
    """What a step of B arms shows of the policy.

    Attributes:
        position: Where it believes the object, (B, 2), m.
        camera: Where it believes its camera, x_cam (B, 12); None without one.
        resolved: What happened where gradients met, by quantity.
        raises_leader: Whether the action raises, to first order, the cost whose gradient leads,
            (B,).
    """

    position: NDArray[np.float64]
    camera: Tensor | None
    resolved: dict[str, QuantityTrace]
    raises_leader: NDArray[np.bool_]


def read_facts(trace: StepTrace, arm: EndEffector) -> StepFacts:
    """Read them off the trace of the step of an arm."""
    resolved = {}
    for name in CONFLICT_QUANTITIES:
        if name in trace.quantities:
            resolved[name] = trace.quantities[name]

    return StepFacts(
        position=trace.values["x_pose"][..., :2].numpy(),
        camera=trace.values.get("x_cam"),
        resolved=resolved,
        raises_leader=(change_of_leader(trace, arm) > 1e-9).numpy(),
    )


def change_of_leader(trace: StepTrace, arm: EndEffector) -> Tensor:
    """Predicted change of the cost whose gradient leads, ``(B,)``, per s.

    Where that gradient came from the end effector, it is the one that leads there, by the motion
    that the action gives the end effector: what the joints see of it is its pull-back, no
    derivative of the cost. A policy that ranks no gradients at the joints has no leader there, and
    the change is 0.
    """
    action = trace.values["a"]
    joints = trace.quantities.get("x_joints")
    if joints is None or not (joints.ranks >= 0).any():
        return torch.zeros_like(action[..., 0])

    change = (_leading_gradient(joints) * action).sum(-1)
    if "x_ee" not in trace.quantities:
        return change

    jacobian = arm.jacobian(trace.values["x_joints"])
    motion = (jacobian @ action.unsqueeze(-1)).squeeze(-1)
    change_there = (_leading_gradient(trace.quantities["x_ee"]) * motion).sum(-1)

    from_end_effector = torch.tensor([path[-2] == "x_ee" for path in joints.paths])
    return torch.where(from_end_effector[joints.leader], change_there, change)


def count_turns(values: NDArray[np.float64], amplitude: float) -> int:
    """How often a curve turns back by more than an amplitude."""
    turns, direction, extreme = 0, 0, values[0]

    for value in values:
        goes_on = direction * (value - extreme) > 0
        if goes_on:
            extreme = value
        elif abs(value - extreme) > amplitude:
            # The first direction is no turn.
            turns += direction != 0
            direction = 1 if value > extreme else -1
            extreme = value
    return turns


def _leading_gradient(quantity: QuantityTrace) -> Tensor:
    """The gradient that leads in each row, ``(B, d)``."""
    rows = torch.arange(len(quantity.leader))
    return quantity.gradients[rows, quantity.leader]


@dataclass
class _History:
    """The steps of one episode so far; lengths in mm, but for the gap of the robot to itself."""

    seed: int
    heights: list[float] = field(default_factory=list)
    pose_errors: list[float] = field(default_factory=list)
    in_view: list[bool] = field(default_factory=list)
    explored: list[bool] = field(default_factory=list)
    rises: list[bool] = field(default_factory=list)

    conflicts: Counter[str] = field(default_factory=Counter)
    exploring: set[str] = field(default_factory=set)
    limit_margin: float = math.inf
    self_distance: float = math.inf
    collisions: int = 0

    def add(self, info: dict[str, Any], facts: StepFacts, row: int) -> None:
        """Take the numbers of a step, from the environment's info and row `row` of the facts."""
        # Where the tip is, and how far the object is from where it is believed.
        true_pose = info["object_pose"]
        error = np.hypot(*(facts.position[row] - true_pose[:2]))
        self.pose_errors.append(_MILLIMETRES * float(error))
        self.heights.append(_MILLIMETRES * float(info["tip"][2]))

        self.add_margins(info)
        self.collisions += int(info["collision"])

        if facts.camera is not None:
            self.in_view.append(_is_in_view(true_pose, facts.camera[row]))
        self._add_conflicts(facts, row)

    def add_margins(self, info: dict[str, Any]) -> None:
        """Note what the robot came near to, with its start."""
        self.limit_margin = min(self.limit_margin, float(info["limit_margin"]))
        self.self_distance = min(self.self_distance, float(info["self_distance"]))

    def _add_conflicts(self, facts: StepFacts, row: int) -> None:
        """Note what explores, and between which goals that began."""
        exploring = set()
        for name, quantity in facts.resolved.items():
            if bool(quantity.exploring[row]):
                exploring.add(name)
                if name not in self.exploring:
                    goals = quantity.goals_in_conflict(row) or ("unknown",)
                    self.conflicts[f"{name}:{'/'.join(goals)}"] += 1

        self.exploring = exploring
        self.explored.append(bool(exploring))
        if not exploring:
            self.rises.append(bool(facts.raises_leader[row]))

    def sum_up(self, info: dict[str, Any]) -> EpisodeNumbers:
        """The numbers of the episode, which ended with this info."""
        settled = np.array(self.heights[_SETTLING_STEPS:] or self.heights)
        deviations = settled - _MILLIMETRES * _HEIGHT
        conflicts = [f"{name}={count}" for name, count in sorted(self.conflicts.items())]

        return EpisodeNumbers(
            seed=self.seed,
            success=bool(info["is_success"]),
            fallen=bool(info["fallen"]),
            time=len(self.heights) * TASK.time_step,
            distance=_MILLIMETRES * float(info["distance"]),
            angle=math.degrees(float(info["angle"])),
            height_error=float(np.sqrt((deviations**2).mean())),
            height_low=float(settled.min()),
            height_high=float(settled.max()),
            turns=count_turns(settled, AMPLITUDE) / (len(settled) * TASK.time_step),
            in_view=_share(self.in_view),
            pose_error=float(np.median(self.pose_errors)),
            pose_error_95=float(np.percentile(self.pose_errors, 95)),
            limit_margin=self.limit_margin,
            self_distance=self.self_distance,
            collisions=self.collisions,
            conflicts=" ".join(conflicts),
            exploring=_share(self.explored),
            rises=_share(self.rises),
        )


def _is_in_view(pose: NDArray[np.float64], camera: Tensor) -> bool:
    """Whether the centre of an object with this pose is in the image."""
    u, v = _VISIBILITY.image_point(torch.as_tensor(pose, dtype=torch.float64), camera)
    return bool(max(abs(u), abs(v)) < 1)


def _share(flags: list[bool]) -> float:
    return float(np.mean(flags)) if flags else math.nan
