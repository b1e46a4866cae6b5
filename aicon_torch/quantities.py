"""Quantities: the named tensors of a world model, and the sensors and actuators among them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.safety import VelocityDampers

PRESENT = ".present"
"""Suffix of the flag ``(*B,)`` that says whether an optional sensor has a reading in this step."""


@dataclass(frozen=True)
class Quantity:
    """A named tensor of shape ``(*B, *shape)``.

    Attributes:
        name: Its name in the graph.
        shape: Its shape without the batch dimensions.
        is_motion: Whether the value itself is a motion (a displacement or a velocity). The motion
            of any other quantity is its change since the last step.
    """

    name: str
    shape: tuple[int, ...]
    is_motion: bool = False

    @property
    def size(self) -> int:
        """Number of components, i.e. the length of a gradient with respect to this quantity."""
        return math.prod(self.shape)

    def flatten(self, value: Tensor) -> Tensor:
        """The value ``(*B, *shape)`` as vectors ``(*B, size)``."""
        return value if len(self.shape) == 1 else value.flatten(-len(self.shape))


@dataclass(frozen=True)
class Sensor:
    """A reading of shape ``(*B, size)`` that the observation brings.

    Args:
        size: Number of components.
        unit: Unit of each component, for people and error messages.
        key: The observation's key; by default the sensor's name in the graph.
        optional: Whether a reading may be absent. NaN, or a missing key, then means "no reading":
            the estimators predict and correct again when the next one comes. What reads it without
            a measurement reads the last one again.
        range: Lowest and highest value that the instrument can report; readings saturate there.
        scale: Factor from the observation's unit to the graph's, one for all components or one
            each: a sensor that reports px in a graph of metres has the size of a px here.
    """

    size: int
    unit: str
    key: str | None = None
    optional: bool = False
    range: tuple[float, float] | None = None
    scale: float | tuple[float, ...] = 1.0

    def __post_init__(self) -> None:
        """Check size, range and scale."""
        if self.size < 1:
            raise GraphError(f"Sensor size {self.size!r}: expected 1 or more components.")
        if self.range is not None and not self.range[0] < self.range[1]:
            raise GraphError(f"Sensor range {self.range!r}: expected (lowest, highest).")
        if not isinstance(self.scale, int | float) and len(self.scale) != self.size:
            raise GraphError(
                f"Sensor scale {self.scale!r}: expected one factor, or {self.size}, one a "
                "component."
            )


@dataclass(frozen=True)
class Actuator:
    """A command of shape ``(*B, size)`` that the policy chooses.

    Args:
        size: Number of components.
        unit: Unit of each component.
        limit: One number limits the Euclidean norm; a sequence limits each component's magnitude.
        constraints: What else limits it, one after the other: functions of the action and of any
            quantities, wired by their parameter names, that return an action that is allowed,
            ``(*B, size)``, and leave one that is allowed as it is.
        command: What the robot is sent instead of the action, if it takes another command: a
            function wired likewise.
        keeps_direction: Whether an action beyond a sequence of limits is shortened as a whole,
            instead of component by component.
        dampers: How it keeps the safety goals, where there are any: see
            :class:`aicon_torch.Goal`.
    """

    size: int
    unit: str
    limit: float | Sequence[float] = field(default=math.inf)
    constraints: Sequence[Callable[..., Tensor]] = ()
    command: Callable[..., Tensor] | None = None
    keeps_direction: bool = False
    dampers: VelocityDampers = field(default_factory=VelocityDampers)

    def __post_init__(self) -> None:
        """Check limit and constraints."""
        limits = (self.limit,) if isinstance(self.limit, int | float) else tuple(self.limit)
        if len(limits) not in (1, self.size) or not all(value > 0 for value in limits):
            raise GraphError(
                f"Actuator limit {self.limit!r}: expected one positive number (a norm) or "
                f"{self.size} of them."
            )
        if not isinstance(self.constraints, Sequence):
            raise GraphError(
                f"Actuator constraints {self.constraints!r}: expected a sequence of functions."
            )

    def clip(self, action: Tensor) -> Tensor:
        """The nearest action within the limit, in the box of a sequence or in the same direction.

        Args:
            action: ``(*B, size)``.

        Returns:
            ``(*B, size)``; no component is ever beyond the limit, not even by rounding.
        """
        if not isinstance(self.limit, int | float):
            bound = action.new_tensor(tuple(self.limit))
            if self.keeps_direction:
                excess = (action.abs() / bound).amax(-1, keepdim=True)
                action = action / excess.clamp(min=1.0)
            return torch.minimum(torch.maximum(action, -bound), bound)
        if math.isinf(self.limit):
            return action

        action = action.clamp(-1e18, 1e18)  # what can be squared
        norm = torch.linalg.vector_norm(action, dim=-1, keepdim=True)
        shortened: Tensor = action * (self.limit / norm.clamp(min=self.limit))
        return shortened.clamp(-self.limit, self.limit)
