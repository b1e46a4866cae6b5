"""Quantities: the named tensors of a world model, and the sensors and actuators among them."""

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from torch import Tensor

from aicon_torch.dampers import VelocityDampers
from aicon_torch.errors import GraphError
from aicon_torch.validation import check_flags, check_instance

PRESENT = ".present"
"""Suffix of the flag ``(*B,)`` that says whether a sensor has a reading in this step."""

AGE = ".age"
"""Suffix of the age ``(*B,)`` of a sensor's last reading, s."""

MISSED = ".missed"
"""Suffix of the number ``(*B,)`` of steps of an episode in which a sensor had no reading."""

SILENCE = ".silence"
"""Suffix of the time ``(*B,)`` since a sensor's last reading came, new or not, s."""

FROZEN = ".frozen"
"""Suffix of the flag ``(*B,)`` that says whether a sensor repeats itself while it should not."""

RESTART = ".restart"
"""Suffix of the flag ``(*B,)`` that says whether a sensor is believed again somewhere else."""


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

    A reading counts as missing if it is masked, not finite, or cannot be what the instrument meant.
    Estimators then predict, and correct again when the next one comes. A function that reads the
    sensor directly gets the last reading again. Each row of a batch misses its readings alone, and
    counts them.

    Args:
        size: Number of components.
        unit: Unit of each component, for people and error messages.
        key: The observation's key; by default the sensor's name in the graph.
        optional: Whether the key may be missing, and an episode begin without a reading. (An
            estimate that starts at a reading waits for it in any case.)
        range: Lowest and highest value that the instrument can report; any other is missing.
        scale: Factor from the observation's unit to the graph's, one for all components or one
            each: a sensor that reports px in a graph of metres has the size of a px here.
        age: How old a reading is where the observation does not tell, s.
        age_key: The observation's key of the reading's age, ``(*B,)`` or ``(*B, 1)``, s: now minus
            its time stamp. One that is not newer than the last counts as missing.
        max_age: Age of the last reading beyond which actions decay, to rest at twice this age, s;
            None for a sensor that nobody watches.
        max_gap: Time without any reading beyond which actions decay, to rest at twice this time, s:
            for readings that are old when they come. One that is older than the last ends the gap
            if it is plausible; the same one again does not.
        rate_limit: How fast a component can change, in the observation's unit per second. A reading
            that has jumped farther since the last one counts as missing; the longer none comes, the
            farther it may be. Four in a row that agree with each other are believed wherever they
            are, and estimates of what they measure begin anew.
        period: Of a reading that wraps, in the observation's unit, such as 2π of an angle in rad.
        is_possible: A function of a reading ``(*B, size)``, in the graph's unit, that says which
            rows ``(*B,)`` can be, such as those of points of a rigid body; others are missing.
        driven_by: An actuator whose motion the reading must show. A reading that stays the same to
            the last bit while it acts, except at the ends of its range, is frozen, and missing
            until it changes; with a ``rate_limit`` until four in a row agree.
    """

    size: int
    unit: str
    key: str | None = None
    optional: bool = False
    range: tuple[float, float] | None = None
    scale: float | tuple[float, ...] = 1.0
    age: float = 0.0
    age_key: str | None = None
    max_age: float | None = None
    max_gap: float | None = None
    rate_limit: float | None = None
    period: float | None = None
    driven_by: str | None = None
    is_possible: Callable[[Tensor], Tensor] | None = None

    def __post_init__(self) -> None:
        """Check size, range, scale and times, and keep them as plain numbers."""
        check_flags(self)
        object.__setattr__(self, "size", as_size("Sensor", self.size))
        object.__setattr__(self, "range", _range("Sensor range", self.range))

        # One factor for all components, or one each.
        scale = as_numbers(self.scale)
        factors = scale if isinstance(scale, tuple) else (scale,) * self.size
        is_right = all(math.isfinite(factor) and factor != 0 for factor in factors)
        if len(factors) != self.size or not is_right:
            raise GraphError(
                f"Sensor scale {self.scale!r}: expected one factor, or {self.size}, one a "
                "component, finite and not 0."
            )
        object.__setattr__(self, "scale", scale)

        # Times and speeds.
        for name in ("max_age", "max_gap", "rate_limit", "period"):
            value = getattr(self, name)
            if value is None:
                continue
            number = as_number(value)
            if not number > 0:
                raise GraphError(f"Sensor {name}={value!r}: expected a number > 0, or None.")
            object.__setattr__(self, name, number)
        if self.period is not None and math.isinf(self.period):
            raise GraphError(f"Sensor period={self.period!r}: expected a finite number, or None.")
        age = as_number(self.age)
        if not 0 <= age < math.inf:
            raise GraphError(f"Sensor age={self.age!r}: expected a number >= 0, in s.")
        object.__setattr__(self, "age", age)

        if self.is_possible is not None and not callable(self.is_possible):
            raise GraphError(
                f"Sensor is_possible={self.is_possible!r}: expected a function of a reading, or "
                "None."
            )

    @property
    def is_aged(self) -> bool:
        """Whether its readings have an age."""
        return self.age_key is not None or self.age > 0

    def key_of(self, name: str) -> str:
        """The observation's key of its reading, where the graph calls it so."""
        return self.key or name


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
            function wired likewise. While ``memory["begins"]`` is set, it may be made of readings
            that never came, such as a place to go to: send none then.
        command_range: Lowest and highest number of a command, to which others are clipped, the last
            one that the memory holds, too, which is sent again at rest; None for any.
        key: The observation's key of the action that the robot executed in the last step, if that
            may be another one, ``(*B, size)``; NaN or no key stands for the one that it was sent.
        keeps_direction: Whether an action beyond a sequence of limits is shortened as a whole,
            instead of component by component.
        dampers: How it keeps the safety goals, where there are any: see
            :class:`aicon_torch.Goal`.
        metric: What a departure from the nominal action counts where safety goals ask for one: a
            function wired likewise, that returns a symmetric positive definite M ``(*B, size,
            size)``, for which δᵀMδ is the square of the departure δ. All components count alike by
            default.
        dither: Where a dither of the action law goes: a function wired likewise, that returns the
            motions D ``(*B, size, k)`` of which it is a mixture, each as long as the limit lets it
            be. Every component has its own by default, which a redundant arm would feel as a motion
            of its joints that nothing undoes.
    """

    size: int
    unit: str
    limit: float | Sequence[float] = field(default=math.inf)
    constraints: Sequence[Callable[..., Tensor]] = ()
    command: Callable[..., Tensor] | None = None
    command_range: tuple[float, float] | None = None
    key: str | None = None
    keeps_direction: bool = False
    dampers: VelocityDampers = field(default_factory=VelocityDampers)
    metric: Callable[..., Tensor] | None = None
    dither: Callable[..., Tensor] | None = None

    def __post_init__(self) -> None:
        """Check limit, constraints and the range of commands; numbers become plain ones."""
        check_flags(self)
        object.__setattr__(self, "size", as_size("Actuator", self.size))

        # One number for the norm, or one a component.
        limit = as_numbers(self.limit)
        limits = limit if isinstance(limit, tuple) else (limit,)
        if len(limits) not in (1, self.size) or not all(value > 0 for value in limits):
            raise GraphError(
                f"Actuator limit {self.limit!r}: expected one positive number (a norm) or "
                f"{self.size} of them."
            )
        object.__setattr__(self, "limit", limit)

        # What else limits it, and what it is sent.
        check_instance(self, ("dampers",), VelocityDampers, "VelocityDampers(braking=0.3)")
        if not isinstance(self.constraints, Sequence):
            raise GraphError(
                f"Actuator constraints {self.constraints!r}: expected a sequence of functions."
            )
        command_range = _range("Actuator command_range", self.command_range)
        object.__setattr__(self, "command_range", command_range)

    def limit_like(self, values: Tensor) -> Tensor:
        """The limit, a scalar or ``(size,)``, of the type and on the device of some values.

        It is rounded to single precision first, so that it is the same in every precision.
        """
        limit = torch.as_tensor(self.limit, dtype=torch.float32, device=values.device)
        return limit.to(values)

    def clip(self, action: Tensor) -> Tensor:
        """The nearest action within the limit, in the box of a sequence or in the same direction.

        Args:
            action: ``(*B, size)``.

        Returns:
            ``(*B, size)``; no component is ever beyond the limit, not even by rounding.
        """
        if not isinstance(self.limit, int | float):
            # A box: shortened as a whole if the direction counts, then each component for itself.
            bound = action.new_tensor(tuple(self.limit))
            if self.keeps_direction:
                excess = (action.abs() / bound).amax(-1, keepdim=True)
                action = action / excess.clamp(min=1.0)
            return torch.minimum(torch.maximum(action, -bound), bound)
        if math.isinf(self.limit):
            return action

        action = action.clamp(-1e18, 1e18)  # what can be squared

        # A norm; each component is clamped once more, since rounding may have left it just beyond.
        norm = torch.linalg.vector_norm(action, dim=-1, keepdim=True)
        shortened: Tensor = action * (self.limit / norm.clamp(min=self.limit))
        return shortened.clamp(-self.limit, self.limit)

    def clip_command(self, command: Tensor) -> Tensor:
        """The nearest command within :attr:`command_range`, ``(*B, size)``."""
        return command if self.command_range is None else command.clamp(*self.command_range)


def as_numbers(given: Any) -> float | tuple[float, ...]:
    """A number or several, whatever they come in; NaN where they are none.

    A tensor may be of any precision, and require a gradient: its numbers are constants here.
    """
    try:
        if isinstance(given, Tensor):
            given = given.numpy(force=True) if given.dtype != torch.bfloat16 else given.tolist()
        array = np.asarray(given)
    except (TypeError, ValueError, RuntimeError):  # a ragged list, or a tensor of another kind
        return math.nan
    if array.dtype.kind not in "fiu" and array.size > 0:
        return math.nan
    return float(array) if array.ndim == 0 else tuple(map(float, array.flatten().tolist()))


def as_number(given: Any) -> float:
    """A number, whatever it comes in; NaN where it is none, or several."""
    number = as_numbers(given)
    return math.nan if isinstance(number, tuple) else number


def as_count(given: Any) -> int:
    """A whole number, whatever it comes in; −1 where it is none."""
    try:
        return operator.index(given)
    except TypeError:
        return -1


def as_size(what: str, given: Any) -> int:
    """A number of components.

    Raises:
        GraphError: If it is no whole number, or less than 1.
    """
    size = as_count(given)
    if size < 1:
        raise GraphError(f"{what} size {given!r}: expected 1 or more components, a whole number.")
    return size


def _range(what: str, ends: Any) -> tuple[float, float] | None:
    """The lowest and the highest of some numbers; None for any."""
    if ends is None:
        return None
    numbers = as_numbers(ends)
    if not (isinstance(numbers, tuple) and len(numbers) == 2 and numbers[0] < numbers[1]):
        raise GraphError(f"{what} {ends!r}: expected (lowest, highest).")
    return numbers[0], numbers[1]
