"""The numbers of the contact model, the same for every world in which something is pushed.

Lengths are shares of a reference length, the size of the object, so that a smaller or larger world
needs no new ones.
"""

from dataclasses import dataclass
from typing import get_args

from aicon_torch.parts.contact import ContactLikelihood
from aicon_torch.parts.contact_dynamics import ContactDynamics, ContactEffect
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.validation import check_choice, check_not_negative, check_positive


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
