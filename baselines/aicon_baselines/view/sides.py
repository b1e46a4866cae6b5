"""Gradients by the side of an object that they come through: to touch it, or to leave it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from torch import Tensor

from aicon_baselines.palette import AWAY, TOWARDS
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.scene import GradientArrow


def by_sides(
    arrows: Sequence[GradientArrow],
    paths: Sequence[Sequence[str]],
    values: Mapping[str, Tensor],
    places: FloatArray,
) -> list[GradientArrow]:
    """The gradients at a pusher, each with the side that it comes from and what it wants there.

    Args:
        arrows: The gradients.
        paths: The path of each.
        values: What the policy knows: x_contact, the nearest point of each side, and x_pusher.
        places: Where the sides' points are drawn, (N, 2 or 3).
    """
    to_sides = (values["x_contact"] - values["x_pusher"].unsqueeze(-2))[0].numpy(force=True)

    found = []
    for arrow, path in zip(arrows, paths, strict=True):
        side = side_of(path)
        touches = float(arrow.direction[:2] @ to_sides[side]) > 0.0
        label = "touch this side" if touches else "leave this side"
        color = TOWARDS if touches else AWAY
        found.append(replace(arrow, label=label, color=color, source=places[side]))
    return found


def side_of(path: Sequence[str]) -> int:
    """The side that a path comes through, such as 3 of "x_contact[3]"."""
    found = re.search(r"\[(\d+)\]", " ".join(path))
    return int(found.group(1)) if found else 0
