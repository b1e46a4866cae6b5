"""pushT: a disc, the object that it pushes, and where the object shall lie."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.palette import (
    AWAY,
    BELIEF,
    EXPLORING,
    GOAL,
    GROUND,
    OBJECT,
    OUTLINE,
    RESOLVED,
    ROBOT,
    TOWARDS,
    TRAIL,
)
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.plane import PlaneScene
from aicon_baselines.view.scene import GradientArrow, Handle
from aicon_baselines.view.sides import by_sides
from aicon_baselines.worlds import Shape, believed, disc, pushing
from aicon_envs.pusht.disturbances import draw_kicked_pose
from aicon_envs.pusht.settings import KICK
from aicon_envs.pusht.simulation import PUSHER_RADIUS, SIZE
from aicon_torch.models.pusht import PIXEL


class PushScene(PlaneScene):
    """The table from above, y down, px."""

    title: ClassVar[str] = (
        "A disc pushes an object into its goal. Each side of the object has a gradient: touching "
        "it would bring the object nearer to the goal, or take it away."
    )
    flipped: ClassVar[bool] = True
    legend: ClassVar[dict[str, str]] = {
        "pusher": ROBOT,
        "object": OBJECT,
        "goal": GOAL,
        "where it believes the object": BELIEF,
        "gradient: touch that side (the dot)": TOWARDS,
        "gradient: leave that side (the dot)": AWAY,
        "motion, descending": RESOLVED,
        "motion, exploring": EXPLORING,
    }
    curves: ClassVar[Mapping[str, str]] = {"strongest to touch": TOWARDS, "to leave": AWAY}
    trail_length: ClassVar[int] = 25
    remaining_curves: ClassVar[Mapping[str, str]] = {"coverage": GOAL}
    hint: ClassVar[str] = "Drag the arrows at the goal or at the object to put it elsewhere."
    can_kick: ClassVar[bool] = True

    def draw_world(self) -> None:
        """Draw the table."""
        env: Any = self.episode.env.unwrapped
        self._env = env.envs[0].unwrapped
        self._object = self._env.object

        corners = np.array([(0.0, 0.0), (SIZE, 0.0), (SIZE, SIZE), (0.0, SIZE)])
        self.canvas.fit((0.0, 0.0), (SIZE, SIZE))
        self.canvas.draw({"table": Shape(corners, 0, GROUND, edge=OUTLINE, width=3.0)})

    def draw_moving(self) -> None:
        """Draw pusher, object, belief, goal and gradients."""
        canvas, info = self.canvas, self.episode.info
        values = self.episode.trace.values
        shapes = pushing(self._object.outline, info["block_pose"][0], info["goal_pose"][0])
        canvas.draw(shapes)
        middle = shapes["goal"].points.mean(axis=0)
        canvas.text("goal.label", "goal", canvas.to_scene(middle, 30))

        # The corners as it believes them; the spread of the position grows with noise.
        corners = values["x_keypoints"][0].numpy(force=True)[list(self._object.border)] / PIXEL
        covariance = values["P_pose"][0, :2, :2].numpy(force=True) / PIXEL**2
        spread = believed(corners.mean(axis=0), covariance, 8, BELIEF)
        belief = Shape(corners, 7, edge=BELIEF, width=3.0)
        canvas.draw({"belief": belief, "belief.spread": spread})

        position = info["pos_agent"][0]
        self.draw_trail(position, TRAIL, 9)
        canvas.draw({"pusher": disc(position, PUSHER_RADIUS, 14, ROBOT)})
        self.draw_arrows(position)

    def arrows(self) -> list[GradientArrow]:
        """The gradient of each side at the pusher."""
        values = self.episode.trace.values
        contacts = values["x_contact"][0].numpy(force=True) / PIXEL
        return by_sides(super().arrows(), self.episode.meeting.paths, values, contacts)

    def strengths(self) -> dict[str, float]:
        """The strongest gradient that touches a side, and the strongest that leaves one."""
        strongest = dict.fromkeys(self.curves, 0.0)
        for arrow in self.arrows():
            curve = "strongest to touch" if arrow.color == TOWARDS else "to leave"
            strongest[curve] = max(strongest[curve], arrow.strength)
        return strongest

    def progress(self) -> str:
        """How much of the goal is covered."""
        covered = self.episode.info["coverage"][0]
        return f"{covered:.0%} of the goal covered"

    def handles(self) -> Mapping[str, Handle]:
        """The goal and the object."""
        return {
            "goal": self.handle(lambda: self._place_of("goal_pose"), self.move_target),
            "object": self.handle(lambda: self._place_of("block_pose"), self.move_object),
        }

    def move_target(self, position: FloatArray) -> None:
        """Put the goal elsewhere; pusher and object stay."""
        x, y = np.clip(position, 0.0, SIZE).tolist()
        info = self.episode.info
        angle = float(info["goal_pose"][0, 2])
        self._set(info["block_pose"][0].tolist(), [x, y, angle])

    def move_object(self, position: FloatArray) -> None:
        """Put the object elsewhere; pusher and goal stay.

        Raises:
            ValueError: If it cannot be there.
        """
        info = self.episode.info
        angle = float(info["block_pose"][0, 2])
        self._set([*position.tolist(), angle], info["goal_pose"][0].tolist())

    def kick(self) -> None:
        """Shift and turn the object at random, as the environment's kicks do."""
        info = self.episode.info
        x, y, angle = info["block_pose"][0].tolist()
        pusher = tuple(info["pos_agent"][0].tolist())
        kicked = draw_kicked_pose(self._object, (x, y, angle), pusher, KICK, self._env.noise)
        self._set(list(kicked), info["goal_pose"][0].tolist())

    def _place_of(self, name: str) -> FloatArray:
        """The position of a pose in `info`, (2,), px."""
        position: FloatArray = self.episode.info[name][0, :2]
        return position

    def _set(self, pose: list[float], goal: list[float]) -> None:
        """Set the poses of object and goal."""
        pusher = self.episode.info["pos_agent"][0].tolist()
        self.episode.relocate({"reset_to_state": [*pusher, *pose], "goal_pose": goal})
