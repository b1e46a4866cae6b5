"""Room at a place: how likely something can be put there, among others that may be moved."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.parts.grasp import upward, way_from_above
from aicon_torch.parts.planar import norm
from aicon_torch.shaping import straight_through
from aicon_torch.validation import check_not_negative, check_positive, numbers

Thing = tuple[Tensor, Tensor]
"""Of an object its centre ``(*B, n)`` and the place where it belongs ``(*B, 3)``, m."""


@dataclass(frozen=True)
class Room:
    """p_room: how likely a place takes an object, because it is vacant and carries it.

    With how near another object is that is a gap d away, n(d) = clip(2 − d/s, 0, 1), a place is
    vacant by Π (1 − n(d_xy)) over those that are no lower than it, as one comes from above; those
    that belong below it take no place from it. It carries by 1 where the table does, and elsewhere
    by c n(d) of the one that belongs right below it, with the way d from above
    (:func:`way_from_above`) to g − s e_z, and with c, by how much the place of that one carries it.
    Nothing says which object goes first: a place that is taken, or carried by nothing yet, makes
    its goal worth less, and worth clearing, or building from the lowest on.

    Attributes:
        size: s, width and height of an object, m.
        rest: Height of its centre on the table, m.
        slack: How far aside of its place an object may sink, m.
        clearance: The height at which nothing stands in its way, m.

    Raises:
        OptionError: If a length is not positive, the slack negative, or the height no number.
    """

    size: float
    rest: float
    slack: float
    clearance: float

    def __post_init__(self) -> None:
        """Check the lengths."""
        check_positive(self, ("size", "clearance"))
        numbers("rest", self.rest, 1)
        check_not_negative(self, ("slack",))

    def __call__(self, place: Tensor, *others: Tensor) -> Tensor:
        """p_room, ``(*B, 1)``.

        Args:
            place: g, ``(*B, 3)``, m.
            *others: Of each other object in turn its centre x, ``(*B, n)``, m, with x, y and z
                first, and the place where it belongs, ``(*B, 3)``, m.
        """
        things = list(zip(others[::2], others[1::2], strict=True))
        return (self._vacant(place, things) * self._carried(place, things)).unsqueeze(-1)

    def _vacant(self, place: Tensor, things: list[Thing]) -> Tensor:
        """How surely nothing takes a place, ``(*B,)``."""
        vacant = torch.ones_like(place[..., 0])
        for thing, its_place in things:
            # What is wholly in a place can still be moved out of it.
            beside = norm(thing[..., :2] - place[..., :2])
            takes = straight_through(self._near(beside), (2 - beside / self.size).clamp(min=0.0))

            is_lower = thing[..., 2] < place[..., 2] - self.size / 2
            belongs_below = self._depth(place, its_place) > 0
            vacant = vacant * (1 - torch.where(is_lower | belongs_below, 0.0, takes))
        return vacant

    def _carried(self, place: Tensor, things: list[Thing]) -> Tensor:
        """How surely a place is carried, ``(*B,)``: by the table, or by what is carried itself."""
        places = [its_place for _, its_place in things]
        below = [self._right_below(its_place, things) for its_place in places]
        carried = [self._on_table(its_place).to(place) for its_place in places]

        # From the table up: each round is exact for stacks that are one higher.
        for _ in things[1:]:
            carried = [
                self._carried_by(its_place, its_below, carried)
                for its_place, its_below in zip(places, below, strict=True)
            ]
        return self._carried_by(place, self._right_below(place, things), carried)

    def _right_below(self, place: Tensor, things: list[Thing]) -> list[tuple[Tensor, Tensor]]:
        """Of each thing whether it belongs right below a place, and how near it is, ``(*B,)``."""
        found: list[tuple[Tensor, Tensor]] = []
        below = place - self.size * upward(place)
        for thing, its_place in things:
            depth = self._depth(place, its_place)

            # However far away it is, it can come nearer.
            way = way_from_above(thing[..., :3] - below, self.slack, self.clearance)
            near = straight_through(self._near(way), (2 - way / self.size).clamp(max=1.0))
            found.append(((depth > 0) & (depth < 1.5 * self.size), near))
        return found

    def _carried_by(
        self, place: Tensor, below: list[tuple[Tensor, Tensor]], supports: list[Tensor]
    ) -> Tensor:
        """How surely a place is carried, ``(*B,)``, by how surely the places below it are."""
        on_table = self._on_table(place)
        carried = on_table.to(place)
        for (belongs_below, near), support in zip(below, supports, strict=True):
            # It counts as far as its own place carries it; what is missing there counts in full.
            carries = straight_through(near * support, near * stop(support) + support)
            carried = torch.where(belongs_below & ~on_table, carries, carried)
        return carried

    def _on_table(self, place: Tensor) -> Tensor:
        """Whether the table carries a place, ``(*B,)``."""
        return place[..., 2] < self.rest + self.size / 2

    def _depth(self, place: Tensor, other: Tensor) -> Tensor:
        """How far below a place another one of its column is, ``(*B,)``, m; 0 of another column."""
        in_column = norm((other - place)[..., :2]) < self.size
        return torch.where(in_column, place[..., 2] - other[..., 2], 0.0)

    def _near(self, gap: Tensor) -> Tensor:
        """n(d), ``(*B,)``."""
        return (2 - gap / self.size).clamp(0.0, 1.0)


def worth_of_room(cost: Tensor, p_room: Tensor) -> Tensor:
    """A cost ``(*B,)`` that only a place with room can lower: p c + (1 − p) c, each part once.

    Its value is c. The gradient of what lowers it counts by p, and that of p by c: where there is
    no room, what is worth something is to make some.

    Args:
        cost: c, ``(*B,)``.
        p_room: p, ``(*B, 1)``.
    """
    p = p_room[..., 0]
    # Stops of each product the factor whose gradient the other one has.
    return stop(p) * cost + (1 - p) * stop(cost)
