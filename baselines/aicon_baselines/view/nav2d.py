"""Navigation: a disc, its trap, and where it believes its target."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.palette import (
    AWAY,
    BELIEF,
    CERTAINTY,
    EXPLORING,
    GROUND,
    OBSTACLE,
    RESOLVED,
    ROBOT,
    TARGET,
    TOWARDS,
    TRAIL,
)
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.plane import PlaneScene
from aicon_baselines.view.scene import Handle
from aicon_baselines.worlds import Shape, believed, disc, navigation
from aicon_baselines.worlds.surroundings import ARRIVAL

_MARGIN = 0.9  # m of ground around what there is
_KICK = 0.25  # m
_LOOKS = {
    ("reach", "p_tar"): ("reach the target", TOWARDS),
    ("reach", "P_tar"): ("know it better", CERTAINTY),
    ("avoid", "x_obs"): ("avoid the wall", AWAY),
}


class NavigationScene(PlaneScene):
    """The trap from above, in the world's frame, m."""

    title: ClassVar[str] = (
        "A robot looks for its target. It knows neither a map nor where it is: it sees the "
        "direction of the target and feels how near the next wall is."
    )
    legend: ClassVar[dict[str, str]] = {
        "robot": ROBOT,
        "target": TARGET,
        "where it believes the target (2σ)": BELIEF,
        "wall": OBSTACLE,
        "gradient: reach the target": TOWARDS,
        "gradient: know the target better": CERTAINTY,
        "gradient: avoid the wall, and where it feels it": AWAY,
        "motion, descending": RESOLVED,
        "motion, exploring": EXPLORING,
    }
    curves: ClassVar[Mapping[str, str]] = {label: color for label, color in _LOOKS.values()}
    remaining_curves: ClassVar[Mapping[str, str]] = {"distance": TARGET}
    hint: ClassVar[str] = (
        "Drag the arrows at the target or at the nearest wall to put it elsewhere."
    )
    can_kick: ClassVar[bool] = True

    def draw_world(self) -> None:
        """Draw the ground."""
        env: Any = self.episode.env.unwrapped
        world = env.maps[0]
        self._radius = env.physics.radius

        points = np.concatenate([*self._walls(), [world.start], [world.target]])
        low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
        self.canvas.fit(low, high)

        ground = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        self.canvas.draw({"ground": Shape(ground, 0, GROUND)})

    def draw_moving(self) -> None:
        """Draw the walls, the target, the robot, its trail, its beliefs and its gradients."""
        canvas, info = self.canvas, self.episode.info
        position, target = info["position"][0], info["target"][0]
        values = self.episode.trace.values

        canvas.draw(navigation(self._walls(), target))
        above = canvas.to_scene(target + np.array([0.0, 1.4 * ARRIVAL]), 30)
        canvas.text("target.label", "target", above)

        # It believes the target relative to itself; the true position places that in the world.
        mean = position + values["p_tar"][0].numpy(force=True)
        spread = believed(mean, values["P_tar"][0].numpy(force=True), 6, BELIEF)
        canvas.draw({"belief": spread, "belief.mean": disc(mean, 0.4 * ARRIVAL, 8, BELIEF)})
        below = canvas.to_scene(mean - np.array([0.0, 0.9 * ARRIVAL]), 30)
        canvas.text("belief.label", "believed here", below, scale=0.8)

        # The nearest wall as it feels it: so far, against the slope of the clearance.
        distance, *slope = values["x_obs"][0].tolist()
        uphill = np.array(slope) / max(np.linalg.norm(slope), 1e-9)
        wall = position - (max(distance, 0.0) + self._radius) * uphill
        canvas.line("wall", [position, wall], AWAY, 12, thickness=1.5)

        self.draw_trail(position, TRAIL, 10)
        canvas.draw({"robot": disc(position, self._radius, 14, ROBOT)})
        self.draw_arrows(position)

    def look_of(self, path: tuple[str, ...], goals: tuple[str, ...]) -> tuple[str, str]:
        """What a gradient wants, by its goal and by what that goal is about."""
        goal, quantity = path[:2]
        return _LOOKS.get((goal, quantity), (f"{goal} → {quantity}", CERTAINTY))

    def strengths(self) -> dict[str, float]:
        """The strength of each gradient, by what it wants."""
        return {arrow.label: arrow.strength for arrow in self.arrows()}

    def progress(self) -> str:
        """The distance to the target."""
        return f"{self.episode.info['distance'][0]:.2f} m to the target"

    def handles(self) -> Mapping[str, Handle]:
        """The target, and the nearest wall."""
        return {
            "target": self.handle(lambda: self.episode.info["target"][0], self.move_target),
            "wall": self.handle(self._middle_of_nearest, self.move_wall),
        }

    def kick(self) -> None:
        """Displace the robot."""
        env: Any = self.episode.env.unwrapped
        way = env.np_random.normal(0.0, _KICK, 2)
        self._set(start=(self.episode.info["position"][0] + way).tolist())

    def move_target(self, position: FloatArray) -> None:
        """Put the target elsewhere.

        Raises:
            ValueError: If there is a wall.
        """
        self._set(target=np.asarray(position).tolist())

    def move_wall(self, position: FloatArray) -> None:
        """Put the middle of the wall that was nearest elsewhere.

        Raises:
            ValueError: If the robot or the target is there.
        """
        walls = self._walls()
        walls[self._nearest] += position - walls[self._nearest].mean(axis=0)
        self._set(obstacles=[wall.tolist() for wall in walls])

    def _middle_of_nearest(self) -> FloatArray:
        """The middle (2,) of the wall that is nearest now, which is then the one that moves."""
        position = self.episode.info["position"][0]
        middles = np.stack([wall.mean(axis=0) for wall in self._walls()])
        self._nearest = int(np.linalg.norm(middles - position, axis=1).argmin())
        nearest: FloatArray = middles[self._nearest]
        return nearest

    def _walls(self) -> list[FloatArray]:
        """The corners of each wall, (N, 2), m."""
        env: Any = self.episode.env.unwrapped
        return [np.array(vertices, np.float64) for vertices in env.maps[0].obstacles]

    def _set(self, **changes: Any) -> None:
        """Change the world: its start, target or obstacles, as lists; the others stay."""
        info = self.episode.info
        world = {
            "start": info["position"][0].tolist(),
            "target": info["target"][0].tolist(),
            "obstacles": [wall.tolist() for wall in self._walls()],
        }
        self.episode.relocate(world | changes)
