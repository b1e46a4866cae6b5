"""The colours of figures, films and the live view: what each of them means.

Colour-blind readers can tell them apart (after Okabe and Ito, "Color Universal Design", 2008).
"""

# The world: what moves, what is to be reached and what is in the way.
ROBOT, TRAIL, BODY = "#0059a8", "#84acd3", "#78a0cd"
TARGET, OBSTACLE = "#c4122f", "#3c4048"
OBJECT, OBJECT_RED, OUTLINE, GOAL = "#c3c8d0", "#cc1f1f", "#5c636e", "#5fb545"
GROUND, WALL, WHITE = "#f7f7f3", "#eceef0", "#ffffff"

# The policy: what it believes, and what it does.
BELIEF = "#e6b400"
EXPLORING, RESOLVED, MOTION = "#a3569b", "#141820", "#f4d35e"

# Gradients: those that draw nearer, those that make certain, those that keep away.
TOWARDS, CERTAINTY, AWAY = "#009268", "#56b4e9", "#d55e00"

# Curves of what is left to do.
DISTANCE, ANGLE = ROBOT, CERTAINTY

# Words and lines: dark, pale, and one that recedes.
INK, PALE, BADGE = "#1d2127", "#8a919c", "#6d747e"

CURVES = (ROBOT, AWAY, TOWARDS, "#c99700", CERTAINTY, OBSTACLE, TARGET)
"""Curves in one diagram, by number."""

GOALS = (TOWARDS, AWAY, CERTAINTY, "#e69f00", "#cc79a7", "#0072b2", "#6e6e6e")
"""Goals by number, where a world says nothing else."""


def rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue of a colour such as "#0059a8", up to 255.

    Raises:
        ValueError: If it is not written so.
    """
    try:
        red, green, blue = bytes.fromhex(color.removeprefix("#"))
    except ValueError as error:
        raise ValueError(f"color={color!r}: expected one such as '#0059a8'.") from error
    return red, green, blue
