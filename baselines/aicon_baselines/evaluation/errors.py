"""The one error of this package that a user can cause and mend, and checks that raise it."""

from collections.abc import Iterable, Mapping
from typing import TypeVar

Known = TypeVar("Known")


class ComparisonError(ValueError):
    """Something was asked for that does not exist or does not fit; the message says what would."""


def check_counts(**counts: int) -> None:
    """Refuse a count below 1."""
    for name, count in counts.items():
        if count < 1:
            raise ComparisonError(f"{name} must be 1 or more, not {count}")


def check_known(kind: str, name: str, known: Iterable[str]) -> None:
    """Refuse a name that is none of a kind, with the list of those that are."""
    names = tuple(dict.fromkeys(known))
    if name not in names:
        raise ComparisonError(f"unknown {kind} {name!r}; valid {kind}s: {', '.join(names)}")


def find_known(kind: str, name: str, known: Mapping[str, Known]) -> Known:
    """Return what a name stands for; one that is none of a kind is refused likewise."""
    check_known(kind, name, known)
    return known[name]
