"""Errors of the library: each names what was wrong and lists what would be right."""

from collections.abc import Iterable


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
