"""How an episode starts: what `reset` draws and what its options ask for."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.checks import given_options
from aicon_envs.reach.balls import draw_path
from aicon_envs.reach.gaps import SIGHT
from aicon_envs.reach.robots import check_posture, draw_postures
from aicon_envs.reach.simulation import Simulation
from aicon_envs.to_and_fro import ToAndFro

Start = Literal["home", "random"]

CLEARANCE = 0.02
"""Gap of the robot to itself at the start and at the target, m."""

STOP_DISTANCE = 0.05
"""Distance of every joint from its stops there, rad or m; at most a tenth of its range."""

FARTHER = 0.1
"""Least distance of the tip from its target at the start, m."""

BASE_RADII = 3.0
"""Balls stay so many radii away from the first two joints, which cannot dodge."""

_OPTION_KEYS = ("joints", "target_joints")

_ATTEMPTS = 2000
_POSTURES = 2000  # drawn until one is free of contact
_PATHS = 30  # of one of several balls, drawn until one is in nobody's way


class EpisodeStart(NamedTuple):
    """What is fixed at a reset.

    Attributes:
        joints: Where the joints start, ``(n,)``, rad or m.
        target_joints: Values of the joints at which the tip is at the target.
        balls: The balls.
    """

    joints: FloatArray
    target_joints: FloatArray
    balls: tuple[ToAndFro, ...]


class EpisodeDrawer:
    """Draws episodes whose targets can be reached.

    Args:
        simulation: The robot.
        home: Where the joints start if they start at home, ``(n,)``.
        start: "home" or "random".
        balls: Number of balls.
        ball_radius: Their radius, m.
        ball_speed: Their largest speed, m/s.
    """

    def __init__(
        self,
        simulation: Simulation,
        home: FloatArray,
        start: Start,
        balls: int,
        ball_radius: float,
        ball_speed: float,
    ) -> None:
        """Find out how far the robot can be from itself."""
        self._simulation = simulation
        self._home, self._start = home, start
        self._balls, self._radius, self._speed = balls, ball_radius, ball_speed
        self._nowhere = np.zeros((balls, 3)) + 100.0

        # Some robots are always near themselves.
        scene = simulation.scene
        postures = draw_postures(scene.low, scene.high, 50, np.random.default_rng(0))
        widest = max(self._gap(posture) for posture in postures)
        self._clearance = min(CLEARANCE, widest / 2.0)

    def __call__(
        self, options: Mapping[str, Any] | None, generator: np.random.Generator
    ) -> EpisodeStart:
        """Draw an episode.

        Args:
            options: `joints` and `target_joints`, both optional.
            generator: The environment's `np_random`.

        Raises:
            ValueError: If an option is unknown or not usable, or there is no place for the balls.
        """
        options = given_options(options, _OPTION_KEYS)

        # Drawn in any case, such that an option changes nothing but what it names.
        for _ in range(_ATTEMPTS):
            drawn = self._draw_posture(generator)
            joints = self._take(options, "joints", self._home if self._start == "home" else drawn)
            target_joints = self._take(options, "target_joints", self._draw_posture(generator))
            if not self._is_far(joints, target_joints) and "target_joints" not in options:
                continue

            balls = self._draw_balls(joints, target_joints, generator)
            if balls is not None:
                return EpisodeStart(joints, target_joints, balls)

        raise ValueError("no place was found for the target and the balls; try fewer or smaller")

    def _take(self, options: Mapping[str, Any], name: str, drawn: FloatArray) -> FloatArray:
        """Return the joints of an option, or what was drawn if it is not given."""
        if name not in options:
            return drawn

        scene = self._simulation.scene
        return check_posture(name, options[name], scene.low, scene.high)

    def _draw_posture(self, generator: np.random.Generator) -> FloatArray:
        """Return joints that are free of contact and not at their stops, ``(n,)``.

        Raises:
            ValueError: If there are none.
        """
        scene = self._simulation.scene
        distance = np.minimum(STOP_DISTANCE, 0.1 * (scene.high - scene.low))
        low, high = scene.low + distance, scene.high - distance

        for _ in range(_POSTURES):
            posture: FloatArray = draw_postures(low, high, 1, generator)[0]
            if self._gap(posture) >= self._clearance:
                return posture
        raise ValueError("the robot touches itself wherever its joints are; check its shapes")

    def _gap(self, posture: FloatArray) -> float:
        return self._simulation.measure(posture, self._nowhere).to_itself

    def _is_far(self, joints: FloatArray, target_joints: FloatArray) -> bool:
        start, _ = self._simulation.tip_at(joints)
        target, _ = self._simulation.tip_at(target_joints)
        return bool(np.linalg.norm(target - start) >= FARTHER)

    def _draw_balls(
        self, joints: FloatArray, target_joints: FloatArray, generator: np.random.Generator
    ) -> tuple[ToAndFro, ...] | None:
        """Return paths that leave the target reachable at all times, or None if these do not."""
        start, _ = self._simulation.tip_at(joints)
        target, _ = self._simulation.tip_at(target_joints)
        paths: list[ToAndFro] = []
        for _ in range(self._balls):
            # Of several there would hardly ever be a draw in which none is in the way.
            draws = _PATHS if self._balls > 1 else 1
            drawn = (draw_path(start, target, self._speed, generator) for _ in range(draws))
            path = next((one for one in drawn if not self._is_in_the_way(one, target_joints)), None)
            if path is None:
                return None
            paths.append(path)

        begins = np.array([path.at(0.0) for path in paths]).reshape(-1, 3)
        if self._simulation.measure(joints, begins).to_balls < SIGHT:
            return None
        return tuple(paths)

    def _is_in_the_way(self, path: ToAndFro, target_joints: FloatArray) -> bool:
        """Whether a ball comes near a robot at the target, or near what cannot dodge."""
        places, balls = path.everywhere(), self._nowhere.copy()
        bases = self._simulation.base_points(target_joints)
        distances = np.linalg.norm(places[:, None] - bases, axis=-1)
        if distances.min() < BASE_RADII * self._radius:
            return True

        for place in places:
            balls[0] = place
            if self._simulation.measure(target_joints, balls).to_balls < SIGHT:
                return True
        return False
