"""Navigation: a disc, its trap, and where it believes its target."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.view.canvas import FloatArray
from aicon_baselines.view.scene import GradientArrow, Scene
from aicon_baselines.view.style import (
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
    Color,
)

_MARGIN = 0.9  # m of ground around what there is
_ARRIVAL = 0.2  # m
_LOOKS = {
    ("reach", "p_tar"): ("reach the target", TOWARDS),
    ("reach", "P_tar"): ("know it better", CERTAINTY),
    ("avoid", "x_obs"): ("avoid the wall", AWAY),
}


class NavigationScene(Scene):
    """The trap from above, in the world's frame, m."""

    title: ClassVar[str] = (
        "A robot looks for its target. It knows neither a map nor where it is: it sees the "
        "direction of the target and feels how near the next wall is."
    )
    legend: ClassVar[dict[str, Color]] = {
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
    curves: ClassVar[Mapping[str, Color]] = {label: color for label, color in _LOOKS.values()}
    trail_length: ClassVar[int] = 1000
    hint: ClassVar[str] = "Drag the arrows at the target to put it elsewhere."

    def draw_world(self) -> None:
        """Draw the ground, the walls and the target."""
        env: Any = self.episode.env.unwrapped
        world = env.maps[0]
        self._radius = env.physics.radius

        obstacles = [np.array(vertices) for vertices in world.obstacles]
        points = np.concatenate([*obstacles, [world.start], [world.target]])
        low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
        self.canvas.fit(low, high)

        ground = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        self.canvas.fill("ground", [ground], GROUND, 0)
        self.canvas.fill("obstacles", obstacles, OBSTACLE, 2)

    def draw_moving(self) -> None:
        """Draw the robot, its trail, its beliefs and its gradients."""
        canvas, info = self.canvas, self.episode.info
        position, target = info["position"][0], info["target"][0]
        values = self.episode.trace.values

        canvas.disc("target", target, _ARRIVAL, TARGET, 4)
        above = canvas.to_scene(target + np.array([0.0, 1.2 * _ARRIVAL]), 30)
        canvas.text("target.label", "target", above)

        # It believes the target relative to itself; the true position places that in the world.
        mean = position + values["p_tar"][0].numpy(force=True)
        covariance = values["P_tar"][0].numpy(force=True)
        canvas.ellipse("belief.spread", mean, covariance, BELIEF, 6, opacity=0.3)
        canvas.disc("belief.mean", mean, 0.4 * _ARRIVAL, BELIEF, 8)
        below = canvas.to_scene(mean - np.array([0.0, 0.9 * _ARRIVAL]), 30)
        canvas.text("belief.label", "believed here", below, scale=0.8)

        # The nearest wall as it feels it: so far, against the slope of the clearance.
        distance, *slope = values["x_obs"][0].tolist()
        uphill = np.array(slope) / max(np.linalg.norm(slope), 1e-9)
        wall = position - (max(distance, 0.0) + self._radius) * uphill
        canvas.line("wall", [position, wall], AWAY, 12, thickness=1.5)

        self.draw_trail(position, TRAIL, 10)
        canvas.disc("robot", position, self._radius, ROBOT, 14)
        self.draw_arrows(position)

    def arrows(self) -> list[GradientArrow]:
        """The three gradients at the robot's displacement."""
        meeting = self.episode.meeting
        gradients = meeting.gradients[0].numpy(force=True)
        strengths = (meeting.strengths[0]).tolist()

        found = []
        for index, path in enumerate(meeting.paths):
            goal, quantity = path[:2]
            label, color = _LOOKS.get((goal, quantity), (f"{goal} → {quantity}", CERTAINTY))
            found.append(GradientArrow(label, color, -gradients[index], strengths[index]))
        return found

    def strengths(self) -> dict[str, float]:
        """The strength of each gradient, by what it wants."""
        return {arrow.label: arrow.strength for arrow in self.arrows()}

    def distance_left(self) -> str:
        """The distance to the target."""
        return f"{self.episode.info['distance'][0]:.2f} m to the target"

    def target(self) -> tuple[FloatArray, float]:
        """The target; a point has no angle."""
        return self.episode.info["target"][0], 0.0

    def move_target(self, position: FloatArray, angle: float) -> None:
        """Put the target elsewhere, in the same map."""
        env: Any = self.episode.env.unwrapped
        start = self.episode.info["position"][0].tolist()
        self.episode.relocate(
            {"obstacles": env.maps[0].obstacles, "start": start, "target": position.tolist()}
        )
