"""Ablations: our policies without one part each, or with a part as somebody else would have it.

Each table has for each name the options of :func:`aicon_torch.make_policy` that make it, on top of
the preset ``"aicon"``; the task of the same name takes it. First what is the same in every task.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_baselines.named import Later

WEIGHTED_SUM: Mapping[str, Any] = MappingProxyType({"resolution.projector": "none"})
"""Gradients are added up, by the weights of the softmax."""

PLAIN_SUM: Mapping[str, Any] = MappingProxyType(
    {"resolution.projector": "none", "resolution.temperature": None}
)
"""Gradients are added up as they are; exploration stays."""

ONE_GRADIENT: Mapping[str, Any] = MappingProxyType({"law.iterations": 1, "law.step": 1.0})
"""One gradient a step, taken where the model foresees that the step begins."""

WITHOUT_FORESIGHT: Mapping[str, Any] = MappingProxyType(
    {"law": Later("aicon_torch.control:DirectDescent")}
)
"""One gradient a step, taken where the robot is."""

TEXTS_EXPLORATION: Mapping[str, Any] = MappingProxyType(
    {"resolution.exploration": Later("aicon_torch.resolution:Exploration.as_in_paper")}
)

TEXT_SUM: Mapping[str, Any] = MappingProxyType(
    {**PLAIN_SUM, **TEXTS_EXPLORATION, **WITHOUT_FORESIGHT}
)
"""The text by one gradient a step, but that gradients are added up."""

NAV2D: Mapping[str, Mapping[str, Any]] = {
    "one_gradient": ONE_GRADIENT,
    # The escape from traps: what ends exploration, at which level it moves, and along what.
    "without_progress_exit": {"resolution.exploration.escape.progress": None},
    "without_level_hold": {"resolution.exploration.escape.hold": None},
    "without_obstacle_nullspace": {"resolution.exploration.escape.along": None},
    # The resolution of conflicts.
    "weighted_sum": WEIGHTED_SUM,
    "sum_with_exploration": PLAIN_SUM,
    "without_exploration": {"resolution.exploration": None},
    "without_softmax": {"resolution.temperature": None},
    "without_hysteresis": {"resolution.margin": 0.0},
    "mechanism_as_in_paper": {
        "resolution.relative": False,
        "resolution.exploration.opponent": "second",
        "resolution.exploration.ratio_of": "weights",
        "resolution.exploration.average_time": 1.0,
    },
}
"""Those of the navigation policy."""

PIXEL = 0.5 / 512
"""Length of a pixel, m: that of `aicon_torch.models.pusht`, whose import would load torch."""

_ONE_LIKELIHOOD = {"contact.aim": 0.0, "contact.facing": False}

# The text's softmax compares gradients as they are, so that their scale counts. An object goes as
# far as the pusher that touches it: x_obj moves by s p(d) with p = exp(-d/l), hence s = l.
_TEXT = {
    **TEXTS_EXPLORATION,
    "resolution.relative": False,
    "contact.step": 1 / 4,
}

PUSHT: Mapping[str, Mapping[str, Any]] = {
    # The contact model: one likelihood for all contacts (near or far), a soft choice of two.
    "symmetric_near": {**_ONE_LIKELIHOOD, "contact.reach": 1 / 12},
    "symmetric_far": {**_ONE_LIKELIHOOD, "contact.reaction": 1 / 4},
    "soft_intent": {"contact.intent": 0.1},
    "without_facing": {"contact.facing": False},
    # The two paths of a contact: p₁ leads over its likelihood, p₂ over its position.
    "without_likelihood_path": {"likelihood_path": False},
    "without_position_path": {"position_path": False},
    # What is believed of the world: readings as they come, a T of uniform density.
    "without_estimation": {"estimation": False},
    "uniform_density": {
        "center_of_mass": (0.0, 285 / 7 * PIXEL),
        "radius_of_gyration": 43.9447 * PIXEL,
    },
    # The resolution of conflicts.
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": WEIGHTED_SUM,
    "sum_with_exploration": PLAIN_SUM,
    "without_softmax": {"resolution.temperature": None},
    "without_hysteresis": {"resolution.margin": 0.0},
    "without_grouping": {"resolution.by_row": False},
    "second_opponent": {"resolution.exploration.opponent": "second"},
    "mechanism_as_in_paper": _TEXT,
    # One gradient a step, at the speed of the text: as shipped, where the model foresees that the
    # step begins; the text's mechanism, where the robot is; and what both are measured against.
    "one_gradient": ONE_GRADIENT,
    "sum_one_gradient": {**PLAIN_SUM, **ONE_GRADIENT},
    "text": {**_TEXT, **WITHOUT_FORESIGHT},
    "text_sum": TEXT_SUM,
    "text_steepest": {
        "resolution": Later("aicon_torch.resolution:SteepestPath"),
        **WITHOUT_FORESIGHT,
    },
    # From the gradient to the command.
    "without_smoothing": {"law.smoothing": 0.0},
    "without_foresight": WITHOUT_FORESIGHT,
    "without_dither": {"law.dither": 0.0},
    "without_lag_compensation": {"compensate_lag": False},
}
"""Those of the pushing policy."""

ARM_PUSH: Mapping[str, Mapping[str, Any]] = {
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
"""Those of the arm's policy."""
