"""The physics of one world: a driven disc, an object and four walls, in pymunk.

All numbers and the order of all operations are those of gym-pusht 0.1.8, so that trajectories agree
with it to the last bits; pymunk's solver depends on the order in which bodies are created.
"""

import math
from typing import Any

from gymnasium.error import DependencyNotInstalled

from aicon_envs.pusht.geometry import Point, Pose
from aicon_envs.pusht.objects import PushObject

try:
    import pymunk
except ImportError as error:
    raise DependencyNotInstalled('pushT needs pymunk: pip install "aicon-torch[pusht]"') from error

SIZE = 512.0
"""Width and height of the world, px."""

PUSHER_RADIUS = 15.0
"""Radius of the pusher, px."""

WALL_LOW, WALL_HIGH = 7.0, 504.0
"""Inner faces of the walls, px: segments at 5 and 506 with radius 2."""

SUB_STEP = 0.01
"""Duration of one step of the physics, s."""

SUB_STEPS = 10
"""Steps of the physics in one control step."""

CONTROL_STEP = SUB_STEP * SUB_STEPS
"""Duration of one control step, s."""

STIFFNESS, DAMPING = 100.0, 20.0
"""Gains of the pusher's controller, 1/s² and 1/s."""

# pymunk's collision types.
_OTHERS, _OBJECT = 0, 1

_WALL_LINES = (
    ((5, 506), (5, 5)),
    ((5, 5), (506, 5)),
    ((506, 5), (506, 506)),
    ((5, 506), (506, 506)),
)
"""Middle lines of the walls, px, in gym-pusht's order."""

_WALL_COLOR = (211, 211, 211, 255)
_PUSHER_COLOR = (65, 105, 225, 255)
_OBJECT_COLOR = (119, 136, 153, 255)


_Move = tuple[str, tuple[Any, ...]]
"""A method of the simulation that was called, and its arguments."""


class Simulation:
    """A kinematic pusher, and an object that slides with quasi-static friction.

    The object's velocity is lost in every sub-step.

    Args:
        object: What is pushed.
        start: Position of the pusher, px.
        pose: Pose of the object, set exactly, px and rad.

    Attributes:
        object: What is pushed.
        space: The pymunk space.
    """

    def __init__(self, object: PushObject, start: Point, pose: Pose) -> None:
        """Put the pusher at `start` and the object at exactly `pose`, px and rad."""
        self._begin: tuple[bool, PushObject, Point, Pose] = (False, object, start, pose)
        self._moves: list[_Move] = []

        self.object = object
        self.space = pymunk.Space()
        self.space.damping = 0.0

        # In gym-pusht's order.
        self.space.add(*_make_walls(self.space.static_body))
        self._pusher = _add_pusher(self.space)
        self._body = _add_object(self.space, object)
        self._contacts = _count_contacts(self.space)
        self._touched = False

        self._pusher.position = start
        self._place(pose)

    @classmethod
    def legacy(cls, object: PushObject, start: Point, pose: Pose) -> "Simulation":
        """Set a state as gym-pusht does: not exactly `pose`.

        It sets the position before the angle, which then turns the object about its centre of
        gravity g instead of the origin: the position becomes (x, y) + g - R(angle) g. And it runs
        one sub-step of the physics.
        """
        x, y, angle = pose
        simulation = cls(object, start, (x, y, 0.0))
        simulation._body.angle = angle
        simulation._touched = simulation._advance()
        simulation._begin = (True, object, start, pose)
        return simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy, or restore from a file, by doing again all that was done since the start.

        pymunk's own copies lose what its solver remembers of contacts, and go another way. What
        others change in `space` is not repeated.
        """
        return _repeat, (*self._begin, list(self._moves))

    @property
    def pusher(self) -> Point:
        """Position of the pusher, px."""
        x, y = self._pusher.position
        return x, y

    @property
    def velocity(self) -> Point:
        """Velocity of the pusher, px/s."""
        x, y = self._pusher.velocity
        return x, y

    @property
    def pose(self) -> Pose:
        """Pose of the object's frame, px and rad; the angle is not wrapped."""
        x, y = self._body.position
        return x, y, self._body.angle

    @pose.setter
    def pose(self, pose: Pose) -> None:
        self._moves.append(("_place", (pose,)))
        self._place(pose)

    @property
    def touched(self) -> bool:
        """Whether the object touched anything in the last control step."""
        return self._touched

    def steer(self, target: Point, limit: float) -> None:
        """Run one control step in which a PD controller drives the pusher to a target.

        In every sub-step: v ← v + (k_p (target - p) - k_v v) dt, with |v| limited.

        Args:
            target: Where to go, px.
            limit: Largest speed, px/s; may be infinite.
        """
        self._moves.append(("steer", (target, limit)))
        target_x, target_y = target
        pusher = self._pusher
        self._touched = False

        vx, vy = pusher.velocity
        for _ in range(SUB_STEPS):
            x, y = pusher.position
            vx += (STIFFNESS * (target_x - x) + DAMPING * (0.0 - vx)) * SUB_STEP
            vy += (STIFFNESS * (target_y - y) + DAMPING * (0.0 - vy)) * SUB_STEP

            speed = math.hypot(vx, vy)
            if speed > limit:
                vx, vy = vx * limit / speed, vy * limit / speed

            pusher.velocity = vx, vy
            self._touched |= self._advance()

    def _place(self, pose: Pose) -> None:
        # The angle first: pymunk turns a body about its centre of gravity.
        self._body.angle = pose[2]
        self._body.position = pose[:2]

    def _advance(self) -> bool:
        """Run one sub-step; return whether the object touches anything."""
        self.space.step(SUB_STEP)
        return self._contacts["count"] > 0


def _repeat(
    is_legacy: bool, object: PushObject, start: Point, pose: Pose, moves: list[_Move]
) -> Simulation:
    """Return a simulation in which all of this has happened."""
    begin = Simulation.legacy if is_legacy else Simulation
    simulation = begin(object, start, pose)

    for name, arguments in moves:
        getattr(simulation, name)(*arguments)
    simulation._moves = moves
    return simulation


def _make_walls(body: pymunk.Body) -> list[pymunk.Segment]:
    walls = []

    for start, end in _WALL_LINES:
        wall = pymunk.Segment(body, start, end, 2)
        wall.color = _WALL_COLOR
        walls.append(wall)

    return walls


def _add_pusher(space: pymunk.Space) -> pymunk.Body:
    body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    body.position = 256, 400

    disc = pymunk.Circle(body, PUSHER_RADIUS)
    disc.color = _PUSHER_COLOR

    space.add(body, disc)
    return body


def _add_object(space: pymunk.Space, object: PushObject) -> pymunk.Body:
    body = pymunk.Body(object.mass, object.inertia)

    shapes = []
    for part in object.parts:
        shape = pymunk.Poly(body, part.tolist())
        shape.color = _OBJECT_COLOR
        shape.collision_type = _OBJECT
        shapes.append(shape)

    # Before the pose, which pymunk turns about it.
    body.center_of_gravity = object.center_of_gravity
    body.angle = 0.0
    body.position = 256, 300

    space.add(body, *shapes)
    return body


def _count_contacts(space: pymunk.Space) -> dict[str, int]:
    """Return a dictionary whose entry "count" is how many shapes now touch the object's.

    Callbacks at the begin and the end of a contact are much rarer than gym-pusht's for every
    contact and sub-step.
    """
    handler = space.add_collision_handler(_OTHERS, _OBJECT)
    handler.begin = _begin_contact
    handler.separate = _end_contact

    handler.data["count"] = 0
    return handler.data


def _begin_contact(arbiter: pymunk.Arbiter, space: pymunk.Space, data: dict[str, Any]) -> bool:
    data["count"] += 1
    return True


def _end_contact(arbiter: pymunk.Arbiter, space: pymunk.Space, data: dict[str, Any]) -> None:
    data["count"] -= 1
