"""Objects named as text, "module:name", and imported when they are needed."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError


def find(source: str) -> Any:
    """Import what "module:name" names; the module may lie in this folder.

    Raises:
        ComparisonError: If there is no such module, or nothing of this name in it; or where a file
            is named instead.
        ModuleNotFoundError: If the module is there and imports another that is not.
    """
    module, _, name = source.partition(":")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)

    if module.endswith(".py") or not all(module.split(".")):
        raise ComparisonError(f"{source!r}: MODULE is a name such as my_module, not a file")

    try:
        return attrgetter(name)(import_module(module))
    except ModuleNotFoundError as error:
        is_itself = error.name is not None and f"{module}.".startswith(f"{error.name}.")
        if not is_itself:
            raise
        raise ComparisonError(f"{source!r}: {error}") from error
    except AttributeError as error:
        raise ComparisonError(f"{source!r}: {error}") from error


@dataclass(frozen=True)
class Later:
    """A value of an option that loads torch: called with these arguments when it is needed.

    Example:
        >>> from aicon_baselines.named import Later
        >>> Later("aicon_torch.control:Foresight", {"dither": 0.0}).make().dither
        0.0
    """

    source: str
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def make(self) -> Any:
        """Import it and call it."""
        return find(self.source)(**self.arguments)


def made(options: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return options with those made that come later."""
    values = {}
    for name, value in options.items():
        values[name] = value.make() if isinstance(value, Later) else value
    return MappingProxyType(values)
