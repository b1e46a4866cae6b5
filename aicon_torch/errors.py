"""Errors of the library: each names what was wrong and lists what would be right."""

from collections.abc import Iterable
from typing import TypeVar

_Item = TypeVar("_Item")


class AiconError(ValueError):
    """Base of every error that the library raises for bad input."""


class GraphError(AiconError):
    """A world model that cannot be built: unknown name, wrong shape, unreachable actuator."""


class ObservationError(AiconError):
    """An observation that a sensor cannot accept: missing, wrongly shaped, NaN or infinite."""


class OptionError(AiconError):
    """An unknown model, preset or option, or a value that it does not take."""


def choices(names: Iterable[str]) -> str:
    """The valid names as they appear in an error: ``'a', 'b', 'c'``."""
    return ", ".join(repr(name) for name in names) or "(none)"


def in_order(named: str, given: Iterable[_Item]) -> tuple[_Item, ...]:
    """What was given, in its order, read once: a generator gives its items only once.

    Args:
        named: What an error calls it.
        given: A list, a tuple, or whatever else has an order.

    Raises:
        GraphError: If it has none, such as a set.
    """
    if not isinstance(given, Iterable) or isinstance(given, str | set | frozenset):
        raise GraphError(f"{named}: expected a list or a tuple, got {given!r}.")
    return tuple(given)
