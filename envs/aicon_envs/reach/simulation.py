"""The simulated robot: physics, servos, and what is watched at every one of their steps."""

import mujoco
import numpy as np

from aicon_envs.arm_push.arm_env import ArmSimulation
from aicon_envs.arrays import FloatArray
from aicon_envs.reach.gaps import SIGHT, GapMeter, Gaps, smaller
from aicon_envs.reach.scene import Scene

CONTROL_STEP = 0.02
"""Duration of a control step, s."""

ACCELERATION = 40.0
"""What a servo is commanded changes by at most this, rad/s² or m/s²: a jump of one joint's velocity
would throw the others off theirs."""

WINDUP = 0.05
"""The integral of a servo leads its joint by at most this, rad or m."""


class Simulation(ArmSimulation):
    """Physics at 500 Hz under joint velocities that change at 50 Hz.

    Args:
        scene: The compiled scene.

    Attributes:
        scene: The compiled scene.
        gaps: The smallest gaps during the last control step.
        limit_margin: The smallest distance of a joint to its limits during the last control step,
            rad or m; infinite without limits.
    """

    def __init__(self, scene: Scene) -> None:
        """Make ready to measure gaps."""
        super().__init__(scene.model, scene.joints, scene.low, scene.high, CONTROL_STEP)
        self.scene = scene
        self._measure = GapMeter(scene.model)
        self._elsewhere = mujoco.MjData(scene.model)  # for postures that the robot is not in

    def start(self, joints: FloatArray, balls: FloatArray) -> None:
        """Put the robot at rest.

        Args:
            joints: Values of the joints, ``(n,)``, rad or m.
            balls: Positions of the balls, ``(balls, 3)``, m.
        """
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self._positions] = joints
        self.data.act[:] = joints  # the servos hold what is reached
        self.data.mocap_pos[1:] = balls
        mujoco.mj_forward(self.model, self.data)

        self.gaps = self.measure(joints, balls)
        self.limit_margin = self.margin()

    def step(self, velocity: FloatArray, balls: FloatArray) -> None:
        """Move by one control step.

        Args:
            velocity: Of each joint, ``(n,)``, rad/s or m/s.
            balls: Where the balls are at its end, ``(balls, 3)``, m.
        """
        data, count = self.data, len(velocity)
        most = ACCELERATION * self.model.opt.timestep
        start = data.mocap_pos[1:].copy()
        nearest, margin = Gaps(SIGHT, SIGHT), np.inf

        for number in range(1, self._substeps + 1):
            data.mocap_pos[1:] = start + (balls - start) * (number / self._substeps)
            command = data.ctrl[:count] + np.clip(velocity - data.ctrl[:count], -most, most)
            data.ctrl[:count] = data.ctrl[count:] = command

            mujoco.mj_step(self.model, data)
            if data.ncon:
                nearest = smaller(nearest, self._measure.near(data))
            margin = min(margin, self.margin())

        # Anti-windup: what blocks a joint does not make its servo push harder and harder.
        joints = self.joints
        np.clip(data.act, joints - WINDUP, joints + WINDUP, out=data.act)

        self.gaps = smaller(nearest, self.measure(joints, balls))
        self.limit_margin = margin

    def measure(self, joints: FloatArray, balls: FloatArray) -> Gaps:
        """Return the gaps at values of the joints ``(n,)`` with balls at positions, m."""
        positions, mocap = self.data.qpos.copy(), self.data.mocap_pos.copy()
        positions[self._positions] = joints
        mocap[1:] = balls
        return self._measure(positions, mocap)

    def tip_at(self, joints: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return position ``(3,)``, m, and rotation ``(3, 3)`` of the tip at values of joints."""
        return self._tip_in(self._put_elsewhere(joints))

    def base_points(self, joints: FloatArray) -> FloatArray:
        """Return where the first two joints are, ``(2, 3)``, m, at values of the joints."""
        numbers = [self.model.joint(name).id for name in self.scene.joints[:2]]
        points: FloatArray = self._put_elsewhere(joints).xanchor[numbers]  # a copy
        return points

    def show_target(self, position: FloatArray, rotation: FloatArray) -> None:
        """Show the target in pictures."""
        self.data.mocap_pos[0] = position
        mujoco.mju_mat2Quat(self.data.mocap_quat[0], rotation.ravel())
        mujoco.mj_kinematics(self.model, self.data)

    @property
    def tip(self) -> tuple[FloatArray, FloatArray]:
        """Position ``(3,)``, m, and rotation ``(3, 3)`` of the tip."""
        return self._tip_in(self.data)

    def _put_elsewhere(self, joints: FloatArray) -> mujoco.MjData:
        """Return a state with other values of the joints."""
        self._elsewhere.qpos[self._positions] = joints
        mujoco.mj_kinematics(self.model, self._elsewhere)
        return self._elsewhere

    def _tip_in(self, data: mujoco.MjData) -> tuple[FloatArray, FloatArray]:
        return data.site_xpos[self._tip].copy(), data.site_xmat[self._tip].reshape(3, 3).copy()
