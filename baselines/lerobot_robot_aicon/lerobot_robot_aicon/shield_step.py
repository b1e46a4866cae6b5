"""The shield as a step of a LeRobot processor."""

from dataclasses import asdict, dataclass
from typing import Any

from lerobot.processor import ProcessorStepRegistry, RobotActionProcessorStep, TransitionKey

from aicon_torch.inspection.shielding import Shielding
from lerobot_robot_aicon.arm_options import ShieldOptions
from lerobot_robot_aicon.joint_shield import JointShield


@ProcessorStepRegistry.register("aicon_shield")
@dataclass(kw_only=True)
class ShieldStep(ShieldOptions, RobotActionProcessorStep):
    """Sends the joints as near to where they are told to go as is allowed.

    It is the last step before the robot, and reads the joints in the observation; angles are in
    degrees. See :class:`JointShield`.
    """

    def __post_init__(self) -> None:
        """Build the shield and compile it."""
        self._shield = JointShield(self)
        self._shield.warm_up()

    def action(self, action: dict[str, Any]) -> dict[str, Any]:
        """The nearest action that is allowed."""
        return self._shield(self.transition.get(TransitionKey.OBSERVATION), action)

    def explain(self) -> Shielding | None:
        """What was changed in the last action, and why; None before the first, and while held."""
        return self._shield.explain()

    def reset(self) -> None:
        """Begin anew."""
        self._shield.reset()

    def get_config(self) -> dict[str, Any]:
        """The options, as a saved processor has them."""
        return asdict(self)

    def transform_features(self, features: Any) -> Any:
        """The same features."""
        return features
