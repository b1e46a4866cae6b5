"""The simulated robot: physics, sensors, and how an episode's start is reached."""

import math

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from aicon_envs.panda_push.clearance import Clearance
from aicon_envs.panda_push.objects import THICKNESS
from aicon_envs.panda_push.scene import TARGET_HEIGHT

FloatArray = NDArray[np.float64]

CONTROL_STEP = 0.01
"""Duration of a control step, s."""

HOME = (0.0, 0.3, 0.0, -2.2, 0.0, 2.5, math.pi / 4)
"""Joint angles from which starts are searched, rad."""


class Simulation:
    """Physics at 1 kHz under joint velocities that change at 100 Hz.

    Args:
        model: The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.substeps = round(CONTROL_STEP / model.opt.timestep)
        self._tip, self._object = model.site("tip").id, model.body("object").id
        self._stick = model.geom("stick").id
        self._robot = [
            geom for geom in range(model.ngeom) if model.geom_contype[geom] == 1
        ]  # everything of the robot that touches
        self._parts = {
            geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == self._object
        }
        self._range = model.jnt_range[:7].copy()
        self._clearance = Clearance(model)

    def start(self, tip: ArrayLike, yaw: float, pose: ArrayLike) -> None:
        """Put the stick upright with its tip at a position, the camera to a side, and the object at rest."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:7] = self._reach(np.asarray(tip, dtype=np.float64), yaw)
        self.data.act[:7] = self.data.qpos[:7]
        self.place(pose)
        for _ in range(100):  # the object comes to rest on the table
            mujoco.mj_step(self.model, self.data)
        self.data.time = 0.0
        self.wrench = self._wrench()

    def place(self, pose: ArrayLike) -> None:
        """Put the object on the table at (x, y, θ), at rest."""
        x, y, angle = np.asarray(pose, dtype=np.float64).tolist()
        self.data.qpos[7:14] = (
            x,
            y,
            THICKNESS / 2,
            math.cos(angle / 2),
            0.0,
            0.0,
            math.sin(angle / 2),
        )
        self.data.qvel[7:13] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def show_target(self, pose: ArrayLike) -> None:
        """Show the target (x, y, θ) in pictures from outside."""
        x, y, angle = np.asarray(pose, dtype=np.float64).tolist()
        self.data.mocap_pos[0] = (x, y, TARGET_HEIGHT)
        self.data.mocap_quat[0] = (math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2))

    def step(self, velocity: FloatArray, force: FloatArray | None = None) -> None:
        """Move by one control step.

        Args:
            velocity: Of each joint, ``(7,)``, rad/s.
            force: What else acts on the object, ``(3,)``, N.
        """
        self.data.ctrl[:7] = velocity
        total = np.zeros(6)
        self.data.xfrc_applied[self._object, :3] = 0.0 if force is None else force
        for _ in range(self.substeps):
            mujoco.mj_step(self.model, self.data)
            total += self.data.sensordata[:6]
        self.wrench = total / self.substeps  # contact chatters at 1 kHz
        self.data.xfrc_applied[self._object, :3] = 0.0

    @property
    def joints(self) -> FloatArray:
        """Joint angles, ``(7,)``, rad."""
        angles: FloatArray = self.data.qpos[:7].copy()
        return angles

    @property
    def speeds(self) -> FloatArray:
        """Joint velocities, ``(7,)``, rad/s."""
        speeds: FloatArray = self.data.qvel[:7].copy()
        return speeds

    @property
    def tip(self) -> FloatArray:
        """Position of the stick's tip, ``(3,)``, m."""
        position: FloatArray = self.data.site_xpos[self._tip].copy()
        return position

    @property
    def pose(self) -> FloatArray:
        """The object's (x, y, θ), m and rad."""
        x, y = self.data.xpos[self._object, :2]
        matrix = self.data.xmat[self._object]
        return np.array([x, y, math.atan2(matrix[3], matrix[0])])

    @property
    def fallen(self) -> bool:
        """Whether the object has left the table, or lies on its side."""
        return bool(
            self.data.xpos[self._object, 2] < -0.02 or self.data.xmat[self._object, 8] < 0.5
        )

    @property
    def collides(self) -> bool:
        """Whether the robot touches itself, or anything but the object with another part than its stick."""
        for contact in self.data.contact[: self.data.ncon]:
            first, second = contact.geom
            robots = (first in self._robot) + (second in self._robot)
            if robots == 2:
                return True
            if robots == 1:
                other, own = (second, first) if first in self._robot else (first, second)
                if own != self._stick or other not in self._parts:
                    return True
        return False

    @property
    def limit_margin(self) -> float:
        """Smallest distance of a joint to its limits, rad."""
        angles = self.joints
        return float(np.minimum(angles - self._range[:, 0], self._range[:, 1] - angles).min())

    @property
    def self_distance(self) -> float:
        """Smallest gap between parts of the robot that can meet, m."""
        return self._clearance(self.data)

    def _wrench(self) -> FloatArray:
        wrench: FloatArray = self.data.sensordata[:6].copy()
        return wrench

    def _reach(self, tip: FloatArray, yaw: float) -> FloatArray:
        """Joint angles with the stick upright at a tip, by damped least squares.

        Raises:
            ValueError: If there are none near home.
        """
        data = mujoco.MjData(self.model)
        data.qpos[:7] = HOME
        goal = np.array(
            [
                [math.cos(yaw), math.sin(yaw), 0.0],
                [math.sin(yaw), -math.cos(yaw), 0.0],
                [0.0, 0.0, -1.0],
            ]
        )
        position, rotation = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        for _ in range(200):
            mujoco.mj_kinematics(self.model, data)
            mujoco.mj_comPos(self.model, data)
            now = data.site_xmat[self._tip].reshape(3, 3)
            turn = sum(np.cross(now[:, axis], goal[:, axis]) for axis in range(3)) / 2
            error = np.concatenate((tip - data.site_xpos[self._tip], turn))
            if np.abs(error).max() < 1e-6:
                break
            mujoco.mj_jacSite(self.model, data, position, rotation, self._tip)
            jacobian = np.vstack((position, rotation))[:, :7]
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-6 * np.eye(6), error)
            # What is left over stays near home.
            null = np.eye(7) - np.linalg.pinv(jacobian) @ jacobian
            step += 0.1 * null @ (np.array(HOME) - data.qpos[:7])
            data.qpos[:7] += np.clip(step, -0.2, 0.2)
        angles: FloatArray = data.qpos[:7].copy()
        if (
            np.abs(error).max() > 1e-3
            or (angles < self._range[:, 0]).any()
            or (angles > self._range[:, 1]).any()
        ):
            raise ValueError(f"no joint angles reach the tip {tip.tolist()} with yaw {yaw:.2f}")
        return angles
