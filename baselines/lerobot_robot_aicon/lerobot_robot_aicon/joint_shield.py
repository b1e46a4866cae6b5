"""A shield for the positions that LeRobot sends to an arm."""

from collections.abc import Mapping
from operator import itemgetter
from typing import Any

from aicon_torch import Shield
from aicon_torch.inspection.shielding import Shielding
from aicon_torch.models.reach import Options, body_model, towards
from aicon_torch.parts import Robot
from aicon_torch.shield import NOMINAL, ShieldState
from lerobot_robot_aicon.arm_options import ArmOptions, ShieldOptions, described_arm
from lerobot_robot_aicon.commanded_joints import ArmState, CommandedJoints
from lerobot_robot_aicon.measured_joints import REMEDY
from lerobot_robot_aicon.motors import check_mapping, finite

WANTED = "wanted"
"""The observation's key of where the joints are sent, rad."""

OVERLAP = 0.03
"""An arm that seems to stand farther within the margins of the table or of itself, m, does not
stand as it is described, and is not moved."""

CHANGED = 0.02
"""An action that is changed by more than this, rad/s, has been interfered with."""


def posture_shield(
    arm: Robot, options: ArmOptions, table: float | None = None, goes_around: bool = True
) -> Shield:
    """A shield for who sends the joints of an arm, ``"q"``, to the posture ``WANTED``.

    Args:
        arm: The arm.
        options: Its speed, and how many actions there are in a second.
        table: Height of a table in the frame of the base, m; None for no table.
        goes_around: Whether it goes around what is in the way, or stays there.
    """
    body = Options(
        robot=arm,
        speed=options.speed,
        dt=1.0 / options.fps,
        watchdog=False,  # what it reads are commands, which neither age nor freeze
    )
    wanted = itemgetter(WANTED)
    return Shield(wanted, body_model(body, table), nominal=towards, goes_around=goes_around)


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
        self._shield = posture_shield(
            arm, options, table=options.table, goes_around=options.goes_around
        ).compile()
        self.joints = CommandedJoints(arm.chain, options)
        self._middle = arm.chain.middle.numpy()
        self.reset()

    def warm_up(self) -> None:
        """Compile it, which the first step does: no arm shall wait for that."""
        self._shield.predict({"q": self._middle, WANTED: self._middle})

    def reset(self) -> None:
        """Begin anew."""
        self._state: ShieldState | None = None
        self._arm: ArmState | None = None
        self.joints.reset()

    def __call__(
        self, observation: Mapping[str, Any], action: Mapping[str, Any]
    ) -> dict[str, float]:
        """The nearest action that is allowed.

        While a motor shows what cannot be, the arm is held; if it was moved by force, it is sent
        to where it is before it is sent where it is told: see :class:`CommandedJoints`. Until two
        readings agree on where it stands, its joints are left out of the action.

        Args:
            observation: Where the motors are, degrees.
            action: Where they are sent, degrees. What is not finite stays where it is.

        Raises:
            ValueError: If an episode begins with an arm that does not stand as it is described, the
                observation lacks a motor, or something of either is no number.
        """
        check_mapping("action", action, self.joints.keys)
        told = finite(action)
        self._arm = arm = self.joints.look(observation)
        if arm.is_held:
            others = {key: value for key, value in told.items() if key not in self.joints.keys}
            return {**others, **self.joints.stays()}

        stays = self.joints.motors.written(arm.commanded)
        wanted = self.joints.motors.told({**stays, **told}, arm.commanded)
        if arm.is_displaced:
            wanted = arm.measured
        proposed = {"q": arm.commanded, WANTED: wanted}
        velocity, state = self._shield.predict(proposed, self._state)
        if arm.begins:
            self._check_links(state)

        self._state = state
        return {**told, **self.joints.moved(arm.commanded, velocity)}

    def is_changed(self) -> bool:
        """Whether the last action is another one than was asked for, as fast as it may be."""
        if self._arm is not None and (self._arm.is_held or self._arm.is_displaced):
            return True
        if self._state is None:
            return False

        memory, actuator = self._state.memory, self._shield.model.actuators["a"]
        difference = (memory["a"] - actuator.clip(memory[NOMINAL])).abs().max()
        return float(difference) > CHANGED

    def _check_links(self, state: ShieldState) -> None:
        """Check that the arm stands neither in the table nor in itself; its stops are checked."""
        model = self._shield.model
        values = model.values(state.memory)
        for goal in model.goals.values():
            if goal.safety and not goal.has_room:  # links; stops have room
                gap = float(goal.gaps(values).min())
                if gap < -OVERLAP:
                    raise ValueError(
                        f"{goal.name}: the arm seems to be {-100 * gap:.0f} cm within its margin, "
                        f"so it {REMEDY}"
                    )

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first, and while held."""
        is_held = self._arm is not None and self._arm.is_held
        return None if self._state is None or is_held else self._shield.explain(self._state)
