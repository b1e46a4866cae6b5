"""Reaching: an arm, what it takes for its body, its target and what it keeps off."""

from collections.abc import Mapping
from functools import partial
from typing import ClassVar

import numpy as np

from aicon_baselines.palette import (
    AWAY,
    BELIEF,
    BODY,
    EXPLORING,
    RESOLVED,
    TARGET,
    TOWARDS,
)
from aicon_baselines.view.arm import ArmScene
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import Handle
from aicon_baselines.worlds.shape import spread_axes

_RADIUS = 0.015  # m; the target as a ball


class ReachScene(ArmScene):
    """An arm that reaches, in the frame of its root, m."""

    title: ClassVar[str] = (
        "An arm reaches for a pose. Its goals are the target and, before that, its joints' "
        "limits and the gaps to itself and to the ball."
    )
    legend: ClassVar[Mapping[str, str]] = {
        "target": TARGET,
        "the body as it knows it": BODY,
        "the ball as it believes it (2σ)": BELIEF,
        "gradient: reach": TOWARDS,
        "shortest gap to the ball": AWAY,
        "motion of the tip, descending": RESOLVED,
        "motion of the tip, exploring": EXPLORING,
    }
    remaining_curves: ClassVar[Mapping[str, str]] = {"distance": TARGET, "angle": BELIEF}
    hint: ClassVar[str] = "Drag the arrows at the target or at the ball to put it elsewhere."

    def draw_beliefs(self) -> None:
        """Draw the body, the target and the balls as the policy knows them."""
        values = self.episode.trace.values
        segments = values["x_body"][0].numpy(force=True)
        self.draw_body(segments)
        self.shapes.ball("target", values["x_target"][0, :3].numpy(force=True), _RADIUS, TARGET)

        for number in range(1, self._balls + 1):
            ball = values[f"x_ball_{number}"][0, :3].numpy(force=True)
            covariance = values[f"P_ball_{number}"][0, :3, :3].numpy(force=True)
            radius = float(self.model.geom(f"ball_{number}").size[0])
            axes = spread_axes(covariance) + 1.05 * radius * np.eye(3)
            self.shapes.ellipsoid(f"ball_{number}.belief", ball, axes, BELIEF, opacity=0.35)
            self._draw_gap(f"ball_{number}.gap", segments, ball)

    def handles(self) -> Mapping[str, Handle]:
        """The target and the balls."""
        moves = {"target": self.env.move_target}
        for number in range(1, self._balls + 1):
            moves[f"ball {number}"] = partial(self.env.move_ball, number)

        handles = {}
        for index, (name, move) in enumerate(moves.items()):
            place = self.data.mocap_pos[index]
            handles[name] = self.handle(place.copy, move, (True, True, True))
        return handles

    def _draw_gap(self, name: str, segments: FloatArray, ball: FloatArray) -> None:
        """Draw the shortest line from the body's segments (C, 6) to a ball's middle (3,)."""
        starts, ways = segments[:, :3], segments[:, 3:] - segments[:, :3]
        lengths = np.maximum((ways**2).sum(axis=1), 1e-12)
        shares = np.clip(((ball - starts) * ways).sum(axis=1) / lengths, 0.0, 1.0)

        points = starts + shares[:, np.newaxis] * ways
        nearest = np.linalg.norm(points - ball, axis=1).argmin()
        self.shapes.polyline(name, [points[nearest], ball], AWAY)

    @property
    def _balls(self) -> int:
        """Number of balls; the first body that is placed by hand is the target."""
        return int(self.model.nmocap) - 1
