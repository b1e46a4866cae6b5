"""Joint angles at which the stick stands upright at a place."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

HOME = np.array([0.0, 0.3, 0.0, -2.2, 0.0, 2.5, math.pi / 4])
"""Joint angles from which solutions are searched, rad."""

_ITERATIONS = 200
_DAMPING = 1e-6
_MAX_STEP = 0.2
"""Largest change of a joint in an iteration, rad."""

_HOME_GAIN = 0.1
"""Share of the way back home that the nullspace takes in an iteration."""

_CONVERGED = 1e-6
"""Error at which the search ends, m and rad."""

_TOLERANCE = 1e-3
"""Largest error of a solution, m and rad."""


def reach(model: mujoco.MjModel, tip: FloatArray, yaw: float) -> FloatArray:
    """Return joint angles ``(7,)`` with the stick upright at a tip, by damped least squares.

    q⁺ = q + Jᵀ (J Jᵀ + λ I)⁻¹ e + α (I - J⁺ J) (q_home - q), each joint by at most 0.2 rad.

    Args:
        model: The compiled scene.
        tip: Position of the tip ``(3,)``, m.
        yaw: Angle of the camera's side about the vertical, rad.

    Raises:
        ValueError: If there are none near home.
    """
    data = mujoco.MjData(model)
    data.qpos[:7] = HOME
    goal = _upright(yaw)
    error = np.full(6, np.inf)

    for _ in range(_ITERATIONS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        error = _pose_error(model, data, tip, goal)
        if np.abs(error).max() < _CONVERGED:
            break

        jacobian = _tip_jacobian(model, data)
        damped = jacobian @ jacobian.T + _DAMPING * np.eye(6)
        step = jacobian.T @ np.linalg.solve(damped, error)

        # What the tip leaves free goes back home.
        nullspace = np.eye(7) - np.linalg.pinv(jacobian) @ jacobian
        step += _HOME_GAIN * nullspace @ (HOME - data.qpos[:7])
        data.qpos[:7] += np.clip(step, -_MAX_STEP, _MAX_STEP)

    angles: FloatArray = data.qpos[:7].copy()
    low, high = model.jnt_range[:7].T
    within_limits = (angles >= low).all() and (angles <= high).all()
    if np.abs(error).max() > _TOLERANCE or not within_limits:
        raise ValueError(f"no joint angles reach the tip {tip.tolist()} with yaw {yaw:.2f}")

    return angles


def _upright(yaw: float) -> FloatArray:
    """Return the rotation ``(3, 3)`` of the tool with z down and x at an angle, rad."""
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return np.array([[cosine, sine, 0.0], [sine, -cosine, 0.0], [0.0, 0.0, -1.0]])


def _pose_error(
    model: mujoco.MjModel, data: mujoco.MjData, tip: FloatArray, goal: FloatArray
) -> FloatArray:
    """Return what the tip lacks to its goal: position ``(3,)``, m, and rotation ``(3,)``, rad.

    The rotation is ½ Σ a_i × g_i over the axes a of the tool and g of the goal.
    """
    site = model.site("tip").id
    rotation = data.site_xmat[site].reshape(3, 3)

    turn = np.zeros(3)
    for axis in range(3):
        turn += np.cross(rotation[:, axis], goal[:, axis])

    return np.concatenate((tip - data.site_xpos[site], turn / 2))


def _tip_jacobian(model: mujoco.MjModel, data: mujoco.MjData) -> FloatArray:
    """Return the Jacobian ``(6, 7)`` of the tip's position and rotation."""
    position = np.zeros((3, model.nv))
    rotation = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, position, rotation, model.site("tip").id)
    return np.vstack((position, rotation))[:, :7]
