"""Reactive control by adaptive nullspace projection on a graph of recursive estimators (AICON)."""

from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.errors import AiconError, GraphError, ObservationError, OptionError
from aicon_torch.estimation import (
    EKF,
    Deterministic,
    Estimator,
    KalmanFilter,
    LateEKF,
    Measurement,
)
from aicon_torch.export import ExportedPolicy, load_exported
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.inspection import Explanation, StepTrace
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models import make_policy, presets
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Quantity, Sensor
from aicon_torch.readings import BackgroundPerception, Perception
from aicon_torch.rehearsal import Rehearsal
from aicon_torch.resolution import (
    Exploration,
    NullspaceProjection,
    Resolution,
    SteepestPath,
    Sum,
    TrapEscape,
)
from aicon_torch.shaping import (
    by_gain,
    by_sign,
    by_worth,
    straight_through,
    straight_through_clamp,
)
from aicon_torch.shield import Shield

__all__ = [
    "EKF",
    "ActionLaw",
    "Actuator",
    "Affine",
    "AiconError",
    "BackgroundPerception",
    "Deterministic",
    "DirectDescent",
    "Estimator",
    "Explanation",
    "Exploration",
    "ExportedPolicy",
    "Foresight",
    "Goal",
    "GraphError",
    "Interconnection",
    "KalmanFilter",
    "LateEKF",
    "Measurement",
    "NullspaceProjection",
    "ObservationError",
    "OptionError",
    "Perception",
    "Policy",
    "Quantity",
    "Rehearsal",
    "Resolution",
    "Sensor",
    "Shield",
    "SteepestPath",
    "StepTrace",
    "Sum",
    "TrapEscape",
    "WorldModel",
    "by_gain",
    "by_sign",
    "by_worth",
    "load_exported",
    "make_policy",
    "presets",
    "straight_through",
    "straight_through_clamp",
]
__version__ = "0.2.0"
