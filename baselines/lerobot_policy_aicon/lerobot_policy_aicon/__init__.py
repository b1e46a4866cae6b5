"""AICON as a policy of LeRobot; importing this registers `--policy.type=aicon`."""

from lerobot_policy_aicon.configuration_aicon import AiconConfig
from lerobot_policy_aicon.modeling_aicon import AiconPolicy
from lerobot_policy_aicon.processor_aicon import make_aicon_pre_post_processors

__all__ = ["AiconConfig", "AiconPolicy", "make_aicon_pre_post_processors"]
