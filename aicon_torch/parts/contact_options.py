"""The numbers of the contact model, the same for every world in which something is pushed.

Lengths are shares of a reference length, the size of the object, so that a smaller or larger world
needs no new ones.
"""

from dataclasses import dataclass
from typing import get_args

from aicon_torch.errors import OptionError
from aicon_torch.parts.contact import ContactLikelihood
from aicon_torch.parts.contact_dynamics import ContactDynamics, ContactEffect
from aicon_torch.parts.contact_limits import ContactLimits
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.validation import (
    check_choice,
    check_not_negative,
    check_positive,
    numbers,
)


@dataclass(frozen=True)
class ContactOptions:
    """What a contact does and how likely it is.

    Attributes:
        size: The reference length, m: the width of the T in the world at hand.
        effect: What a contact does: see :class:`ContactDynamics`.
        rotation: L in radii of gyration: a rotation by one rad counts as much as a translation by
            L.
        intent: T of the soft choice between the two likelihoods; 0 chooses by the sign of a
            contact's gain.
        reach: ℓ of the likelihood of contacts that help, in sizes.
        reaction: ℓ' of the likelihood of contacts that harm, in sizes.
        aim: How far outside its side a contact that helps is aimed at, in sizes.
        inset: How far from the ends of its side it is aimed at, in radii of the pusher.
        facing: Whether harm at a corner counts as far as the side faces the pusher.
        step: How far a contact that is certain moves the object, in sizes.
    """

    size: float
    effect: ContactEffect = "quasi_static"
    rotation: float = 1.55
    intent: float = 0.0
    reach: float = 1 / 4
    reaction: float = 1 / 12
    aim: float = 1 / 15
    inset: float = 0.0
    facing: bool = True
    step: float = 1 / 120

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            OptionError: If one is not what it may be.
        """
        check_positive(self, ("size", "rotation", "reach", "reaction", "step"))
        check_not_negative(self, ("aim", "inset", "intent"))
        check_choice(self, "effect", get_args(ContactEffect))

    def rotation_length(self, body: RigidObject) -> float:
        """L for an object, m."""
        return self.rotation * body.radius_of_gyration

    def dynamics(self, body: RigidObject) -> ContactDynamics:
        """What a contact does to an object."""
        return ContactDynamics(
            body,
            rotation_length=self.rotation_length(body),
            step=self.step * self.size,
            effect=self.effect,
            intent=self.intent,
        )

    def likelihood(self, radius: float) -> ContactLikelihood:
        """How likely a contact of a pusher with a radius (m) is."""
        return ContactLikelihood(
            reach=self.reach * self.size,
            reaction=self.reaction * self.size,
            aim=self.aim * self.size,
            facing=self.facing,
            radius=radius,
            inset=self.inset * radius,
        )


@dataclass(frozen=True)
class ContactLimitOptions:
    """Bounds on the next displacement near contact: see :class:`ContactLimits`.

    Attributes:
        push: Least and largest push at a contact that helps, in sizes.
        harm: Largest push at one that harms, in sizes.
        slide_gap: Gap below which the pusher is kept from sliding off a side, in sizes; 0 never.
        end_step: How far it may slide beyond the end of a side in one step, in sizes.
    """

    push: tuple[float, float] = (1 / 240, 1 / 24)
    harm: float = 1 / 120
    slide_gap: float = 1 / 8
    end_step: float = 1 / 40

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            OptionError: If one is not what it may be.
        """
        check_not_negative(self, ("harm", "slide_gap", "end_step"))
        least, largest = numbers("push", self.push, 2)
        if not 0 <= least <= largest:
            raise OptionError(f"push={self.push!r}: expected (least, largest), in sizes.")

    def limits(self, dynamics: ContactDynamics, radius: float, size: float) -> ContactLimits:
        """The limits of a pusher.

        Args:
            dynamics: What a push does.
            radius: Radius of the pusher, m.
            size: The reference length, m.
        """
        least, largest = self.push
        return ContactLimits(
            dynamics,
            radius=radius,
            push=(least * size, largest * size),
            harm=self.harm * size,
            slide_gap=self.slide_gap * size,
            end_step=self.end_step * size,
        )
