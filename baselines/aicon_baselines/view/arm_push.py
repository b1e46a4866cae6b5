"""Pushing with an arm: the arm, the object as it is and as it is believed, and its target."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from aicon_baselines.palette import (
    AWAY,
    BELIEF,
    BODY,
    EXPLORING,
    GOAL,
    OBJECT_RED,
    RESOLVED,
    TOWARDS,
)
from aicon_baselines.view.arm import ArmScene
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import GradientArrow, Handle
from aicon_baselines.view.sides import by_sides
from aicon_baselines.worlds.shape import spread_axes
from aicon_envs.arm_push.objects import THICKNESS
from aicon_envs.arm_push.scene import TARGET_GROUP

_KICK = 0.6  # m/s
_ABOVE = THICKNESS + 0.002  # m; where the belief is drawn


class ArmPushScene(ArmScene):
    """An arm at its table, in the frame of its base, m."""

    title: ClassVar[str] = (
        "An arm pushes an object into its target. Each side of the object has a gradient: touching "
        "it would bring the object nearer to the target, or take it away. The arm keeps its "
        "height, its stick upright, its limits, and off itself."
    )
    legend: ClassVar[Mapping[str, str]] = {
        "object": OBJECT_RED,
        "target": GOAL,
        "where it believes the object (2σ)": BELIEF,
        "the body as it knows it": BODY,
        "gradient: touch that side (the dot)": TOWARDS,
        "gradient: leave that side (the dot)": AWAY,
        "motion of the tip, descending": RESOLVED,
        "motion of the tip, exploring": EXPLORING,
    }
    remaining_curves: ClassVar[Mapping[str, str]] = {"distance": GOAL, "angle": BELIEF}
    hint: ClassVar[str] = "Drag the arrows at the target or at the object to put it elsewhere."
    can_kick: ClassVar[bool] = True
    camera: ClassVar[tuple[FloatArray, FloatArray]] = (
        np.array([1.4, -1.0, 0.8]),
        np.array([0.38, 0.0, 0.22]),
    )
    shown_groups: ClassVar[tuple[int, ...]] = (TARGET_GROUP,)

    def draw_beliefs(self) -> None:
        """Draw the body, and the object with the spread of its position."""
        values = self.episode.trace.values
        self.draw_body(values["x_body"][0].numpy(force=True))

        corners = values["x_keypoints"][0].numpy(force=True)
        outline = np.pad(corners, ((0, 0), (0, 1)), constant_values=_ABOVE)
        self.shapes.polyline("belief", outline, BELIEF, closed=True)

        # A flat ellipsoid: the position on the table.
        spread = np.zeros((3, 3))
        spread[:2, :2] = values["P_pose"][0, :2, :2].numpy(force=True)
        spread[2, 2] = 1e-7
        x, y, _ = values["x_pose"][0].tolist()
        axes = spread_axes(spread)
        self.shapes.ellipsoid("belief.spread", [x, y, _ABOVE], axes, BELIEF, opacity=0.7)

    def arrows(self) -> list[GradientArrow]:
        """The gradient of each side, where those meet; elsewhere that of each goal."""
        meeting, values = self.episode.meeting, self.episode.trace.values
        if meeting.name != "x_pusher":
            return super().arrows()

        contacts = values["x_contact"][0].numpy(force=True)
        places = np.pad(contacts, ((0, 0), (0, 1)), constant_values=THICKNESS / 2.0)
        return by_sides(super().arrows(), meeting.paths, values, places)

    def handles(self) -> Mapping[str, Handle]:
        """The target and the object."""
        flat = (True, True, False)
        return {
            "target": self.handle(lambda: self._above("target"), self._move_target, flat),
            "object": self.handle(lambda: self._above("object"), self._move_object, flat),
        }

    def kick(self) -> None:
        """Give the object a random velocity."""
        self.check_going_on()
        first = self.model.joint("object").dofadr[0]
        heading = self.env.np_random.uniform(-math.pi, math.pi)
        self.data.qvel[first : first + 2] += _KICK * np.array(
            [math.cos(heading), math.sin(heading)]
        )

    def _above(self, body: str) -> FloatArray:
        """A place above a body, (3,)."""
        place: FloatArray = self.data.body(body).xpos + np.array([0.0, 0.0, 0.08])
        return place

    def _move_target(self, position: FloatArray) -> None:
        self.env.move_target([*position[:2], self.episode.info["target_pose"][0, 2]])

    def _move_object(self, position: FloatArray) -> None:
        self.env.move_object([*position[:2], self.episode.info["object_pose"][0, 2]])
