"""AICON behind LeRobot's interface of policies."""

from typing import Any

from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.constants import OBS_ENV_STATE, OBS_STATE
from torch import Tensor

from aicon_torch import make_policy
from lerobot_policy_aicon.configuration_aicon import AiconConfig


class AiconPolicy(PreTrainedPolicy):
    """`make_policy("pusht")` on batches of environments.

    Args:
        config: Options of the policy.
        **kwargs: LeRobot's other arguments, such as the statistics of a dataset, change nothing.
    """

    config_class = AiconConfig
    name = "aicon"

    def __init__(self, config: AiconConfig, **kwargs: Any) -> None:
        super().__init__(config)
        config.validate_features()

        options = {} if config.max_speed is None else {"max_speed": config.max_speed}
        self._policy: Any = make_policy("pusht", preset=config.preset, **options).compile()
        self.reset()

    def reset(self) -> None:
        """Forget all episodes."""
        self._memory: dict[str, Tensor] | None = None

    def select_action(self, batch: dict[str, Tensor], **kwargs: Any) -> Tensor:
        """Return the next position targets (B, 2), px.

        Args:
            batch: `observation.environment_state` (B, 16) and `observation.state` (B, 2), px.
            **kwargs: LeRobot's other arguments change nothing.
        """
        observation = {
            "environment_state": batch[OBS_ENV_STATE].double(),
            "agent_pos": batch[OBS_STATE].double(),
        }
        action, self._memory = self._policy.predict(observation, self._memory)

        target: Tensor = action.float()
        return target

    def predict_action_chunk(self, batch: dict[str, Tensor], **kwargs: Any) -> Tensor:
        """Return the next action as a chunk of one, (B, 1, 2), px; see `select_action`."""
        return self.select_action(batch).unsqueeze(1)

    def get_optim_params(self) -> dict[str, Any]:
        """Return no parameters."""
        return {}

    def forward(self, batch: dict[str, Tensor]) -> tuple[Tensor, dict[str, Any] | None]:
        """Refuse: there is no loss."""
        raise NotImplementedError("aicon is not trained; evaluate it with lerobot-eval")
