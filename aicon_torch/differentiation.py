"""What is differentiated: a policy that acts looks one hop far, one that learns looks all the way.

A step that acts is made of values: estimators filter without gradients, every hop of the backward
pass begins at fresh leaves, and a model may stop a gradient to say that no path leads there. While
something learns (:func:`through_time`) the same functions compute the same numbers, but keep what
they are made of, so that a loss may be differentiated by any parameter through any number of steps.
One hop still ends where it did: its gradient is taken by an alias of the value (:func:`hop_from`),
and what a model stops (:func:`stop`) is stopped in the hop (:func:`pull`) and nowhere else. So an
action that is differentiable is the action that would be taken, but for rounding. Ranks, switches
and gates are constants of the step; one thread learns at a time.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import torch
from torch import Tensor

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


class _Mode(threading.local):
    """What this thread does besides computing: it learns, records, or takes gradients literally."""

    learns = False
    is_recorded = False
    is_literal = False


_MODE = _Mode()
_HOPS: list[None] = []  # one for each hop that is being pulled back; backward has its own threads


def learns() -> bool:
    """Whether what is computed now is to be differentiated through time."""
    return _MODE.learns


@contextmanager
def _switched_on(mode: str) -> Iterator[None]:
    """Set a mode of this thread, as long as it lasts."""
    before = getattr(_MODE, mode)
    setattr(_MODE, mode, True)
    try:
        yield
    finally:
        setattr(_MODE, mode, before)


@contextmanager
def through_time() -> Iterator[None]:
    """Keep what leads from parameters to values, as long as it lasts."""
    with _switched_on("learns"), torch.enable_grad():
        yield


def recorded() -> AbstractContextManager[None]:
    """What is computed is to run again with other values, as long as it lasts: no branch is cut."""
    return _switched_on("is_recorded")


def literal() -> AbstractContextManager[None]:
    """Take the gradients of functions literally, as long as it lasts.

    A part may give a goal another gradient than that of the chain rule, such as the natural one. A
    bound holds if its slope is that of its gap, and nothing else. What a model stops stays stopped:
    it says that no path leads there.
    """
    return _switched_on("is_literal")


def is_literal() -> bool:
    """Whether what is computed now is to have the gradient of the chain rule."""
    return _MODE.is_literal


def is_nowhere(flags: Tensor) -> bool:
    """Whether flags are known to be false everywhere, so that what they choose is not needed.

    They are not known while the step is :func:`recorded`, nor on a device that one would wait for,
    and what learns is differentiated by both sides of a choice.
    """
    is_known = flags.device.type == "cpu" and not (_MODE.is_recorded or _MODE.learns)
    return is_known and not flags.any()


@contextmanager
def undisturbed(like: Tensor) -> Iterator[None]:
    """Compute as if the caller had entered neither inference mode nor autocast.

    Whether gradients are recorded stays as it is.

    Args:
        like: A tensor on the device that computes.
    """
    records = torch.is_grad_enabled()  # leaving inference mode would switch it on
    with (
        torch.inference_mode(False),
        torch.set_grad_enabled(records),
        torch.autocast(like.device.type, enabled=False),
    ):
        yield


def values_only(
    function: Callable[_Parameters, _Result],
) -> Callable[_Parameters, _Result]:
    """A function that keeps no graph, unless something learns."""

    @wraps(function)
    def wrapped(*args: _Parameters.args, **kwargs: _Parameters.kwargs) -> _Result:
        if _MODE.learns:
            return function(*args, **kwargs)
        with torch.no_grad():
            return function(*args, **kwargs)

    return wrapped


def stop(value: Tensor) -> Tensor:
    """The value ``(*B, n)`` as a constant of the hop: no path of the graph leads over it."""
    if not _MODE.learns:
        return value.detach()  # stops every gradient, since there are none but those of a hop
    stopped: Tensor = _Stop.apply(value)  # type: ignore[no-untyped-call]  # torch leaves it untyped
    return stopped


def hop_from(value: Tensor) -> Tensor:
    """The value ``(*B, n)`` as a point of its own, by which a hop is differentiated."""
    if _MODE.learns and value.requires_grad:
        return value.view_as(value)  # an alias: derivatives by it know nothing of what led there
    return value.detach()  # ends the graph here: one hop


def pull(
    outputs: Tensor | Sequence[Tensor],
    inputs: Tensor | Sequence[Tensor],
    seeds: Tensor | Sequence[Tensor] | None = None,
    **options: Any,
) -> tuple[Tensor, ...]:
    """The gradients of one hop: :func:`torch.autograd.grad`, where :func:`stop` stops."""
    if not _MODE.learns:
        return torch.autograd.grad(outputs, inputs, seeds, **options)
    _HOPS.append(None)
    try:
        return torch.autograd.grad(outputs, inputs, seeds, **{**options, "create_graph": True})
    finally:
        _HOPS.pop()


def is_hop() -> bool:
    """Whether the gradient that arrives is that of one hop, and not of a loss."""
    return bool(_HOPS)


class _Stop(torch.autograd.Function):
    """The identity, with no gradient within a hop."""

    @staticmethod
    def forward(ctx: Any, value: Tensor) -> Tensor:
        return value.view_as(value)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> Tensor:
        (gradient,) = gradients
        return torch.zeros_like(gradient) if is_hop() else gradient
