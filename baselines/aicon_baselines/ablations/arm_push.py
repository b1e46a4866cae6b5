"""Ablations of the arm's policy."""

from collections.abc import Mapping
from typing import Any

from aicon_baselines.ablations.mechanism import (
    ONE_GRADIENT,
    PLAIN_SUM,
    TEXT_SUM,
    WEIGHTED_SUM,
    WITHOUT_FORESIGHT,
)
from aicon_baselines.named import Later

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
    # How a gradient goes from the end effector to the joints, and how conflicts are resolved.
    "transpose": {"pullback": "transpose"},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": WEIGHTED_SUM,
    "sum_with_exploration": PLAIN_SUM,
    # The text's rule by one gradient a step, where the robot is, and a sum in its place. The text's
    # softmax compares gradients as they are: an object goes as far as the stick that touches it.
    "text": {
        "resolution": Later("aicon_torch.resolution:NullspaceProjection.as_in_paper"),
        **WITHOUT_FORESIGHT,
        "contact.step": 1 / 4,
    },
    "text_sum": TEXT_SUM,
    # What keeps the tip from pushing too far, and the object within reach.
    "one_gradient": ONE_GRADIENT,
    "without_foresight": WITHOUT_FORESIGHT,
    "foresight_of_a_step": {"law": Later("aicon_torch.control:Foresight", {"dither": 0.0})},
    "without_friction": {"stick_friction": 0.0},
    "without_inset": {"contact.inset": 0.0},
    "without_ring": {"ring": None},
    # What seeing the object well is worth, and what the wrist feels of it.
    "without_trace": {"camera.trace_weight": 0.0},
    "tenfold_trace_weight": {"camera.trace_weight": 600.0},
    "without_touch": {"touch": False},
    # The goals of the arm.
    "without_upright": {"upright_tolerance": None},
    "without_workspace": {"workspace": None},
    "without_joint_limits": {"joint_limits": None},
    "without_self_collision": {"self_collision": None},
    "without_limit_goals": {"workspace": None, "joint_limits": None, "self_collision": None},
}
"""Options by name, on top of the preset ``"aicon"``."""
