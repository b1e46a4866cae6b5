"""The simulated robot: physics, sensors, and how an episode's start is reached."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from aicon_envs.arm_push import collision_groups
from aicon_envs.arm_push.arm_env import ArmSimulation
from aicon_envs.arm_push.capsules import Capsule
from aicon_envs.arm_push.inverse_kinematics import reach
from aicon_envs.arm_push.objects import THICKNESS
from aicon_envs.arm_push.scene import TARGET_HEIGHT
from aicon_envs.arm_push.self_distance import self_distance
from aicon_envs.arrays import FloatArray

CONTROL_STEP = 0.01
"""Duration of a control step, s."""

_SETTLING_STEPS = 100
"""Steps of the physics in which the object comes to rest on the table."""

_FALLEN_HEIGHT = -0.02
"""Height of the object's middle below which it has left the table, m."""

_FALLEN_TILT = 0.5
"""Cosine between its axis and the vertical below which it lies on its side."""


class Simulation(ArmSimulation):
    """Physics at 1 kHz under joint velocities that change at 100 Hz.

    Args:
        model: The compiled scene.
        home: Joint angles near which episodes start, ``(n,)``, rad.
        capsules: Those of the robot, which tell its distance to itself, if there are any.

    Attributes:
        wrench: Force (N) and torque (Nm) at the flange, ``(6,)``, mean over the last control step.
        collides: Whether the robot touched itself, or anything but the object with its stick, at
            any time in the last control step.
    """

    def __init__(
        self, model: mujoco.MjModel, home: FloatArray, capsules: Sequence[Capsule]
    ) -> None:
        """Find the bodies and shapes of the scene."""
        joints = [model.joint(number).name for number in range(model.nu)]
        low, high = model.jnt_range[: model.nu].T.copy()
        super().__init__(model, joints, low, high, CONTROL_STEP)
        self._home, self._count = home, model.nu
        self._self_distance = self_distance(model, capsules)

        self._object = model.body("object").id
        self._stick = model.geom("stick").id

        # Shapes of the robot that can touch something, and those of the object.
        robot = model.geom_contype == collision_groups.ROBOT
        self._robot_geoms = set(np.flatnonzero(robot).tolist())
        self._object_geoms = set(np.flatnonzero(model.geom_bodyid == self._object).tolist())

    def start(self, tip: ArrayLike, yaw: float, pose: ArrayLike, target: ArrayLike) -> None:
        """Put the stick upright with its tip at a position, and the object at rest.

        Args:
            tip: Position of the tip, ``(3,)``, m.
            yaw: Angle of the camera's side about the vertical, rad.
            pose: The object's (x, y, θ), m and rad.
            target: Its target (x, y, θ), which pictures from outside show.

        Raises:
            ValueError: If no joint angles near home reach the tip; the state stays as it was.
        """
        joints = reach(self.model, self._home, np.asarray(tip, dtype=np.float64), yaw)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[: self._count] = joints
        self.data.act[:] = joints  # the servos hold what is reached
        self.show_target(target)
        self.place(pose)

        for _ in range(_SETTLING_STEPS):
            mujoco.mj_step(self.model, self.data)

        self.data.time = 0.0
        self.wrench: FloatArray = self.data.sensordata[:6].copy()
        self.collides = self._is_touching()

    def place(self, pose: ArrayLike) -> None:
        """Put the object on the table at (x, y, θ), at rest."""
        x, y, angle = np.asarray(pose, dtype=np.float64).tolist()
        self.data.qpos[self._count :] = (x, y, THICKNESS / 2, *_to_quaternion(angle))
        self.data.qvel[self._count :] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def show_target(self, pose: ArrayLike) -> None:
        """Show the target (x, y, θ) in pictures from outside."""
        x, y, angle = np.asarray(pose, dtype=np.float64).tolist()
        self.data.mocap_pos[0] = (x, y, TARGET_HEIGHT)
        self.data.mocap_quat[0] = _to_quaternion(angle)

    def step(self, velocity: FloatArray, force: FloatArray | None = None) -> None:
        """Move by one control step.

        Args:
            velocity: Of each joint, ``(n,)``, rad/s.
            force: What else acts on the object, ``(3,)``, N.
        """
        external_force = self.data.xfrc_applied[self._object, :3]
        external_force[:] = 0.0 if force is None else force
        self.data.ctrl[:] = velocity

        # The sensor's mean over the control step, and whatever is touched in it.
        total_wrench = np.zeros(6)
        self.collides = False
        for _ in range(self._substeps):
            mujoco.mj_step(self.model, self.data)
            total_wrench += self.data.sensordata[:6]
            self.collides = self.collides or self._is_touching()

        self.wrench = total_wrench / self._substeps  # contact chatters at 1 kHz
        external_force[:] = 0.0
        self._unwind()

    def _unwind(self) -> None:
        """Take back what the integrals of the servos hold beyond the torque that a joint can give.

        A servo's torque is kₚ (integral − angle) − kᵥ velocity. Where something blocks a joint, the
        integral goes no further than to its largest torque (anti-windup), such that the joint turns
        back as soon as it is told to.
        """
        stiffness = self.model.actuator_gainprm[:, 0]
        damping = -self.model.actuator_biasprm[:, 2]
        largest = self.model.jnt_actfrcrange[: self._count, 1]

        middle = self.joints + damping * self.speeds / stiffness
        integrals = self.data.act
        np.clip(integrals, middle - largest / stiffness, middle + largest / stiffness, integrals)

    @property
    def tip(self) -> FloatArray:
        """Position of the stick's tip, ``(3,)``, m."""
        position: FloatArray = self.data.site_xpos[self._tip].copy()
        return position

    @property
    def pose(self) -> FloatArray:
        """The object's (x, y, θ), m and rad."""
        x, y = self.data.xpos[self._object, :2]
        rotation = self.data.xmat[self._object]
        return np.array([x, y, math.atan2(rotation[3], rotation[0])])

    @property
    def fallen(self) -> bool:
        """Whether the object has left the table, or lies on its side."""
        height = self.data.xpos[self._object, 2]
        tilt = self.data.xmat[self._object, 8]
        return bool(height < _FALLEN_HEIGHT or tilt < _FALLEN_TILT)

    @property
    def self_distance(self) -> float:
        """Smallest gap between parts of the robot that can meet, now, m."""
        return self._self_distance(self.data)

    def _is_touching(self) -> bool:
        """Whether the robot touches what it may not, now."""
        pairs: list[list[int]] = self.data.contact.geom.tolist()
        return any(self._is_collision(first, second) for first, second in pairs)

    def _is_collision(self, first: int, second: int) -> bool:
        """Whether two shapes may not touch."""
        touching = {first, second}
        robot = touching & self._robot_geoms

        if not robot:
            return False  # the object on the table

        stick_pushes = robot == {self._stick} and bool(touching & self._object_geoms)
        return not stick_pushes


def _to_quaternion(angle: float) -> tuple[float, float, float, float]:
    """Return the rotation by an angle about the vertical, rad, as (w, x, y, z)."""
    return math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)
