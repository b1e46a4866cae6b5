"""A shield for the positions that LeRobot sends to an arm."""

from collections.abc import Mapping
from typing import Any

from aicon_torch import Shield
from aicon_torch.inspection.shielding import Shielding
from aicon_torch.models.reach import Options, body_model, towards
from aicon_torch.shield import ShieldState
from lerobot_robot_aicon.arm_options import ShieldOptions, described_arm
from lerobot_robot_aicon.commanded_joints import CommandedJoints

WANTED = "wanted"
"""The observation's key of where the joints are sent, rad."""


class JointShield:
    """Where an arm may be sent, as near as its stops, a table and its own links allow.

    Joints that the description does not have, such as a gripper's, go as they are told.

    Args:
        options: The arm and its bounds.

    Attributes:
        joints: The joints as they were commanded.
    """

    def __init__(self, options: ShieldOptions) -> None:
        arm = described_arm(options)
        body = Options(robot=arm, speed=options.speed, dt=1.0 / options.fps)
        model = body_model(body, options.table)
        shield = Shield(_wanted, model, nominal=towards, goes_around=options.goes_around)

        self._shield = shield.compile()
        self.joints = CommandedJoints(arm.chain.names, options)
        self._middle = arm.chain.middle.numpy()
        self.reset()

    def warm_up(self) -> None:
        """Compile it, which the first step does: no arm shall wait for that."""
        self._shield.predict({"q": self._middle, WANTED: self._middle})

    def reset(self) -> None:
        """Begin anew."""
        self._state: ShieldState | None = None
        self.joints.reset()

    def __call__(
        self, observation: Mapping[str, Any], action: Mapping[str, Any]
    ) -> dict[str, float]:
        """The nearest action that is allowed.

        Args:
            observation: Where the motors are, degrees.
            action: Where they are sent, degrees.
        """
        commanded = self.joints.commanded(observation)
        wanted = self.joints.read({**self.joints.written(commanded), **action})
        proposed = {"q": commanded, WANTED: wanted}
        velocity, self._state = self._shield.predict(proposed, self._state)
        return {**action, **self.joints.moved(commanded, velocity)}

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first."""
        return None if self._state is None else self._shield.explain(self._state)


def _wanted(observation: Mapping[str, Any]) -> Any:
    """Where the joints are sent, rad."""
    return observation[WANTED]
