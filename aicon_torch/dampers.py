"""Options of velocity dampers, and of the escape from where they bring an actuator to rest."""

from dataclasses import dataclass, field, fields

from aicon_torch.errors import OptionError


@dataclass(frozen=True)
class ConstraintEscape:
    """What is done where constraints bring an actuator to rest: the conflict of a goal with them.

    All times are multiples of the dampers' time constant T, so a faster robot needs no new number.

    A *stalemate* is that for ``patience`` the cost of the goals has not fallen by the share
    ``progress``, although the constraints oppose the wish or it has not risen by that share either.
    (A cost that comes and goes while nothing is in the way is the noise of the readings.)

    Then the actuator moves along the constraints' force f = Σ μᵢcᵢ, what they add to the wish to
    make it the action where all components count alike, in the direction that f had at the
    stalemate, and within the same constraints. The cost climbs on the way. It ends well over the
    crest, or else it would slide back: once the share ``descent`` of the climb is undone, where the
    cost, fallen by ``progress`` from the crest, rises again, or where the motion is blocked as
    well.

    It makes a detour instead where the constraints do not oppose the wish, as at a singularity,
    where ``forced`` escapes have led to no better cost, and where the force points back against the
    last escape, as between two stops of one joint. A detour goes straight to a place, from
    where the goals are tried anew: the next of a sequence that fills the middle of the components'
    ranges evenly. Where a safety goal tells no range (see :class:`aicon_torch.Goal`), it is what
    lies around.

    Attributes:
        progress: Share by which the cost must fall, or rise.
        patience: For how long it may fail to.
        near: A cost below this, in its unit, is near enough to stay.
        forced: Number of escapes along the force, from the last best cost on.
        opposition: Share of the wish that the constraints must take away to oppose it.
        shortest: Least duration of an escape along the force.
        longest: Largest.
        descent: Share of the climb that must be undone.
        back: Cosine of the angle to the last escape reversed, within which a force points back.
        blocked: Share of the actuator's limit below which a motion counts as blocked.
        middle: Share of each component's range, about its middle, that places are in.
        detour: Where a component has no range, it goes as far as it comes in this time, at most.

    Raises:
        OptionError: If a number is not positive.
    """

    progress: float = 0.1
    patience: float = 2.0
    near: float = 0.005
    forced: int = 2
    opposition: float = 0.1
    shortest: float = 1.5
    longest: float = 15.0
    descent: float = 0.5
    back: float = 0.7
    blocked: float = 0.05
    middle: float = 0.5
    detour: float = 6.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_positive(self, tuple(option.name for option in fields(self)))


@dataclass(frozen=True)
class VelocityDampers:
    """A gap closes the slower, the smaller it is (Faverjon and Tournassoud 1987).

    For every gap d ≥ 0 of the safety goals: ḋ ≥ −d/T, so that it shrinks no faster than
    exponentially. T = braking / a_max, with the median of the actuator's limits: a robot twice as
    fast brakes on the same way. Every step takes the action nearest to the wish that keeps this,
    see :func:`aicon_torch.safety.nearest_safe`.

    Attributes:
        braking: The way on which an actuator at its limit comes to rest, in the unit of its action
            times s: rad for an arm.
        gaps: Of each goal as many gaps are considered, the smallest.
        sweeps: Number of sweeps of the solver.
        escape: How a stalemate is left; None stays there.

    Raises:
        OptionError: If a number is not positive.

    Example:
        >>> Actuator(6, "rad/s", limit=(3.1,) * 6, dampers=VelocityDampers(braking=0.3))
    """

    braking: float = 0.3
    gaps: int = 8
    sweeps: int = 12
    escape: ConstraintEscape | None = field(default_factory=ConstraintEscape)

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_positive(self, ("braking", "gaps", "sweeps"))


def _check_positive(options: object, names: tuple[str, ...]) -> None:
    """Check that fields of some options are positive."""
    for name in names:
        value = getattr(options, name)
        if not value > 0:
            raise OptionError(f"{name}={value!r}: expected a number > 0.")
