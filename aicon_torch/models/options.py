"""Options by name: fields of nested frozen dataclasses, named by dotted paths."""

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeVar

from aicon_torch.errors import OptionError, choices

Options = TypeVar("Options")


def replace_options(options: Options, changes: Mapping[str, Any], owner: str = "") -> Options:
    """Options with some of their fields replaced.

    Args:
        options: A frozen dataclass, some of whose fields may be frozen dataclasses themselves.
        changes: New values by name; a field of a field is named by its path, such as
            ``"contact.reach"``. Where a field is replaced as a whole and in part, the part is
            replaced in the new one.
        owner: Who the options belong to, for error messages.

    Raises:
        OptionError: If a name is unknown, which lists the valid ones, or a value is not valid.

    Example:
        >>> replace_options(Options(), {"law.gain": 10.0, "resolution.exploration": None})
    """
    # Only what there is can be replaced, so that a misspelt name is found.
    fields = dataclasses.fields(options)  # type: ignore[arg-type]  # a dataclass, says the docstring
    valid = tuple(field.name for field in fields)

    # Which fields are replaced as a whole, and which in part.
    whole: dict[str, Any] = {}
    partial: dict[str, dict[str, Any]] = {}
    for path, value in changes.items():
        name, _, rest = path.partition(".")
        if name not in valid:
            raise OptionError(f"{owner} has no option {name!r}. Options: {choices(valid)}.")

        if rest:
            partial.setdefault(name, {})[rest] = value
        else:
            whole[name] = value

    # A part is replaced in what its field now is.
    for name, inner in partial.items():
        group = whole.get(name, getattr(options, name))
        if not dataclasses.is_dataclass(group):
            first = next(iter(inner))
            raise OptionError(f"{name!r} of {owner} is {group!r}; it has no option {first!r}.")

        whole[name] = replace_options(group, inner, f"{name!r} of {owner}")

    return dataclasses.replace(options, **whole)  # type: ignore[type-var]  # likewise
