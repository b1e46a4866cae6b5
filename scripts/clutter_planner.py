"""A planner for `clutter_box.py`: OMPL's RRT-Connect, which sees all objects as they are now."""

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from torch import Tensor

from aicon_baselines.worlds.motion_bench_maker import SPEED
from clutter import DT, Array, World

STEP = 0.02
"""A way is looked at every so far, the largest change of a joint, rad."""

RANGE = 1.5
"""How long a branch is at most, rad."""

MARGIN, BOX_MARGIN = 0.002, 0.015
"""How far a planned way stays from the robot itself and from objects that stay, and from one that
moves, m; less where it is nearer already."""

PATIENCE, SHORTENING = 4.0, 0.5
"""How long it plans at most, and shortens what it has found, s of computing."""

EVERY, AFTER_FAILURE = 5, 25
"""Steps after which it looks at its way again: 10 Hz, and 2 Hz where there was none."""


class Planner:
    """Plans to the joints at the goal, which no policy is told, and goes as fast as it may.

    Its computing is granted: it counts for nothing.

    Args:
        world: The robot and what stays where it is.
        goal: The joints at the goal, rad.
        gap: The distance ``(k,)``, m, of spheres with centres ``(k, spheres, 3)`` to the object
            that moves, of which nothing is known at the beginning where it appears later.
        replans: Whether it looks at its way again, and plans again where it is not free.
    """

    def __init__(
        self, world: World, goal: Array, gap: Callable[[Array], Array], replans: bool
    ) -> None:
        self.world, self.goal, self.gap, self.replans = world, goal, gap, replans
        self.way: list[Array] = []
        self.step, self.next_look = 0, 0

    def predict(self, seen: Mapping[str, Tensor], memory: Any = None) -> tuple[Tensor, Any]:
        """The velocity of the joints ``(1, n)``, rad/s."""
        q = seen["q"][0].numpy()
        if self.step >= self.next_look and (self.step == 0 or self.replans):
            if not self.way or not self._is_free(np.stack((q, *self.way)), self._margins(q)):
                self.way = self._planned(q)
            self.next_look = self.step + (EVERY if self.way else AFTER_FAILURE)
        self.step += 1
        return torch.from_numpy((self._onward(q) - q) / DT)[None], {}

    def _onward(self, q: Array) -> Array:
        """Where it is after a step."""
        left = SPEED * DT
        while self.way:
            away = self.way[0] - q
            distance = float(np.abs(away).max())
            if distance > left:
                return q + away * left / distance
            q, left = self.way.pop(0), left - distance
        return q

    def _margins(self, q: Array) -> tuple[float, float]:
        """How far it stays from what stays and from what moves, m, as it stands so near."""
        still, box = self._gaps(q[None])
        return min(MARGIN, float(still[0]) - 1e-6), min(BOX_MARGIN, float(box[0]) - 1e-6)

    def _gaps(self, q: Array) -> tuple[Array, Array]:
        """The least distance at joints ``(k, n)`` to itself and what stays, and to what moves."""
        return np.minimum(*self.world.gaps(q)), self.gap(self.world.centres(q))

    def _is_free(self, way: Array, margins: tuple[float, float]) -> bool:
        """Whether straight ways through joints ``(k, n)`` touch nothing."""
        pieces = [way[:1]]
        for before, after in pairwise(way):
            count = max(1, math.ceil(np.abs(after - before).max() / STEP))
            pieces.append(before + np.arange(1, count + 1)[:, None] / count * (after - before))
        still, box = self._gaps(np.concatenate(pieces))
        return bool(still.min() >= margins[0] and box.min() >= margins[1])

    def _planned(self, q: Array) -> list[Array]:
        """A way from here to the goal; nothing where none is found."""
        from ompl import base, geometric, util

        util.setLogLevel(util.LOG_NONE)
        space = base.RealVectorStateSpace(len(q))
        bounds = base.RealVectorBounds(len(q))
        for joint, (low, high) in enumerate(zip(self.world.low, self.world.high, strict=True)):
            bounds.setLow(joint, float(low))
            bounds.setHigh(joint, float(high))
        space.setBounds(bounds)

        margins = self._margins(q)
        setup = geometric.SimpleSetup(space)
        information = setup.getSpaceInformation()
        setup.setStateValidityChecker(lambda state: self._is_free(_joints(state, q)[None], margins))

        class Motions(base.MotionValidator):  # type: ignore[misc]  # it has no types
            """A whole way at once."""

            def checkMotion(motions, first: Any, second: Any, *_: Any) -> bool:
                end = _joints(second, q)
                if not self._is_free(end[None], margins):
                    return False
                return self._is_free(np.stack((_joints(first, q), end)), margins)

        information.setMotionValidator(Motions(information))
        setup.setStartAndGoalStates(_state(space, q), _state(space, self.goal))
        planner = geometric.RRTConnect(information)
        planner.setRange(RANGE)
        setup.setPlanner(planner)
        setup.solve(PATIENCE)
        if not setup.haveExactSolutionPath():
            return []
        setup.simplifySolution(SHORTENING)
        path = setup.getSolutionPath()
        return [_joints(path.getState(number), q) for number in range(1, path.getStateCount())]


def _joints(state: Any, like: Array) -> Array:
    """The joints of a state of OMPL's."""
    return np.array([state[joint] for joint in range(len(like))])


def _state(space: Any, q: Array) -> Any:
    """A state of OMPL's."""
    state = space.allocState()
    for joint, value in enumerate(q):
        state[joint] = float(value)
    return state
