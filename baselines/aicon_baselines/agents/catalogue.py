"""What the policies of each task are called, as data: what they are loads torch.

A test holds these names to the presets of the models, the ablations and the opponents.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class PolicyNames(NamedTuple):
    """The names of a task's policies.

    Attributes:
        presets: Those of its model, ours first.
        ablations: Ours without a part.
        opponents: What others would do.
    """

    presets: tuple[str, ...]
    ablations: tuple[str, ...]
    opponents: tuple[str, ...]


_AGGREGATIONS = ("pcgrad", "upgrad", "cagrad")

_ARM_PUSH = PolicyNames(
    presets=("aicon", "steepest", "potential_field"),
    ablations=(
        "transpose",
        "without_exploration",
        "weighted_sum",
        "sum_with_exploration",
        "one_rule",
        "without_foresight",
        "foresight_of_a_step",
        "without_friction",
        "without_inset",
        "without_ring",
        "without_trace",
        "tenfold_trace_weight",
        "without_touch",
        "without_upright",
        "without_workspace",
        "without_joint_limits",
        "without_self_collision",
        "without_limit_goals",
    ),
    opponents=_AGGREGATIONS,
)

CATALOGUE: Mapping[str, PolicyNames] = MappingProxyType(
    {
        "nav2d": PolicyNames(
            presets=("aicon", "paper_literal", "steepest", "potential_field"),
            ablations=(
                "without_progress_exit",
                "without_level_hold",
                "without_obstacle_nullspace",
                "weighted_sum",
                "sum_with_exploration",
                "without_exploration",
                "without_softmax",
                "without_hysteresis",
                "one_rule",
                "mechanism_as_in_paper",
            ),
            opponents=(*_AGGREGATIONS, "bug2", "wall_follower"),
        ),
        "pusht": PolicyNames(
            presets=("aicon", "paper_literal", "steepest", "potential_field"),
            ablations=(
                "symmetric_near",
                "symmetric_far",
                "soft_intent",
                "without_facing",
                "without_likelihood_path",
                "without_position_path",
                "without_estimation",
                "uniform_density",
                "without_exploration",
                "weighted_sum",
                "sum_with_exploration",
                "without_softmax",
                "without_hysteresis",
                "without_grouping",
                "second_partner",
                "mechanism_as_in_paper",
                "one_rule",
                "one_rule_without_foresight",
                "text",
                "text_sum",
                "text_steepest",
                "without_smoothing",
                "without_foresight",
                "without_dither",
                "without_lag_compensation",
            ),
            opponents=_AGGREGATIONS,
        ),
        "arm_push": _ARM_PUSH,
        "reach": PolicyNames(
            presets=("aicon", "without_escape", "steepest", "potential_field"),
            ablations=(),
            opponents=(*_AGGREGATIONS, "damped_least_squares", "mink"),
        ),
    }
)
"""By task."""
