"""The options of AICON in LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.configs.policies import PreTrainedConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_STATE


@PreTrainedConfig.register_subclass("aicon")
@dataclass
class AiconConfig(PreTrainedConfig):
    """Options of the policy on pushT.

    Attributes:
        preset: One of `aicon_torch.presets("pusht")`.
        max_speed: Largest speed of the pusher, m/s, where 512 px of the environment are half a
            metre; None for the preset's own.
    """

    preset: str = "aicon"
    max_speed: float | None = None
    push_to_hub: bool = False

    def validate_features(self) -> None:
        """Reject an environment without keypoints and the pusher's position."""
        observed = self.input_features or {}
        controlled = self.output_features or {}

        is_complete = OBS_ENV_STATE in observed and OBS_STATE in observed and ACTION in controlled
        if not is_complete:
            raise ValueError(
                f"aicon needs {OBS_ENV_STATE} and {OBS_STATE}, and gives {ACTION}: "
                "--env.type=pusht --env.obs_type=environment_state_agent_pos"
            )

    def get_optimizer_preset(self) -> Any:
        """Refuse: there is nothing to train."""
        raise NotImplementedError("aicon is not trained; evaluate it with lerobot-eval")

    def get_scheduler_preset(self) -> None:
        """Return no schedule."""

    @property
    def observation_delta_indices(self) -> None:
        """No observations but the current one."""

    @property
    def action_delta_indices(self) -> None:
        """No actions but the next one."""

    @property
    def reward_delta_indices(self) -> None:
        """No rewards."""
