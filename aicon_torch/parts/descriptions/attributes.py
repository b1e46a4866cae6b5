"""The names and numbers of an XML element, checked: errors name the element they belong to."""

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError

LARGEST_NUMBER = 1e9
"""Of a length, in m, or an angle, in rad. What is larger is no robot, and would overflow."""


def text_of(element: ElementTree.Element, attribute: str, owner: str) -> str:
    """A word or name that an element must have.

    Args:
        element: The element.
        attribute: Which of its attributes.
        owner: What an error calls the element, such as ``"Joint 'elbow'"``.

    Raises:
        OptionError: If it is not there, or empty.
    """
    text = element.get(attribute)
    if not text:
        raise OptionError(f"{owner}: <{element.tag}> has no {attribute}=; expected a name.")
    return text


def positive_of(element: ElementTree.Element, attribute: str, owner: str) -> float:
    """A number above zero that the element must have, such as a radius (m); see :func:`text_of`."""
    number = _number(element.get(attribute, ""))
    if not 0.0 < number <= LARGEST_NUMBER:
        raise _wrong(element, attribute, owner, "a number above 0")
    return number


def numbers_of(
    element: ElementTree.Element,
    attribute: str,
    owner: str,
    default: tuple[float, ...] | None = None,
) -> NDArray[Any]:
    """Three finite numbers, such as a position (m); see :func:`text_of`.

    Args:
        element: The element.
        attribute: Which of its attributes.
        owner: What an error calls the element.
        default: The numbers where the element names none; None if it must.
    """
    text = element.get(attribute)
    if text is None and default is not None:
        return np.array(default)

    numbers = np.array([_number(word) for word in (text or "").split()])
    if len(numbers) != 3 or not (np.abs(numbers) <= LARGEST_NUMBER).all():
        raise _wrong(element, attribute, owner, f"3 numbers within ±{LARGEST_NUMBER:.0e}")
    return numbers


def limit_of(element: ElementTree.Element, attribute: str, owner: str, default: float) -> float:
    """A bound, which may be infinite; see :func:`text_of`."""
    text = element.get(attribute)
    number = default if text is None else _number(text)
    if math.isnan(number):
        raise _wrong(element, attribute, owner, "a number")
    return number


def _number(word: str) -> float:
    """A word as a number; NaN where it is none."""
    try:
        return float(word)
    except ValueError:
        return math.nan


def _wrong(element: ElementTree.Element, attribute: str, owner: str, expected: str) -> OptionError:
    """The error about an attribute that is not what it may be."""
    text = element.get(attribute)
    if text is None:
        return OptionError(f"{owner}: <{element.tag}> has no {attribute}=; expected {expected}.")
    return OptionError(
        f"{owner}: <{element.tag} {attribute}={_shortened(text)!r}>: expected {expected}."
    )


def _shortened(text: str) -> str:
    """A text that an error can quote."""
    return text if len(text) <= 60 else f"{text[:57]}..."
