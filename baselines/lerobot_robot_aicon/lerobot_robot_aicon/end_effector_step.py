"""From a pose of the end effector to joints, as a step of a LeRobot processor."""

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from lerobot.configs.types import FeatureType, PipelineFeatureType, PolicyFeature
from lerobot.processor import ProcessorStepRegistry, RobotActionProcessorStep, TransitionKey
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aicon_torch import make_policy
from aicon_torch.shield import ShieldState
from lerobot_robot_aicon.arm_options import ArmOptions, described_arm
from lerobot_robot_aicon.commanded_joints import CommandedJoints
from lerobot_robot_aicon.joint_shield import WANTED, posture_shield
from lerobot_robot_aicon.motors import as_number

POSE = ("ee.x", "ee.y", "ee.z", "ee.wx", "ee.wy", "ee.wz")
"""LeRobot's keys of a pose of the tip in the frame of the base: a place, m, and a rotation vector,
rad."""

GRIPPER = ("ee.gripper_pos", "gripper.pos")
"""LeRobot's keys of an opening, before and after."""


@ProcessorStepRegistry.register("aicon_ee_to_joints")
@dataclass(kw_only=True)
class EndEffectorStep(ArmOptions, RobotActionProcessorStep):
    """Moves the joints on the way to a pose of the tip, in the place of inverse kinematics.

    It is the policy of :func:`aicon_torch.make_policy` "reach": no stop is passed, the links stay
    off each other, and where both hold up the way it goes around. Each action is a step on that
    way, not its end; angles are in degrees. An arm that was moved by force is followed likewise.

    Attributes:
        orientation: What of the orientation is meant: "free" for none, "axis" for the direction of
            the tip's axis, which an arm of five joints can reach, "full" for all of it.
        axis: The axis of the tip that "axis" turns, a unit vector in its frame.
    """

    orientation: str = "full"
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Build the policy and compile it."""
        arm = described_arm(self)
        policy = make_policy(
            "reach",
            robot=arm,
            orientation=self.orientation,
            axis=tuple(self.axis),
            speed=self.speed,
            dt=1.0 / self.fps,
            watchdog=False,  # what it reads are commands, which neither age nor freeze
        )
        self._policy = policy.compile()
        self._joints = CommandedJoints(arm.chain, self)
        self._following = posture_shield(arm, self)
        self.reset()

        # The first step compiles it, for which no arm shall wait.
        middle = arm.chain.middle.numpy()
        self._policy.predict({"q": middle, **self._target(np.zeros(6))})

    def action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Where the motors are sent next, in the place of the pose.

        What is not finite of a pose is none, and what is not finite of an opening is not sent. Of
        readings that cannot be true, see :class:`CommandedJoints`; until two agree on where the arm
        stands, there are no motors in the action.

        Raises:
            ValueError: If the action lacks a part of the pose, the observation a motor, something
                of either is no number, or an episode begins with an arm beyond its stops.
        """
        missing = [key for key in POSE if key not in action]
        if missing:
            raise ValueError(f"action: it has no {', '.join(missing)}; expected {', '.join(POSE)}.")

        pose = np.array([as_number("action", key, action.pop(key)) for key in POSE])
        if GRIPPER[0] in action:
            opening = as_number("action", GRIPPER[0], action.pop(GRIPPER[0]))
            if math.isfinite(opening):
                action[GRIPPER[1]] = opening

        arm = self._joints.look(self.transition.get(TransitionKey.OBSERVATION))
        if arm.is_held:
            return {**action, **self._joints.stays()}

        if arm.is_displaced:
            followed = {"q": arm.commanded, WANTED: arm.measured}
            velocity, self._followed = self._following.predict(followed, self._followed)
        else:
            sought = {"q": arm.commanded, **self._target(pose)}
            velocity, self._memory = self._policy.predict(sought, self._memory)
            self._followed = None
        return {**action, **self._joints.moved(arm.commanded, velocity)}

    def reset(self) -> None:
        """Begin anew."""
        self._memory: Any = None
        self._followed: ShieldState | None = None
        self._joints.reset()

    def get_config(self) -> dict[str, Any]:
        """The options, as a saved processor has them."""
        return asdict(self)

    def transform_features(self, features: Any) -> Any:
        """Those of the motors in the place of those of the pose."""
        actions = features[PipelineFeatureType.ACTION]
        for key in (*POSE, GRIPPER[0]):
            actions.pop(key, None)
        for key in (*self._joints.keys, GRIPPER[1]):
            actions[key] = PolicyFeature(type=FeatureType.ACTION, shape=(1,))
        return features

    def _target(self, pose: NDArray[Any]) -> dict[str, NDArray[Any]]:
        """A pose ``(6,)`` as the policy's observation has it."""
        turned = Rotation.from_rotvec(pose[3:])
        place = {"target_position": pose[:3]}
        if self.orientation == "free":
            return place
        if self.orientation == "axis":
            return {**place, "target_orientation": turned.apply(self.axis)}
        return {**place, "target_orientation": turned.as_quat(scalar_first=True)}
