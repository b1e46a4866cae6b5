"""Two arms that share a table: each is in the other's way."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.reach.gaps import SIGHT, seeing_near, smaller
from aicon_envs.reach.robots import Robot
from aicon_envs.reach.scene import PreparedArm, add_sky, prepare_arm, set_physics
from aicon_envs.reach.simulation import ACCELERATION, CONTROL_STEP, WINDUP

PREFIXES = ("first/", "second/")
"""What the names of each arm's bodies begin with."""

TABLE, TABLE_TOP, THICKNESS = "table", -0.02, 0.04
"""Its name, how high it is in the frame of both bases, and how thick, m: arms stand on a plate."""


class PairGaps(NamedTuple):
    """Smallest gaps, m: at most 0.05, and below 0 where something touches."""

    apart: float  # between the arms
    to_itself: float  # of either arm
    to_table: float


class ArmPair:
    """Two arms that face each other across a table, at 500 Hz under joint velocities at 50 Hz.

    The first arm's base is the origin; the second stands along x, and looks back.

    Args:
        first: One robot.
        second: The other.
        distance: Between their bases, m.

    Attributes:
        low: Lower limits of the joints of each arm, ``(n,)`` both, rad or m.
        high: Upper limits.
        gaps: The smallest gaps during the last control step.
    """

    def __init__(self, first: Robot, second: Robot, distance: float) -> None:
        arms = [prepare_arm(robot) for robot in (first, second)]
        self.low, self.high = [arm.low for arm in arms], [arm.high for arm in arms]
        self.model = _compiled(arms, distance)
        self.data = mujoco.MjData(self.model)
        self._substeps = round(CONTROL_STEP / self.model.opt.timestep)

        # By arm: where its joints and servos are.
        joints = [
            [self.model.joint(prefix + name) for name in arm.joints]
            for prefix, arm in zip(PREFIXES, arms, strict=True)
        ]
        self._positions = [np.array([joint.qposadr[0] for joint in each]) for each in joints]
        self._servos = [
            [
                np.array([self.model.actuator(f"{prefix}{name}_{kind}").id for name in arm.joints])
                for kind in ("velocity", "integral")
            ]
            for prefix, arm in zip(PREFIXES, arms, strict=True)
        ]
        self._states = [self.model.actuator_actadr[integral] for _, integral in self._servos]

        # A copy that sees what is near, and whose each shape is.
        self._near = seeing_near(self.model)
        self._near_data = mujoco.MjData(self._near)
        owners = [self.model.body(number).name for number in self.model.geom_bodyid]
        self._owner = np.array([_owner(name) for name in owners])

    def start(self, joints: tuple[FloatArray, FloatArray]) -> None:
        """Put both arms at rest at values of their joints, rad or m."""
        mujoco.mj_resetData(self.model, self.data)
        for values, at, state in zip(joints, self._positions, self._states, strict=True):
            self.data.qpos[at] = values
            self.data.act[state] = values
        mujoco.mj_forward(self.model, self.data)
        self.gaps = self.measure(joints)

    def step(self, velocities: tuple[FloatArray, FloatArray]) -> None:
        """Move by one control step at velocities of their joints, rad/s or m/s."""
        most, data = ACCELERATION * self.model.opt.timestep, self.data
        nearest = PairGaps(SIGHT, SIGHT, SIGHT)
        for _ in range(self._substeps):
            for velocity, (speed, integral) in zip(velocities, self._servos, strict=True):
                command = data.ctrl[speed] + np.clip(velocity - data.ctrl[speed], -most, most)
                data.ctrl[speed] = data.ctrl[integral] = command
            mujoco.mj_step(self.model, data)
            if data.ncon:
                nearest = smaller(nearest, self._among(data))

        # Anti-windup, as one arm alone has it.
        for values, state in zip(self.joints, self._states, strict=True):
            data.act[state] = np.clip(data.act[state], values - WINDUP, values + WINDUP)
        self.gaps = smaller(nearest, self.measure(self.joints))

    def measure(self, joints: tuple[FloatArray, FloatArray]) -> PairGaps:
        """The gaps at values of the joints, rad or m."""
        data = self._near_data
        for values, at in zip(joints, self._positions, strict=True):
            data.qpos[at] = values
        mujoco.mj_kinematics(self._near, data)
        mujoco.mj_collision(self._near, data)
        return self._among(data)

    @property
    def joints(self) -> tuple[FloatArray, FloatArray]:
        """Values of the joints of both arms, rad or m."""
        first, second = (self.data.qpos[at].copy() for at in self._positions)
        return first, second

    def _among(self, data: mujoco.MjData) -> PairGaps:
        """The gaps among the contacts that MuJoCo has listed."""
        owners, distances = self._owner[data.contact.geom], data.contact.dist
        of_table = (owners == TABLE).any(axis=1)
        is_apart = (owners[:, 0] != owners[:, 1]) & ~of_table
        return PairGaps(
            apart=float(distances[is_apart].min(initial=SIGHT)),
            to_itself=float(distances[~is_apart & ~of_table].min(initial=SIGHT)),
            to_table=float(distances[of_table].min(initial=SIGHT)),
        )


def _compiled(arms: Sequence[PreparedArm], distance: float) -> mujoco.MjModel:
    """The scene: both arms and the table."""
    spec = mujoco.MjSpec()
    set_physics(spec)
    add_sky(spec)
    places = (([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]), ([distance, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]))
    for arm, prefix, (place, turn) in zip(arms, PREFIXES, places, strict=True):
        frame = spec.worldbody.add_frame(pos=place, quat=turn)
        spec.attach(arm.spec, prefix=prefix, frame=frame)
    body = spec.worldbody.add_body(name=TABLE, pos=[distance / 2, 0.0, TABLE_TOP - THICKNESS / 2])
    size, wood = [1.0, 1.0, THICKNESS / 2], [0.8, 0.72, 0.6, 1.0]
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, rgba=wood)
    return spec.compile()


def _owner(body: str) -> str:
    """The arm that a body is of, or the table."""
    for prefix in PREFIXES:
        if body.startswith(prefix):
            return prefix
    return TABLE
