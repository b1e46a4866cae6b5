"""Ablations of the pushing policy."""

from collections.abc import Mapping
from typing import Any

from aicon_baselines.named import Later

PIXEL = 0.5 / 512
"""Length of a pixel, m: that of `aicon_torch.models.pusht`, whose import would load torch."""

_ONE_LIKELIHOOD = {"contact.aim": 0.0, "contact.facing": False}

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
    "without_projection": {"resolution.projector": "none"},
    "sum_with_exploration": {"resolution.projector": "none", "resolution.temperature": None},
    "without_softmax": {"resolution.temperature": None},
    "without_hysteresis": {"resolution.margin": 0.0},
    "without_grouping": {"resolution.by_row": False},
    "second_partner": {"resolution.exploration.partner": "second"},
    "mechanism_as_in_paper": {
        "resolution.relative": False,
        "resolution.exploration.partner": "second",
        "resolution.exploration.ratio_of": "weights",
        "resolution.exploration.average_time": 1.0,
    },
    # From the gradient to the command.
    "without_smoothing": {"law.smoothing": 0.0},
    "without_foresight": {"law": Later("aicon_torch.control:DirectDescent")},
    "without_dither": {"law.dither": 0.0},
    "without_lag_compensation": {"compensate_lag": False},
}
"""Options by name, on top of the preset ``"aicon"``."""
