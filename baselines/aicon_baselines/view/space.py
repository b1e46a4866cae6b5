"""A world in MuJoCo, seen in space, and how gradients are drawn in it."""

from collections.abc import Callable
from typing import Any, ClassVar

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from aicon_baselines.view.bodies import MuJoCoBodies
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import GradientArrow, Handle, Scene
from aicon_baselines.view.server import viser
from aicon_baselines.view.shapes import Shapes

_THINNEST = 0.15  # of the thickest arrow


class MuJoCoScene(Scene):
    """A world whose environment has MuJoCo's `model` and `data`, m.

    It is enough for any such environment. Gradients are drawn at the site :attr:`tip`: those of 2
    or 3 numbers as they are, of longer poses the first three; those of joints by the motion that
    descending would give the tip, −J g with the Jacobian J of the site (3, n).

    Args:
        server: The server of the page.
        episode: The episode, started.

    Attributes:
        model: The scene of MuJoCo.
        data: Its state.
        shapes: What is drawn besides.
    """

    tip: ClassVar[str] = "tip"
    """The site at which gradients are drawn; where there is none, they are not."""

    joints: ClassVar[tuple[str, ...]] = ("x_joints", "a")
    """Quantities whose numbers belong to the joints."""

    camera: ClassVar[tuple[FloatArray, FloatArray]] = (
        np.array([1.5, -1.4, 1.1]),
        np.array([0.2, 0.0, 0.4]),
    )
    """Where the view is from, and where it looks, m."""

    arrow_length: ClassVar[float] = 0.16
    arrow_width: ClassVar[float] = 0.012
    shown_groups: ClassVar[tuple[int, ...]] = ()
    handle_size: ClassVar[float] = 0.15

    def __init__(self, server: viser.ViserServer, episode: LiveEpisode) -> None:
        self.shapes = Shapes(server.scene)
        position, target = self.camera
        words_at = target + np.array([0.0, 0.0, 0.6])
        super().__init__(server, episode, self.shapes, words_at)
        self.env: Any = episode.env.unwrapped.envs[0].unwrapped  # type: ignore[attr-defined]
        self.model: mujoco.MjModel = self.env.model
        self.data: mujoco.MjData = self.env.data
        self._bodies: MuJoCoBodies | None = None

        server.scene.set_up_direction("+z")
        server.initial_camera.position = tuple(position.tolist())
        server.initial_camera.look_at = tuple(target.tolist())
        server.initial_camera.fov = 0.7
        server.scene.configure_default_lights(enabled=False)
        server.scene.add_light_ambient("/light/ambient", intensity=0.7)
        server.scene.add_light_directional(
            "/light/sun", intensity=1.0, position=(1.0, -2.0, 4.0), cast_shadow=False
        )

    def draw_world(self) -> None:
        """Draw the bodies, once."""
        if self._bodies is None:
            self._bodies = MuJoCoBodies(self.server, self.model, self.data, self.shown_groups)

    def draw_moving(self) -> None:
        """Draw the bodies and the gradients."""
        assert self._bodies is not None
        self._bodies.draw()
        self.draw_beliefs()
        tail = self.tail()
        if tail is not None:
            self.draw_arrows(tail)

    def draw_beliefs(self) -> None:
        """Draw what the policy believes; nothing, unless a world says how."""

    def tail(self) -> FloatArray | None:
        """Where gradients are drawn, (3,); nowhere where the scene has no such site."""
        return None if self._tip < 0 else self.data.site_xpos[self._tip]

    def way(self, quantity: str, vector: FloatArray) -> FloatArray:
        """The direction (3,) in which a vector at a quantity moves the tip."""
        if quantity in self.joints:
            return self.jacobian() @ vector
        flat = vector[:3]
        return np.pad(flat, (0, 3 - len(flat)))

    def jacobian(self) -> FloatArray:
        """The Jacobian of the tip's position (3, n), by the joints that the action moves."""
        full = np.zeros((3, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, full, None, self._tip)

        (action,) = self.episode.policy.model.actuators.values()
        joints = self.model.actuator_trnid[: action.size, 0]
        columns: FloatArray = full[:, self.model.jnt_dofadr[joints]]
        return columns

    def draw_arrow(
        self, name: str, tail: ArrayLike, arrow: GradientArrow, share: float
    ) -> FloatArray | None:
        """Draw a gradient as the way that descending it gives the tip, all of one length."""
        norm = float(np.linalg.norm(arrow.direction))
        if norm < 1e-9:
            return None

        start = np.array(tail, np.float64)
        along = arrow.direction * arrow.length * self.arrow_length / norm
        width = self.arrow_width * max(share**0.5, _THINNEST)
        self.shapes.arrow(name, start, along, arrow.color, width)
        if arrow.source is not None:
            self.shapes.ball(f"{name}.source", arrow.source, 0.006, arrow.color)
        return start + 1.15 * along

    def check_going_on(self) -> None:
        """Refuse to move anything after the end.

        Raises:
            ValueError: If the episode has ended.
        """
        if self.episode.ended:
            raise ValueError("the episode has ended: reset it first")

    def handle(
        self,
        where: Callable[[], FloatArray],
        move: Callable[[FloatArray], None],
        axes: tuple[bool, bool, bool],
    ) -> Handle:
        """What a hand drags as long as the episode goes on."""

        def move_if_going_on(position: FloatArray) -> None:
            self.check_going_on()
            move(position)

        return Handle(where, move_if_going_on, axes)

    @property
    def _tip(self) -> int:
        """Number of the site of the tip, −1 where there is none."""
        return int(mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_SITE, self.tip))
