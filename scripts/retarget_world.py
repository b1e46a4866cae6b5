"""The world of `retarget.py`: a Panda whose points follow those of a reference arm before a wall.

The arm is kinematic, and everything is read as it is: its joints, where the reference's points are,
and the wall, which is a plane x = const.
"""

import functools
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_envs.reach import ROBOTS, find_file
from aicon_torch import (
    Actuator,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    Policy,
    Resolution,
    Sensor,
    WorldModel,
)
from aicon_torch.parts import Chain

Array = NDArray[np.float64]
Place = tuple[int, tuple[float, float, float]]

DT = 0.02  # s
SPEED = 1.0  # rad/s, of each joint; the reference's stay below half of it
SLACK = 0.01  # m, below which a point's error is worth less and less
MARGIN = 0.03  # m, how far before the wall its cost begins
HOME = np.array(ROBOTS["panda"].home)  # rad


@functools.cache
def make_policy(resolution: Resolution, count: int) -> Policy:
    """An arm with so many points, which looks ahead without a dither.

    Reference, wall and its slope are read like everything else. All goals meet at the joints.
    """
    chain, places = panda(), offsets(count)

    def step(v: Tensor, dt: Tensor) -> Tensor:
        return v * dt

    def joints(z_joints: Tensor, x_step: Tensor) -> Tensor:
        return z_joints + x_step

    def depth(q: Tensor, z_wall: Tensor, z_slope: Tensor) -> Tensor:
        deepest = points_of(chain.frames(q), places)[..., 0].amax(-1)
        return z_slope[..., 0] * torch.relu(deepest - z_wall[..., 0] + MARGIN)

    def nearness(index: int) -> Any:
        def cost(q: Tensor, reference: Tensor) -> Tensor:
            error = points_of(chain.frames(q), places[index : index + 1])[..., 0, :] - reference
            distance: Tensor = (error.square().sum(-1) + SLACK**2).sqrt()
            return distance

        return Interconnection(cost, ["q", f"z_point_{index}"])

    joint_count = len(chain.names)
    model = WorldModel(
        sensors={
            "z_joints": Sensor(joint_count, "rad"),
            "z_wall": Sensor(1, "m"),
            "z_slope": Sensor(1, "1"),
            **{f"z_point_{index}": Sensor(3, "m") for index in range(count)},
        },
        actuators={"v": Actuator(joint_count, "rad/s", limit=SPEED)},
        estimators=[Deterministic("x_step", step, is_motion=True), Deterministic("q", joints)],
        goals=[Goal("wall", depth), *(Goal(f"point {i}", nearness(i)) for i in range(count))],
        dt=DT,
    )
    return Policy(model, resolution, Foresight(dither=0.0)).compile()


def panda() -> Chain:
    """The joints of a Panda, up to the point between its fingers."""
    return Chain.from_urdf(find_file(ROBOTS["panda"].urdf), tip=ROBOTS["panda"].tip)


def offsets(count: int) -> list[Place]:
    """Which link each point is fixed to, and where, m: tip, elbow, wrist, then around the tip."""
    sides = [tuple(0.06 * sign * axis) for axis in np.eye(3) for sign in (1.0, -1.0)]
    corners = [tuple(0.07 * np.array(signs) - 0.035) for signs in np.ndindex(2, 2, 2)]
    around = [(-1, place) for place in (*sides, *corners)]
    return [(-1, (0.0, 0.0, 0.0)), (3, (0.0, 0.0, 0.0)), (5, (0.0, 0.0, 0.0)), *around][:count]


def points_of(frames: Tensor, places: list[Place]) -> Tensor:
    """Where the points are, ``(*B, points, 3)``, m, of the links' transforms."""
    points = []
    for link, place in places:
        frame = frames[..., link, :3, :]
        points.append(frame[..., :3] @ frame.new_tensor(place) + frame[..., 3])
    return torch.stack(points, dim=-2)


def references(count: int, tries: int, seconds: float, seed: int) -> tuple[Array, Array]:
    """Where the reference arm is.

    Every joint swings about home in two sines; it begins where the arm is farthest from the wall.

    Returns:
        Joints ``(steps, tries, 7)``, rad, and points ``(steps, tries, points, 3)``, m.
    """
    generator = np.random.default_rng([seed, count])
    steps = round(seconds / DT)
    time = DT * np.arange(2 * steps)[:, None, None, None]

    size = (tries, len(HOME), 2)
    swing = generator.uniform(0.08, 0.2, size)
    period = generator.uniform(4.0, 8.0, size)
    phase = generator.uniform(0.0, 2 * np.pi, size)
    joints = HOME + (swing * np.sin(2 * np.pi * time / period + phase)).sum(-1)
    points = points_of(panda().frames(torch.from_numpy(joints)), offsets(count)).numpy()

    begins = points[:steps, ..., 0].max(-1).argmin(0)
    window = begins + np.arange(steps)[:, None]
    each = np.arange(tries)
    return joints[window, each], points[window, each]


def follow(
    policy: Any, joints: Array, points: Array, walls: Array, slopes: Array
) -> tuple[Array, Array, Array]:
    """Follow references, each try a row of one batch.

    Args:
        policy: Of as many points.
        joints: Of the reference, ``(steps, tries, 7)``, rad; the arm begins where it does.
        points: Of the reference, ``(steps, tries, points, 3)``, m.
        walls: Where they are, ``(tries, 1)``, m.
        slopes: Of their costs, ``(tries, 1)``.

    Returns:
        How deep the deepest point is behind the wall and the mean error of the points, m, and the
        joints, all ``(steps, tries, ...)``.
    """
    chain, places = panda(), offsets(points.shape[2])
    q, memory = joints[0], None
    depths, errors, path = [], [], []
    for reference in points:
        observation = {"z_joints": q, "z_wall": walls, "z_slope": slopes}
        for index in range(points.shape[2]):
            observation[f"z_point_{index}"] = reference[:, index]
        velocity, memory = policy.predict(observation, memory)

        q = q + DT * velocity
        there = points_of(chain.frames(torch.from_numpy(q)), places).numpy()
        depths.append(there[..., 0].max(-1) - walls[:, 0])
        errors.append(np.linalg.norm(there - reference, axis=-1).mean(-1))
        path.append(q)
    return np.array(depths), np.array(errors), np.array(path)
