"""Colours of the view, red, green and blue up to 255: the same in every world."""

Color = tuple[int, int, int]

# Colours that colour-blind readers can tell apart, most of them those of the figures.
ROBOT: Color = (0, 89, 168)
TRAIL: Color = (132, 172, 211)
TARGET: Color = (196, 18, 47)
BELIEF: Color = (230, 180, 0)
OBSTACLE: Color = (60, 64, 72)
OBJECT: Color = (195, 200, 208)
OBJECT_RED: Color = (204, 31, 31)
BODY: Color = (120, 160, 205)
OUTLINE: Color = (92, 99, 110)
GOAL: Color = (95, 181, 69)
GROUND: Color = (247, 247, 243)
EXPLORING: Color = (163, 86, 155)
RESOLVED: Color = (20, 24, 32)

# Gradients: those that draw nearer, those that make certain, those that keep away.
TOWARDS: Color = (0, 146, 104)
CERTAINTY: Color = (86, 180, 233)
AWAY: Color = (213, 94, 0)

# Goals by number, where a world says nothing else.
GOALS: tuple[Color, ...] = (
    TOWARDS,
    AWAY,
    CERTAINTY,
    (230, 159, 0),
    (204, 121, 167),
    (0, 114, 178),
    (110, 110, 110),
)


def to_hex(color: Color) -> str:
    """A colour as a page writes it, "#0059a8"."""
    return "#{:02x}{:02x}{:02x}".format(*color)
