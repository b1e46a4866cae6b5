"""SO-101 lifts a block that may lie too far off for a hand that points down: it is told its joints.

In this folder, with what so101_pick_place.py needs:

    aicon compare --task so101_by_joints:TASK --policies aicon --episodes 250

The world is that of so101_pick_cube.py; its own inverse kinematics is left out. The graph is that
of all that pick and place, in which the velocity of the tip now follows from that of the joints.
One goal more says how a hand is to be held where nothing else asks for it: upright.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import so101_pick_cube
from gymnasium.spaces import Box, Dict
from others import worlds_of
from so101_pick_cube import PickCube
from so101_pick_place import HAND, so101
from torch import Tensor

from aicon_torch import Actuator, Deterministic, Goal, Interconnection, Policy, Sensor
from aicon_torch.models.picking import PRESETS, Options, Surroundings, build_policy
from aicon_torch.parts import Chain, EndEffector, TipPose, norm

__all__ = ["PRESETS", "TASK", "Options", "build"]

SPEED = 2.0  # rad/s, of a joint
LEVER = 0.1  # m: a turn of the hand by 1 rad counts as much as a motion by this
WORTH = 0.03  # m, the error of the place that counts as much as a hand turned by 1 rad
DAMPING = 0.02  # m/rad, of the inverse kinematics

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
MIDDLE = (-0.0009, 0.0, 0.026)  # m, of what the fingers hold, in the frame of the gripper
# The axes of that frame as the world's own kinematics holds it: x down, z from finger to finger.
UPRIGHT = ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0))


class ByJoints(PickCube):
    """The world, told how fast the joints are to turn.

    Args:
        where: Where blocks lie, as for the world that it is.
        render_mode: None, or "rgb_array".
    """

    observation_space = Dict(
        {**PickCube.observation_space.spaces, "z_joints": Box(-np.inf, np.inf, (5,), np.float64)}
    )
    action_space = Dict({"joints": Box(-1.0, 1.0, (5,)), "jaw": Box(0.0, 1.0, (1,))})

    def __init__(self, where: str = "anywhere", render_mode: str | None = None) -> None:
        super().__init__(where, render_mode)
        self.world.apply_action = self._apply
        self.arm = [self.model.actuator(name).id for name in JOINTS]
        self.places = [int(self.model.joint(name).qposadr[0]) for name in JOINTS]

    def step(self, action: Any) -> Any:
        """Turn the joints."""
        return super().step({"tip": action["joints"], "jaw": action["jaw"]})

    def _apply(self, sent: Any) -> None:
        """In the place of the world's inverse kinematics: the servos' angles, and the jaw's."""
        low, high = self.model.actuator_ctrlrange[self.arm].T
        turned = self.data.ctrl[self.arm] + HAND.time_step * SPEED * sent[:5]
        self.data.ctrl[self.arm] = np.clip(turned, low, high)

        jaw = self.model.actuator("gripper")
        self.data.ctrl[jaw.id] = jaw.ctrlrange[0] + sent[5] * np.ptp(jaw.ctrlrange)
        for _ in range(self.world._n_substeps):
            mujoco.mj_step(self.model, self.data)

    def _seen(self, state: Any, success: bool) -> Any:
        observation, info = super()._seen(state, success)
        return observation | {"z_joints": self.data.qpos[self.places].copy()}, info


# --- the policy


@dataclass(frozen=True)
class HeldPoint(TipPose):
    """Where the fingers hold a thing: a point that is fixed in the frame of the gripper.

    Attributes:
        offset: From the origin of that frame, m.
    """

    offset: tuple[float, float, float] = MIDDLE

    def point(self, tool: Tensor) -> Tensor:
        """That point, ``(*B, 3)``, m."""
        return tool[..., :3, 3] + tool[..., :3, :3] @ tool.new_tensor(self.offset)


def build(options: Options) -> Policy:
    """The graph of all that pick and place, with this hand, whose tip follows from the joints."""
    folder = Path(so101().__file__).parents[1] / "assets"
    chain = Chain.from_mjcf(folder / "so101_new_calib.xml", tip="gripperframe")
    end_effector = EndEffector(chain, HeldPoint(lever=LEVER), damping=DAMPING)

    def turned(z_joints: Tensor, joints: Tensor, dt: Tensor) -> Tensor:
        return end_effector(z_joints + joints * dt)

    def moved(x_ee: Tensor, z_joints: Tensor, dt: Tensor) -> Tensor:
        return (x_ee - end_effector(z_joints))[..., :3] / dt

    def upright(x_ee: Tensor) -> Tensor:
        axes = LEVER / math.sqrt(2.0) * x_ee.new_tensor(UPRIGHT).flatten()
        turn = norm(x_ee[..., 3:] - axes) / LEVER
        return WORTH**2 / 2 * turn.square()

    around = Surroundings(
        sensors={"z_joints": Sensor(5, "rad")},
        goals=[Goal("upright", upright)],
        estimators=[
            Deterministic("x_ee", turned),
            Deterministic("tip", Interconnection(moved, ["x_ee", "z_joints", "dt"])),
        ],
        moved_by={
            "joints": Actuator(
                5,
                "rad/s",
                limit=SPEED,
                command=lambda joints: joints / SPEED,
                command_range=(-1.0, 1.0),
            )
        },
    )
    return build_policy(HAND, options, around)


# --- the task

TASK = replace(
    so101_pick_cube.TASK,
    name="so101_by_joints",
    make_env=worlds_of(ByJoints),
    model=__name__,
    agents={},
    lesson=None,
)
