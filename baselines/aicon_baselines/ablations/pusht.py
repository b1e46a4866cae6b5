"""Ablations of the pushing policy."""

from collections.abc import Mapping
from typing import Any

from aicon_baselines.ablations.mechanism import (
    ONE_GRADIENT,
    PLAIN_SUM,
    TEXT_SUM,
    TEXTS_EXPLORATION,
    WEIGHTED_SUM,
    WITHOUT_FORESIGHT,
)
from aicon_baselines.named import Later

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

ABLATIONS: Mapping[str, Mapping[str, Any]] = {
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
"""Options by name, on top of the preset ``"aicon"``."""
