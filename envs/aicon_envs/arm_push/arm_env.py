"""What the environments of arms have in common: MuJoCo's scene, pictures of it, the episode."""

from collections.abc import Sequence
from typing import Any, Generic, TypeVar

import gymnasium as gym
import mujoco
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from aicon_envs.arm_push.rendering import Camera
from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_render_mode, check_size


class ArmSimulation:
    """A scene of MuJoCo in which an arm moves.

    Args:
        model: The compiled scene, in which the arm's tip is the site "tip".
        joints: Names of the arm's n joints.
        low: Lower limits of the joints, ``(n,)``, rad or m; −∞ where there is none.
        high: Upper limits.
        control_step: Duration of a control step, s.

    Attributes:
        model: The compiled scene.
        data: Its state.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        joints: Sequence[str],
        low: FloatArray,
        high: FloatArray,
        control_step: float,
    ) -> None:
        """Find the joints and the tip."""
        self.model, self.data = model, mujoco.MjData(model)
        self._low, self._high = low, high
        self._substeps = round(control_step / model.opt.timestep)
        self._positions = np.array([model.joint(name).qposadr[0] for name in joints])
        self._velocities = np.array([model.joint(name).dofadr[0] for name in joints])
        self._tip = model.site("tip").id

    @property
    def joints(self) -> FloatArray:
        """Values of the joints, ``(n,)``, rad or m."""
        values: FloatArray = self.data.qpos[self._positions]  # a copy
        return values

    @property
    def speeds(self) -> FloatArray:
        """Velocities of the joints, ``(n,)``, rad/s or m/s."""
        values: FloatArray = self.data.qvel[self._velocities]  # a copy
        return values

    def margin(self) -> float:
        """Return the smallest distance of a joint to its limits, now, rad or m."""
        joints = self.joints
        return float(np.minimum(joints - self._low, self._high - joints).min())


World = TypeVar("World", bound=ArmSimulation)
Episode = TypeVar("Episode")


class ArmEnv(gym.Env[dict[str, NDArray[Any]], NDArray[np.float32]], Generic[World, Episode]):
    """An arm in MuJoCo: a world, and what a reset fixes of an episode.

    Contexts to render in are opened when they are first used.
    """

    _simulation: World
    _episode: Episode | None = None

    outside_only: tuple[int, ...] = ()
    """Groups of shapes that no other camera sees than the one outside."""

    def __init__(self, render_mode: str | None, render_width: int, render_height: int) -> None:
        """Check how pictures are rendered."""
        self.render_mode = check_render_mode(render_mode)
        self._render_size = check_size("render", render_width, render_height)
        self._cameras: dict[str, Camera] = {}

    @property
    def model(self) -> mujoco.MjModel:
        """The scene of MuJoCo."""
        return self._simulation.model

    @property
    def data(self) -> mujoco.MjData:
        """The state of MuJoCo's scene."""
        return self._simulation.data

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture from outside, if `render_mode` is "rgb_array"."""
        return None if self.render_mode is None else self.picture("outside")

    def picture(self, camera: str, size: tuple[int, int] | None = None) -> NDArray[np.uint8]:
        """Return a picture of a camera of the scene, of a width and a height, px."""
        self._current_episode()
        width, height = self._render_size if size is None else check_size("picture", *size)
        opened = self._open_camera(f"{width}×{height} px of {camera}", camera, width, height)
        color, _ = opened(self.data)
        return color

    def close(self) -> None:
        """Give the contexts of the cameras back."""
        for camera in self._cameras.values():
            camera.close()

        self._cameras.clear()

    def __getstate__(self) -> dict[str, Any]:
        """Leave the contexts of the cameras out of copies, which open their own."""
        return self.__dict__ | {"_cameras": {}}

    def _open_camera(self, key: str, name: str, width: int, height: int) -> Camera:
        """Return the camera of a key."""
        if key not in self._cameras:
            shows = self.outside_only if name == "outside" else ()
            self._cameras[key] = Camera(self.model, name, width, height, shows)

        return self._cameras[key]

    def _current_episode(self) -> Episode:
        if self._episode is None:
            raise ResetNeeded("the environment must be reset first")

        return self._episode
