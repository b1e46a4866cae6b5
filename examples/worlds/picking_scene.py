"""What `aicon watch` shows of a gripper that picks up and places: tip, block, place, gradients."""

from collections.abc import Mapping
from functools import partial
from typing import ClassVar

import mujoco
import numpy as np

from aicon_baselines.palette import AWAY, BELIEF, CERTAINTY, EXPLORING, GOAL, RESOLVED, TOWARDS
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import Handle
from aicon_baselines.view.space import MuJoCoScene
from aicon_baselines.worlds.shape import spread_axes

_RADIUS = 0.012  # m; of the place and the tip as balls

PATHS = {
    "x_tip": ("carry", TOWARDS),
    "p_grasp": ("grasp", CERTAINTY),
    "p_free": ("lift", AWAY),
}
"""What a gradient wants that comes along a path from a block's place, by the quantity passed."""


class PickingScene(MuJoCoScene):
    """A gripper and blocks, in the frame of the arm's base, m."""

    title: ClassVar[str] = (
        "A gripper picks a block up and places it. From the goal, paths lead to the tip over the "
        "grasp that is to come, over the table that holds the block back, and over the tip that "
        "carries it. Nothing says in which order."
    )
    legend: ClassVar[Mapping[str, str]] = {
        "the block's place": GOAL,
        "tip, and block as it is believed (2σ)": BELIEF,
        "gradient: grasp": CERTAINTY,
        "gradient: lift": AWAY,
        "gradient: carry": TOWARDS,
        "motion of the tip, descending": RESOLVED,
        "motion of the tip, exploring": EXPLORING,
    }
    remaining_curves: ClassVar[Mapping[str, str]] = {"distance": GOAL}
    hint: ClassVar[str] = "Drag the arrows at a block to put it elsewhere, out of the hand as well."
    handle_size: ClassVar[float] = 0.08
    camera: ClassVar[tuple[FloatArray, FloatArray]] = (
        np.array([0.7, -0.5, 0.45]),
        np.array([0.22, 0.0, 0.06]),
    )
    arrow_length: ClassVar[float] = 0.08
    arrow_width: ClassVar[float] = 0.006

    def draw_beliefs(self) -> None:
        """Draw the tip, and each block and its place as the policy knows them."""
        values = self.episode.trace.values
        self.shapes.ball("tip", self.tail(), _RADIUS / 2, BELIEF)

        for block in (name for name in values if name.startswith("x_object")):
            ending = block.removeprefix("x_object")
            place = values[f"z_goal{ending}"][0].numpy(force=True)
            self.shapes.ball(f"place{ending}", place, _RADIUS, GOAL)

            mean = values[block][0, :3].numpy(force=True)
            spread = values[f"P_object{ending}"][0, :3, :3].numpy(force=True)
            axes = spread_axes(spread) + _RADIUS / 2 * np.eye(3)
            self.shapes.ellipsoid(f"block{ending}", mean, axes, BELIEF, opacity=0.5)

    def tail(self) -> FloatArray:
        """The tip, where it is believed to be, (3,)."""
        place: FloatArray = self.episode.trace.values["x_tip"][0, :3].numpy(force=True)
        return place

    def way(self, quantity: str, vector: FloatArray) -> FloatArray:
        """The direction (3,) of a vector at a quantity; how far fingers open has none."""
        return vector[:3] if len(vector) >= 3 else np.zeros(3)

    def look_of(self, path: tuple[str, ...], goals: tuple[str, ...]) -> tuple[str, str]:
        """What a gradient wants by the path that it came along."""
        for part, look in PATHS.items():
            if any(name.startswith(part) for name in path[1:-1]):
                return look
        return super().look_of(path, goals)

    def handles(self) -> Mapping[str, Handle]:
        """The blocks: what floats freely."""
        free = np.flatnonzero(self.model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        handles = {}
        for joint in free.tolist():
            first = self.model.jnt_qposadr[joint]
            place = self.data.qpos[first : first + 3]
            move = partial(self._move, self.model.jnt_dofadr[joint], place)
            handles[self.model.joint(joint).name] = self.handle(place.copy, move, (True,) * 3)
        return handles

    def _move(self, first: int, place: FloatArray, position: FloatArray) -> None:
        """Put a block to a position (3,), at rest; `place` is where the world keeps it."""
        place[:] = position
        self.data.qvel[first : first + 6] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def headline(self) -> str:
        """What happens, and along which path from a goal the tip is led."""
        led = " → ".join(self.episode.trace.leading_path("tip", (0,)))
        return f"{super().headline()} ({led})"
