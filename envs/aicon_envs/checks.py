"""Checks of arguments that the environments share."""

import dataclasses
import inspect
import math
import operator
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from aicon_envs.arrays import FloatArray

Fields = TypeVar("Fields")


def check_render_mode(render_mode: str | None) -> str | None:
    """Return the render mode.

    Raises:
        ValueError: If it is neither None nor "rgb_array".
    """
    if render_mode not in (None, "rgb_array"):
        raise ValueError(f'render_mode must be None or "rgb_array", got {render_mode!r}')

    return render_mode


def check_choice(name: str, value: Any, valid: Iterable[str]) -> None:
    """Check that an argument is one of the valid words.

    Raises:
        ValueError: If it is not; the message lists them.
    """
    valid = tuple(valid)
    if not isinstance(value, str) or value not in valid:
        raise ValueError(f"{name} must be one of {', '.join(valid)}, got {value!r}")


def check_number(name: str, value: Any, positive: bool = False) -> float:
    """Return a number as a float.

    Raises:
        ValueError: If it is not finite or is negative or, with `positive`, 0.
    """
    expected = "a finite number > 0" if positive else "a finite number >= 0"
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be {expected}, got {value!r}") from error

    too_small = number <= 0.0 if positive else number < 0.0
    if too_small or not math.isfinite(number):
        raise ValueError(f"{name} must be {expected}, got {value!r}")

    return number


def check_numbers(name: str, value: ArrayLike, expected: str, count: int) -> list[float]:
    """Return a sequence of `count` numbers as floats.

    Args:
        name: Name of the argument.
        value: Its value.
        expected: What it must be, in words.
        count: How many numbers it must have.

    Raises:
        ValueError: If there are not so many, or not all are finite.
    """
    array = _to_floats(value, f"{name} must be {expected}")
    if array.shape != (count,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be {expected}, got {value!r}")

    numbers: list[float] = array.tolist()
    return numbers


def check_integer(name: str, value: Any, least: int) -> int:
    """Return an integer.

    Raises:
        ValueError: If it is none, or below `least`.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1

    if number < least:
        raise ValueError(f"{name} must be an integer >= {least}, got {value!r}")
    return number


def check_size(name: str, width: int, height: int) -> tuple[int, int]:
    """Return (width, height) of a picture, px.

    Raises:
        ValueError: If one is not an integer >= 1.
    """
    return check_integer(f"{name}_width", width, 1), check_integer(f"{name}_height", height, 1)


def check_action(action: ArrayLike, shape: tuple[int, ...], meaning: str) -> FloatArray:
    """Return an action as float64.

    Args:
        action: The action.
        shape: The shape it must have.
        meaning: What its numbers are, in words.

    Raises:
        ValueError: If it is no array of numbers of this shape, or not finite.
    """
    expected = f"action must be {meaning} of shape {shape}"
    command = _to_floats(action, expected)
    if command.shape != shape:
        raise ValueError(f"{expected}, got shape {command.shape}")
    if not np.isfinite(command).all():
        raise ValueError(f"action must be finite, got {command.tolist()}")
    return command


def copy_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the options of a reset as a dictionary of one's own, empty for None.

    Raises:
        ValueError: If they are no mapping.
    """
    if options is not None and not isinstance(options, Mapping):
        raise ValueError(f"options must be a dictionary or None, got {options!r}")
    return dict(options or {})


def fields_of(kind: type[Fields], given: Mapping[str, Any], env: type) -> Fields:
    """Return a dataclass whose fields are further arguments of an environment.

    Args:
        kind: The dataclass.
        given: The arguments.
        env: The environment that they were given to.

    Raises:
        TypeError: If a name is unknown; the message lists the valid ones, the environment's too.
    """
    names = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]  # it is one
    unknown = sorted(set(given) - set(names))
    if unknown:
        parameters = inspect.signature(env).parameters.values()
        own = [each.name for each in parameters if each.kind is not each.VAR_KEYWORD]
        named = ", ".join((*own, *names))
        raise TypeError(f"unknown argument {', '.join(unknown)}; valid arguments are {named}")
    return kind(**given)


def given_options(options: Mapping[str, Any] | None, valid: Iterable[str]) -> dict[str, Any]:
    """Return the options of a reset that are not None.

    Raises:
        ValueError: If they are no mapping, or one is unknown; the message lists the valid ones.
    """
    options, valid = copy_options(options), tuple(valid)

    unknown = sorted(str(name) for name in options if name not in valid)
    if unknown:
        raise ValueError(
            f"unknown option {', '.join(unknown)}; valid options are {', '.join(valid)}"
        )

    return {name: value for name, value in options.items() if value is not None}


def check_vertices(name: str, value: ArrayLike, unit: str) -> FloatArray:
    """Return the vertices of a polygon, ``(n, 2)``.

    Raises:
        ValueError: If they are not three or more pairs of finite numbers.
    """
    expected = f"{name} must be at least three vertices (x, y) in {unit}, shape (n, 2), all finite"
    vertices = _to_floats(value, expected)
    is_list_of_vertices = vertices.ndim == 2 and vertices.shape[1] == 2 and len(vertices) >= 3
    if not is_list_of_vertices or not np.isfinite(vertices).all():
        raise ValueError(f"{expected}, got {value!r}")
    return vertices


def _to_floats(value: ArrayLike, expected: str) -> FloatArray:
    """Return numbers as an array; where they are none, an error says what was expected."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{expected}, got {value!r}") from error


def is_sequence(value: object) -> bool:
    """Whether a value is a list, tuple or array, and not one number or word."""
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)
