"""Joint angles at which the stick stands upright at a place."""

import math
from collections.abc import Callable

import mujoco
import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.reach.robots import Robot, find_home

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

_TOO_FAR = 4000
"""Where no arm reaches, mm."""


def home_of(model: mujoco.MjModel, arm: Robot) -> FloatArray:
    """Return an arm's home, ``(n,)``, rad: see :func:`aicon_envs.reach.robots.find_home`."""
    low, high = model.jnt_range[: model.nu].T
    return find_home(arm, low, high)


def reach(
    model: mujoco.MjModel,
    home: FloatArray,
    tip: FloatArray,
    yaw: float,
    tolerance: float = _TOLERANCE,
) -> FloatArray:
    """Return joint angles ``(n,)`` with the stick upright at a tip, by damped least squares.

    q⁺ = q + Jᵀ (J Jᵀ + λ I)⁻¹ e + α (I - J⁺ J) (q_home - q), each joint by at most 0.2 rad.

    Args:
        model: The compiled scene.
        home: Joint angles from which the search begins, ``(n,)``, rad.
        tip: Position of the tip ``(3,)``, m.
        yaw: Angle of the camera's side about the vertical, rad.
        tolerance: Largest error of a solution, m and rad.

    Raises:
        ValueError: If there are none near home.
    """
    data = mujoco.MjData(model)
    count = len(home)
    data.qpos[:count] = home
    goal = _upright(yaw)
    error: FloatArray = np.full(6, np.inf)

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
        nullspace = np.eye(count) - np.linalg.pinv(jacobian) @ jacobian
        step += _HOME_GAIN * nullspace @ (home - data.qpos[:count])
        data.qpos[:count] += np.clip(step, -_MAX_STEP, _MAX_STEP)

    angles: FloatArray = data.qpos[:count].copy()
    low, high = model.jnt_range[:count].T
    within_limits = (angles >= low).all() and (angles <= high).all()
    if np.abs(error).max() > tolerance or not within_limits:
        raise ValueError(f"no joint angles reach the tip {tip.tolist()} with yaw {yaw:.2f}")

    return angles


def range_of_tip(model: mujoco.MjModel, home: FloatArray, height: float) -> tuple[float, float]:
    """Return from where to where the upright stick gets, in whole mm from the base's axis, m.

    Args:
        model: The compiled scene.
        home: Joint angles from which the search begins, ``(n,)``, rad.
        height: Of the tip, m.
    """
    data = mujoco.MjData(model)
    data.qpos[: len(home)] = home
    mujoco.mj_kinematics(model, data)
    x, y, _ = data.site("tip").xpos
    direction = np.array([x, y]) / math.hypot(x, y)

    def is_within(distance: int) -> bool:
        tip = np.array([*(distance / 1000.0 * direction), height])
        try:
            reach(model, home, tip, 0.0, tolerance=1e-5)
        except ValueError:
            return False
        return True

    # Home is within; the axis is not, and nothing reaches so far as the other.
    at_home = math.floor(1000.0 * math.hypot(x, y))
    nearest = _last_within(is_within, at_home, 0)
    return nearest / 1000.0, _last_within(is_within, at_home, _TOO_FAR) / 1000.0


def _last_within(is_within: Callable[[int], bool], inside: int, outside: int) -> int:
    """Return the last number on the way from inside to outside that is within, by bisection."""
    while abs(outside - inside) > 1:
        middle = (inside + outside) // 2
        if is_within(middle):
            inside = middle
        else:
            outside = middle
    return inside


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
    """Return the Jacobian ``(6, n)`` of the tip's position and rotation."""
    position = np.zeros((3, model.nv))
    rotation = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, data, position, rotation, model.site("tip").id)
    return np.vstack((position, rotation))[:, : model.nu]
