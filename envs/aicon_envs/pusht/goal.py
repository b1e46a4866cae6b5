"""Goals: fixed, random or jumping, and how far the object is from one."""

import math
from typing import NamedTuple

import numpy as np

from aicon_envs.pusht.geometry import Point, Pose, place, place_point, wrap
from aicon_envs.pusht.objects import PushObject
from aicon_envs.pusht.polygons import overlap_area
from aicon_envs.pusht.simulation import WALL_HIGH, WALL_LOW


class Jump(NamedTuple):
    """A change of the goal.

    Attributes:
        step: Number of control steps of the episode before it.
        pose: The new goal, px and rad.
    """

    step: int
    pose: Pose


class Goal:
    """A goal pose of an object, with what a comparison needs computed once.

    Args:
        object: What is pushed.
        pose: Its goal, px and rad.

    Attributes:
        center: The centre of gravity at the goal, px.
        parts: The object's convex parts at the goal, lists of vertices, px.
    """

    def __init__(self, object: PushObject, pose: Pose) -> None:
        """Place the goal at `pose`, px and rad."""
        self.object = object
        self.pose = pose
        self.center = place_point(object.center_of_gravity, pose)
        self.parts = _placed_parts(object, pose)

    def coverage(self, pose: Pose) -> float:
        """Return area(goal ∩ object at `pose`) / area(object)."""
        if self._distance(pose) >= 2.0 * self.object.radius:
            return 0.0

        covered = 0.0
        for part in _placed_parts(self.object, pose):
            for goal_part in self.parts:
                covered += overlap_area(part, goal_part)

        return covered / self.object.area

    def error(self, pose: Pose) -> float:
        """Return √(|Δg|² + (r Δθ)²), px.

        g is the centre of gravity, Δθ the wrapped difference of the angles and r the radius of
        gyration.
        """
        turn = self.object.radius_of_gyration * wrap(pose[2] - self.pose[2])
        return math.hypot(self._distance(pose), turn)

    def _distance(self, pose: Pose) -> float:
        """Return the distance between the centres of gravity, px."""
        x, y = place_point(self.object.center_of_gravity, pose)
        return math.hypot(x - self.center[0], y - self.center[1])


def draw_goal(object: PushObject, generator: np.random.Generator) -> Pose:
    """Draw a goal at which the object fits between the walls: first the angle, then the position.

    Both are uniform. Takes three numbers from the generator.
    """
    angle = generator.uniform(-math.pi, math.pi)
    corners = place(object.keypoints, (0.0, 0.0, angle))

    low = WALL_LOW - corners.min(axis=0)
    high = WALL_HIGH - corners.max(axis=0)
    x, y = generator.uniform(low, high).tolist()
    return x, y, angle


def draw_jumps(
    object: PushObject, count: int, interval: tuple[int, int], generator: np.random.Generator
) -> list[Jump]:
    """Draw the jumps of an episode, in order: a uniform number of steps apart, to random goals."""
    fewest, most = interval
    jumps = []

    step = 0
    for _ in range(count):
        step += int(generator.integers(fewest, most, endpoint=True))
        jumps.append(Jump(step, draw_goal(object, generator)))

    return jumps


def _placed_parts(object: PushObject, pose: Pose) -> list[list[Point]]:
    return [place(part, pose).tolist() for part in object.parts]
