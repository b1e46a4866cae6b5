"""Checks of options, with errors that name the option and say what it takes."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_torch.errors import OptionError, choices


def numbers(name: str, value: Any, size: int) -> tuple[float, ...]:
    """The finite numbers of an option.

    Args:
        name: Name of the option.
        value: What was given: a number where ``size`` is 1, otherwise a sequence.
        size: How many numbers are expected.

    Raises:
        OptionError: If they are not so many or not finite.
    """
    try:
        found = tuple(map(float, value)) if size > 1 else (float(value),)
    except (TypeError, ValueError):
        found = ()

    if isinstance(value, str | bool) or len(found) != size or not all(map(math.isfinite, found)):
        raise OptionError(f"{name}={value!r}: expected {size} finite number{'s' * (size > 1)}.")
    return found


def check_positive(options: object, names: Sequence[str]) -> None:
    """Check that fields of some options are positive and finite.

    Raises:
        OptionError: If one is not.
    """
    for name in names:
        value = getattr(options, name)
        if not numbers(name, value, 1)[0] > 0:
            raise OptionError(f"{name}={value!r}: expected a positive number.")


def check_not_negative(options: object, names: Sequence[str]) -> None:
    """Check that fields of some options are finite and not negative.

    Raises:
        OptionError: If one is.
    """
    for name in names:
        value = getattr(options, name)
        if not numbers(name, value, 1)[0] >= 0:
            raise OptionError(f"{name}={value!r}: expected a number >= 0.")


def check_count(
    options: object, names: Sequence[str], what: str = "whole number", least: int = 0
) -> None:
    """Check that fields of some options are whole numbers, none below the least.

    Args:
        options: The options.
        names: Names of the fields.
        what: What they count, for the error.
        least: The least of them that they may be.

    Raises:
        OptionError: If one is not.
    """
    for name in names:
        value = getattr(options, name)
        if not (type(value) is int and value >= least):
            raise OptionError(f"{name}={value!r}: expected a {what} >= {least}.")


def check_instance(options: object, names: Sequence[str], kind: type, such_as: str) -> None:
    """Check that fields of some options are what they may be, and no number or word.

    Args:
        options: The options.
        names: Names of the fields.
        kind: What they are to be.
        such_as: An example, for the error.

    Raises:
        OptionError: If one is something else.
    """
    for name in names:
        value = getattr(options, name)
        if not isinstance(value, kind):
            raise OptionError(f"{name}={value!r}: expected {kind.__name__}, such as {such_as}.")


def check_function(options: object, names: Sequence[str], called: str) -> None:
    """Check that fields of some options can be called.

    Args:
        options: The options.
        names: Names of the fields.
        called: How they are called, for the error.

    Raises:
        OptionError: If one cannot.
    """
    for name in names:
        value = getattr(options, name, None)
        if not callable(value):
            raise OptionError(f"{name}={value!r}: expected a function, {name}{called}.")


def check_whole(options: object, names: Sequence[str]) -> None:
    """Check that fields of some options are whole numbers above 0, or None.

    Raises:
        OptionError: If one is neither.
    """
    for name in names:
        value = getattr(options, name)
        is_whole = type(value) is int and value > 0
        if value is not None and not is_whole:
            raise OptionError(f"{name}={value!r}: expected a whole number > 0, or None.")


def check_flags(options: Any) -> None:
    """Check that the fields of a dataclass that are flags are True or False, and no words.

    Raises:
        OptionError: If one is something else.
    """
    for field in dataclasses.fields(options):
        if field.type is bool:
            check_flag(field.name, getattr(options, field.name))


def check_flag(name: str, value: Any) -> None:
    """Check that an option is True or False: ``"no"`` would count as True.

    Raises:
        OptionError: If it is something else.
    """
    if not isinstance(value, bool | np.bool_):
        raise OptionError(f"{name}={value!r}: expected True or False.")


def check_choice(options: object, name: str, valid: Sequence[str]) -> None:
    """Check that a field of some options is one of the words that it takes.

    Raises:
        OptionError: If it is another; it lists the valid ones.
    """
    value = getattr(options, name)
    if value not in valid:
        raise OptionError(f"{name}={value!r}: expected one of {choices(valid)}.")
