"""Options of velocity dampers, and of the escape from where they bring an actuator to rest."""

from dataclasses import dataclass, field

from aicon_torch.errors import OptionError
from aicon_torch.validation import check_flags, check_positive, check_whole


@dataclass(frozen=True)
class PlaceEscape:
    """Where constraints bring an actuator to rest, it goes to another place and tries from there.

    At this place the goals would be reached. Such places are sought while the robot moves, and the
    next one is tried where the way is blocked. As long as none is known, a fixed sequence names
    places in the middle half of the actuator's range, mirrored where a component was at its stop
    when it was held up last. :class:`aicon_torch.safety.places.Places` has the rules.

    Attributes:
        near: A cost below this, in its unit, is near enough to stay.
        patience: For how long a cost may fail to fall: the way that an actuator at its limit goes
            in this time, rad for an arm.
        remembers: Whether it remembers at which stops its components were held up.
        whole: How many of the first and of the last components use their whole ranges.
        seeks: Whether places at which the goals would be reached are sought.
        looks_ahead: Whether places of the sequence are skipped where a gap would be closed there or
            halfway; each step looks at one of the two. The sequence has its turn sooner then, since
            more of its places can be reached.
        gives_up: After how many places it goes to where the goals were nearest, and stays; None
            for never.

    Raises:
        OptionError: If patience, near or gives_up is no positive number, gives_up a whole one, or
            a flag is neither True nor False.
    """

    near: float = 0.005
    patience: float = 0.45
    remembers: bool = True
    whole: tuple[int, int] = (0, 0)
    seeks: bool = True
    looks_ahead: bool = False
    gives_up: int | None = None

    def __post_init__(self) -> None:
        """Check numbers and flags."""
        check_flags(self)
        check_positive(self, ("near", "patience"))
        check_whole(self, ("gives_up",))


@dataclass(frozen=True)
class WayAround:
    """What is done where constraints bring to rest an actuator that follows somebody's proposal.

    The actuator moves along the constraints until it has come farther in the direction that is
    proposed than where it was held up: :class:`aicon_torch.safety.way_around.Around` has the rules.
    """


@dataclass(frozen=True)
class VelocityDampers:
    """A gap closes the slower, the smaller it is (Faverjon and Tournassoud 1987).

    For every gap d ≥ 0 of the safety goals: ḋ ≥ −d/T, so that it shrinks no faster than
    exponentially. T = braking / a_max, with the median of the actuator's limits: a robot twice as
    fast brakes on the same way. Every step takes the action nearest to the nominal one that keeps
    this, see :func:`aicon_torch.safety.nearest_safe`.

    Attributes:
        braking: The way on which an actuator at its limit comes to rest, in the unit of its action
            times s: rad for an arm.
        escape: How a stalemate is left; None stays there.
        sweeps: Of the solver, at most: what they have not found yet is drawn back toward rest.
            None finds the action exactly, which pays among many gaps; nothing is learned through
            it.
        haste: The action comes as near as it can to this many times the nominal one. Where the
            actuator has a metric, components that are not at their limits then go on faster, as
            far as the metric gains by it; at 1 the nominal action is within the limits as it is.

    Raises:
        OptionError: If one is no positive number, sweeps a whole one, or there is haste with a
            :class:`WayAround`.

    Example:
        >>> Actuator(6, "rad/s", limit=(3.1,) * 6, dampers=VelocityDampers(braking=0.3))
    """

    braking: float = 0.3
    escape: PlaceEscape | WayAround | None = field(default_factory=PlaceEscape)
    sweeps: int | None = 12
    haste: float = 1.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("braking", "haste"))
        check_whole(self, ("sweeps",))
        if self.escape is not None and not isinstance(self.escape, PlaceEscape | WayAround):
            raise OptionError(
                f"escape={self.escape!r}: expected PlaceEscape(), WayAround() or None, which stays."
            )
        if isinstance(self.escape, WayAround) and self.haste != 1.0:
            raise OptionError(
                f"haste={self.haste!r}: expected 1 with a WayAround, since nothing moves faster "
                "than is proposed."
            )
