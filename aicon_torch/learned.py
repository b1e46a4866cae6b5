"""Learned numbers: constants of a model's parts that have become parameters, by name.

A model is built of numbers: variances, lengths, masses, gains, places. Each has a name, which says
where it stands: ``x_pose.noise``, ``x_pose.measurements.0.noise``, ``x_pose.predict.radius``. What
learns is computed from a parameter whenever it is read, so that a part that several functions share
has one value for all of them.
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from inspect import ismethod
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import learns
from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import EKF, Covariance
from aicon_torch.interconnections import Interconnection

FLOOR = 1e-6
"""Least share of its start to which a positive number can shrink, so that a likelihood that would
have a variance vanish stays finite. A start that is too large is safe, one too small is not."""

LEARNED = "_learned"
"""Attribute of a part that holds its learned numbers."""

COMPUTED = "_is_computed"
"""Attribute of a class that was made for such a part."""


class Learned(nn.Module):
    """A number, or several, computed from a parameter θ that starts at zero and has no unit.

    A positive number stays positive, and so do variances: v = v₀ max(exp θ, floor). Other numbers,
    and vectors, are free: v = v₀ + s θ, where the scale s is the largest |v₀|, or one. At θ = 0 it
    is v₀ to the last bit.

    Args:
        start: v₀.
        diagonal: Of how many components it is the diagonal of a matrix, such as of a covariance.
    """

    start: Tensor

    def __init__(self, start: Tensor, diagonal: int | None = None) -> None:
        super().__init__()
        is_magnitude = diagonal is not None or start.dim() == 0
        self.is_positive = is_magnitude and bool((start > 0).all())
        self.diagonal = diagonal
        self.scale = float(start.abs().max()) or 1.0
        self.register_buffer("start", start.clone())
        self.theta = nn.Parameter(torch.zeros_like(start))

    def forward(self) -> Tensor:
        """v, a constant for whatever only acts."""
        if self.is_positive:
            value = self.start * self.theta.exp().clamp(min=FLOOR)
        else:
            value = self.start + self.scale * self.theta
        if self.diagonal is not None:
            value = torch.diag(value.expand(self.diagonal))
        return value if learns() else value.detach()  # stops what leads to a parameter


class Number(NamedTuple):
    """Where a number stands.

    Attributes:
        owner: The part that has it.
        field: Its attribute there.
    """

    owner: Any
    field: str

    @property
    def value(self) -> Any:
        """What it is now: a number or a tensor."""
        return getattr(self.owner, self.field)

    def make_learn(self, name: str, start: Any, like: Tensor) -> None:
        """Let it be computed from a parameter from now on.

        Args:
            name: What an error calls it.
            start: Where it starts; None where it is.
            like: A tensor of the model's type.
        """
        known = getattr(self.owner, LEARNED, {})
        value = torch.as_tensor(self.value, dtype=like.dtype, device=like.device)
        diagonal = len(value) if _is_covariance(self.owner, self.field) else None
        if diagonal is not None:  # one variance stays one
            value = value.diagonal()[: 1 if getattr(self.owner, "is_single", False) else None]
        if start is not None:
            value = _start(name, start, value)
        if diagonal is not None and not (value > 0).all():
            raise GraphError(f"{name!r}: learned variances are > 0, got {value.tolist()}.")

        # The constant goes, and its owner gets a class of its own, in which the name is a property
        # that computes the number from θ: who reads it need not know, even in a frozen dataclass.
        learned = {**known, self.field: Learned(value, diagonal)}
        if isinstance(self.owner, nn.Module):
            self.owner._buffers.pop(self.field, None)
        self.owner.__dict__.pop(self.field, None)
        self.owner.__dict__[LEARNED] = learned
        kind: type = self.owner.__class__
        object.__setattr__(self.owner, "__class__", _computing(kind, self.field))


def _start(name: str, given: Any, like: Tensor) -> Tensor:
    """Where a number starts, of the shape and type of another."""
    try:
        start = torch.as_tensor(given, dtype=like.dtype, device=like.device).expand_as(like)
    except (TypeError, ValueError, RuntimeError):
        start = torch.full_like(like, torch.nan)
    if not start.isfinite().all():
        raise GraphError(
            f"start of {name!r}: expected finite numbers of shape {tuple(like.shape)}, or one for "
            f"all, got {given!r}."
        )
    return start


@cache
def _computing(kind: type, field: str) -> type:
    """A subclass, one attribute of which is computed from a parameter."""

    def computed(part: Any) -> Tensor:
        value: Tensor = part.__dict__[LEARNED][field]()
        return value

    def reduced(part: Any) -> tuple[Any, ...]:
        return _remade, (_original(kind), tuple(part.__dict__[LEARNED])), part.__getstate__()

    known = {field: property(computed), "__module__": kind.__module__, "__reduce__": reduced}
    return type(kind.__name__, (kind,), {**known, COMPUTED: True})


def _original(kind: type) -> type:
    """The class of a part before any of its numbers learned."""
    while COMPUTED in vars(kind):
        kind = kind.__base__ or object
    return kind


def _remade(kind: type, fields: Sequence[str]) -> Any:
    """A part without its state, some numbers of which are computed: a pickle names its class."""
    for field in fields:
        kind = _computing(kind, field)
    return object.__new__(kind)


def _is_covariance(owner: Any, field: str) -> bool:
    return isinstance(owner, Covariance) or (isinstance(owner, EKF) and field == "prior_covariance")


def numbers_of(parts: Mapping[str, Any]) -> dict[str, Number]:
    """All numbers of some parts by name, also learned ones; not the weights of networks."""
    found: dict[str, Number] = {}
    for name, part in parts.items():
        found.update(_numbers(name, part))
    return found


def learned_in(parts: Mapping[str, Any]) -> dict[str, Learned]:
    """What learns already, each once, by the first of its names."""
    found: dict[str, Learned] = {}
    for name, number in numbers_of(parts).items():
        learned = getattr(number.owner, LEARNED, {}).get(number.field)
        if learned is not None and learned not in found.values():
            found[name] = learned
    return found


def _numbers(name: str, part: Any) -> Iterator[tuple[str, Number]]:
    """The numbers of one part, and of those that it is made of."""
    # A method stands for its object, and a plain interconnection for its function.
    if ismethod(part):
        part = part.__self__
    if isinstance(part, Interconnection):
        yield from _numbers(name, part.function) if type(part) is Interconnection else ()
    if not isinstance(part, nn.Module) and not dataclasses.is_dataclass(part):
        return
    if isinstance(part, type):
        return

    # A number counts by itself, and anything else by the numbers in it.
    for field, value in _fields(part):
        if isinstance(value, Tensor) and not value.is_floating_point():
            continue
        called = name if isinstance(part, Covariance) else f"{name}.{field}"
        if isinstance(value, float | Tensor):
            yield called, Number(part, field)
        elif not isinstance(part, Interconnection):
            yield from _numbers(called, value)


def _fields(part: Any) -> Iterator[tuple[str, Any]]:
    """What a part is made of, by the names of its attributes."""
    if isinstance(part, nn.Module):
        yield from part.named_buffers(recurse=False)
        yield from part.named_children()
    for field in (*vars(part), *getattr(part, LEARNED, {})):
        value = getattr(part, field)
        is_module = isinstance(part, nn.Module) and isinstance(value, nn.Module)

        # A bound at infinity is none, and has nothing to learn.
        is_bound = isinstance(value, float) and not math.isfinite(value)
        if not field.startswith("_") and not is_module and not is_bound:
            yield field, value


def make_learn(
    parts: Mapping[str, Any], names: Mapping[str, Any], like: Tensor
) -> dict[str, nn.Parameter]:
    """Let numbers of some parts learn, and weights of networks, and nothing else.

    Args:
        parts: The parts by name.
        names: What learns, and where it starts; None where it is. A name under which there is a
            network stands for all of its weights.
        like: A tensor of the model's type.

    Returns:
        The parameters by name.

    Raises:
        GraphError: If there is no such number.
    """
    numbers, weights = numbers_of(parts), dict(_weights(parts))

    # Nothing learns but what is named.
    for parameter in (*weights.values(), *(known.theta for known in learned_in(parts).values())):
        parameter.requires_grad_(False)

    found: dict[str, nn.Parameter] = {}
    for name, start in names.items():
        # A name is a number's, or a network's with all the weights below it.
        below = {n: weight for n, weight in weights.items() if f"{n}.".startswith(f"{name}.")}
        if name in numbers:
            number = numbers[name]
            if number.field not in getattr(number.owner, LEARNED, {}) or start is not None:
                number.make_learn(name, start, like)
            found[name] = getattr(number.owner, LEARNED)[number.field].theta.requires_grad_()
        elif below and start is None:
            for weight in below.values():
                weight.requires_grad_()
            found |= below
        else:
            known = [*numbers, *dict.fromkeys(n.rpartition(".")[0] for n in weights)]
            raise GraphError(f"No number is named {name!r}. Numbers: {choices(known)}.")
    return found


def _weights(parts: Mapping[str, Any]) -> Iterator[tuple[str, nn.Parameter]]:
    """The weights of networks by name."""
    for name, part in parts.items():
        if isinstance(part, nn.Module):
            for below, weight in part.named_parameters():
                # As the part calls it, without what wraps it on the way.
                yield (
                    f"{name}.{below}".replace(".function.", ".").replace(".residual.", "."),
                    weight,
                )
