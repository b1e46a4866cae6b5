"""Room at a place: how likely something can be put there, among others that may be moved."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.parts.grasp import upward, way_from_above
from aicon_torch.parts.planar import norm
from aicon_torch.shaping import straight_through
from aicon_torch.validation import check_not_negative, check_positive

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
        OptionError: If a length is not positive, or the slack negative.
    """

    size: float
    rest: float
    slack: float
    clearance: float

    def __post_init__(self) -> None:
        """Check the lengths."""
        check_positive(self, ("size", "rest", "clearance"))
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
        on_table = place[..., 2] < self.rest + self.size / 2
        carried = on_table.to(place)
        below = place - self.size * upward(place)

        for number, (thing, its_place) in enumerate(things):
            # How near it is; however far away, it can come nearer.
            way = way_from_above(thing[..., :3] - below, self.slack, self.clearance)
            near = straight_through(self._near(way), (2 - way / self.size).clamp(max=1.0))

            # It counts as far as its own place carries it; what is missing there counts in full.
            rest = things[:number] + things[number + 1 :]
            support = self._carried(its_place, rest)
            carries = straight_through(near * support, near * stop(support) + support)

            depth = self._depth(place, its_place)
            belongs_right_below = (depth > 0) & (depth < 1.5 * self.size)
            carried = torch.where(belongs_right_below & ~on_table, carries, carried)
        return carried

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
