"""What LeRobot does with observations before AICON, and with its actions after.

Nothing is normalised.
"""

from typing import Any

from lerobot.processor import (
    AddBatchDimensionProcessorStep,
    DeviceProcessorStep,
    PolicyProcessorPipeline,
    RenameObservationsProcessorStep,
)
from lerobot.processor.converters import policy_action_to_transition, transition_to_policy_action
from lerobot.utils.constants import (
    POLICY_POSTPROCESSOR_DEFAULT_NAME,
    POLICY_PREPROCESSOR_DEFAULT_NAME,
)

from lerobot_policy_aicon.configuration_aicon import AiconConfig

Pipeline = PolicyProcessorPipeline[Any, Any]


def make_aicon_pre_post_processors(
    config: AiconConfig, dataset_stats: dict[str, Any] | None = None
) -> tuple[Pipeline, Pipeline]:
    """Return what runs before and after the policy.

    Args:
        config: Options of the policy.
        dataset_stats: LeRobot's argument for other policies; there are no statistics to use.
    """
    preprocessor = Pipeline(
        steps=[
            RenameObservationsProcessorStep(rename_map={}),
            AddBatchDimensionProcessorStep(),
            DeviceProcessorStep(device=config.device or "cpu"),
        ],
        name=POLICY_PREPROCESSOR_DEFAULT_NAME,
    )

    postprocessor = Pipeline(
        steps=[DeviceProcessorStep(device="cpu")],
        name=POLICY_POSTPROCESSOR_DEFAULT_NAME,
        to_transition=policy_action_to_transition,
        to_output=transition_to_policy_action,
    )

    return preprocessor, postprocessor
