"""A shield for the positions that LeRobot sends to an arm."""

import math
from collections.abc import Mapping
from typing import Any

from aicon_torch import Shield
from aicon_torch.inspection.shielding import Shielding
from aicon_torch.models.reach import Options, body_model, towards
from aicon_torch.shield import NOMINAL, ShieldState
from lerobot_robot_aicon.arm_options import ShieldOptions, described_arm
from lerobot_robot_aicon.commanded_joints import CommandedJoints

WANTED = "wanted"
"""The observation's key of where the joints are sent, rad."""

BEYOND_STOP, OVERLAP = math.radians(10.0), 0.03
"""An arm that seems to stand farther beyond its stops, rad, or within the margins of the table or
of itself, m, does not stand as it is described, and is not moved."""

CHANGED = 0.02
"""An action that is changed by more than this, rad/s, has been interfered with."""


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
        body = Options(
            robot=arm,
            speed=options.speed,
            dt=1.0 / options.fps,
            watchdog=False,  # what it reads are commands, which neither age nor freeze
        )
        model = body_model(body, options.table)
        shield = Shield(_wanted, model, nominal=towards, goes_around=options.goes_around)

        self._shield = shield.compile()
        self._chain = arm.chain
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
            action: Where they are sent, degrees. What is not finite stays where it is.

        Raises:
            ValueError: If an episode begins with an arm that does not stand as it is described.
        """
        commanded = self.joints.commanded(observation)
        finite = {key: value for key, value in action.items() if math.isfinite(value)}
        wanted = self.joints.read({**self.joints.written(commanded), **finite})

        begins = self._state is None
        proposed = {"q": commanded, WANTED: wanted}
        velocity, self._state = self._shield.predict(proposed, self._state)
        if begins:
            self._check_start(commanded, self._state)
        return {**finite, **self.joints.moved(commanded, velocity)}

    def interference(self) -> float:
        """By how much the last action differs from what was asked for, as fast as it may, rad/s."""
        if self._state is None:
            return 0.0
        memory, actuator = self._state.memory, self._shield.model.actuators["a"]
        return float((memory["a"] - actuator.clip(memory[NOMINAL])).abs().max())

    def _check_start(self, joints: Any, state: ShieldState) -> None:
        """Check that the arm stands neither beyond its stops, nor in the table or itself."""
        remedy = (
            "is not moved. Either it is to be moved there by hand, or the description does not "
            "stand as the arm does: see --robot.offsets, --robot.signs and its calibration."
        )
        low, high = self._chain.low.numpy(), self._chain.high.numpy()
        for name, q, least, most in zip(self._chain.names, joints, low, high, strict=True):
            if not least - BEYOND_STOP <= q <= most + BEYOND_STOP:
                found, range_of = math.degrees(q), (math.degrees(least), math.degrees(most))
                raise ValueError(
                    f"{name} seems to stand at {found:.0f}°, beyond its stops, "
                    f"{range_of[0]:.0f}° and {range_of[1]:.0f}°, so the arm {remedy}"
                )

        model = self._shield.model
        values = model.values(state.memory)
        for goal in model.goals.values():
            if goal.safety and not goal.has_room:  # links; stops have room, and are checked above
                gap = float(goal.gaps(values).min())
                if gap < -OVERLAP:
                    raise ValueError(
                        f"{goal.name}: the arm seems to be {-100 * gap:.0f} cm within its margin, "
                        f"so it {remedy}"
                    )

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first."""
        return None if self._state is None else self._shield.explain(self._state)


def _wanted(observation: Mapping[str, Any]) -> Any:
    """Where the joints are sent, rad."""
    return observation[WANTED]
