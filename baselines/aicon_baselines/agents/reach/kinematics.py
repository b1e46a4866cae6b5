"""The robot as inverse kinematics knows it: a model of MuJoCo, with the true shapes."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.reach import Robot
from aicon_envs.reach.scene import build_scene

FloatArray = NDArray[np.float64]


class Kinematics:
    """Where the tip of a robot is, and how it moves with the joints.

    Args:
        robot: The file of its URDF.
        tip: The link that reaches.
        srdf: Says which links need not be compared; None if there is no such file.
        balls: Number of balls in the scene.
        ball_radius: Their radius, m.
        speed: Largest speed of the joints that turn, rad/s.

    Attributes:
        model: The scene.
        data: Its state.
        low: Lower limits of the joints, ``(n,)``, rad or m; −∞ where there is none.
        high: Upper limits.
        speed: Largest speeds, ``(n,)``, rad/s or m/s.
    """

    def __init__(
        self,
        robot: str,
        tip: str,
        srdf: str | None,
        balls: int,
        ball_radius: float,
        speed: float,
    ) -> None:
        scene = build_scene(Robot(robot, tip, srdf), balls, ball_radius)
        self.model, self.data = scene.model, mujoco.MjData(scene.model)
        self.joints = scene.joints
        self.low, self.high = scene.low, scene.high
        self.speed = np.where(scene.turns, np.minimum(scene.speed, speed), scene.speed)

        self._positions = np.array([self.model.joint(name).qposadr[0] for name in scene.joints])
        self._velocities = np.array([self.model.joint(name).dofadr[0] for name in scene.joints])
        self._tip = self.model.site("tip").id

    def full_positions(self, joints: FloatArray) -> FloatArray:
        """Return MuJoCo's `qpos` at values of the joints ``(n,)``."""
        positions: FloatArray = self.model.qpos0.copy()
        positions[self._positions] = joints
        return positions

    def own(self, velocities: FloatArray) -> FloatArray:
        """Return the velocities of the joints ``(n,)`` among those of MuJoCo."""
        own: FloatArray = velocities[self._velocities]
        return own

    def move(self, joints: FloatArray) -> None:
        """Take the joints to values, ``(n,)``."""
        self.data.qpos[:] = self.full_positions(joints)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def tip(self) -> tuple[FloatArray, FloatArray]:
        """Return position ``(3,)``, m, and rotation ``(3, 3)`` of the tip."""
        position = self.data.site_xpos[self._tip].copy()
        return position, self.data.site_xmat[self._tip].reshape(3, 3).copy()

    def jacobian(self) -> FloatArray:
        """Return the Jacobian ``(6, n)`` of the tip's position and rotation."""
        jacobian = np.zeros((6, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, jacobian[:3], jacobian[3:], self._tip)
        own: FloatArray = jacobian[:, self._velocities]
        return own

    def pairs_that_can_meet(self) -> list[tuple[list[int], list[int]]]:
        """Return the pairs of shapes whose contacts count, as mink takes them."""
        model = self.model
        excluded = set(model.exclude_signature.tolist())
        pairs = []
        for first, second in combinations(range(model.ngeom), 2):
            bodies = sorted((model.geom_bodyid[first], model.geom_bodyid[second]))
            signature = (int(bodies[0]) << 16) + int(bodies[1])
            if signature not in excluded and bodies[0] != bodies[1]:
                pairs.append(([first], [second]))
        return pairs


def target_rotation(
    orientation: str, observation: Mapping[str, Any], now: FloatArray
) -> FloatArray:
    """Return the rotation ``(3, 3)`` that the tip should have.

    Args:
        orientation: "free", "axis" or "full".
        observation: That of one episode.
        now: The rotation that it has, ``(3, 3)``.
    """
    if orientation == "free":
        return now

    target = observation["target_orientation"]
    if orientation == "axis":
        return _shortest_turn(now[:, 2], target) @ now

    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, target)
    return matrix.reshape(3, 3)


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Return log R as a vector ``(3,)``: the axis of a rotation times its angle, rad."""
    quaternion, vector = np.zeros(4), np.zeros(3)
    mujoco.mju_mat2Quat(quaternion, rotation.ravel())
    mujoco.mju_quat2Vel(vector, quaternion, 1.0)
    return vector


def _shortest_turn(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the rotation ``(3, 3)`` that takes one direction to another the shortest way."""
    axis = np.cross(start, end)
    sine, cosine = float(np.linalg.norm(axis)), float(start @ end)
    if sine < 1e-9:
        # Any axis across will do where they are opposite.
        axis = np.cross(start, np.eye(3)[np.abs(start).argmin()])

    quaternion, matrix = np.zeros(4), np.zeros(9)
    angle = np.arctan2(sine, cosine)
    mujoco.mju_axisAngle2Quat(quaternion, axis / np.linalg.norm(axis), angle)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
