"""A handle, which a hand that holds it moves along one axis unless it is locked; and a button."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.errors import OptionError
from aicon_torch.parts.axis import check_axis
from aicon_torch.parts.contact import likelihood_across
from aicon_torch.parts.grasp import Grasp, way_from_above
from aicon_torch.parts.planar import norm
from aicon_torch.shaping import by_sign, by_worth, straight_through
from aicon_torch.validation import check_positive

END = 0.005
"""How near to an end of its way a handle is at it, m."""


@dataclass(frozen=True)
class Handle:
    """x_obj: where a handle goes, of a drawer or a window, along its axis e, a unit vector.

    A grasp may move it, as far as it is unlocked (p_grasp p_unlocked); where it is locked, what a
    motion would be worth is told to what unlocks it; and held, it goes where the tip goes.

    Attributes:
        step: s, m: how far a motion that is certain may take it.
        axis: e, from its first end to its last, no unit; no component is negative.
        travel: How far it goes, m.

    Raises:
        OptionError: If a length is not positive, or the axis is no unit vector, or a component of
            it negative.
    """

    step: float
    axis: tuple[float, float, float]
    travel: float

    def __post_init__(self) -> None:
        """Check lengths and axis."""
        check_positive(self, ("step", "travel"))
        check_axis("axis", self.axis)
        if min(self.axis) < 0:
            raise OptionError(
                f"axis={self.axis!r}: expected no component below 0; begin at the other end."
            )

    def along(self, motion: Tensor) -> Tensor:
        """What of a motion ``(*B, n)`` goes along the axis, e (e·m), like it."""
        rest = [0.0] * (motion.shape[-1] - len(self.axis))
        axis = motion.new_tensor([*self.axis, *rest])
        return (motion * axis).sum(-1, keepdim=True) * axis

    def carried(self, x_object: Tensor, p_held: Tensor, a: Tensor, dt: Tensor) -> Tensor:
        """Where it is after a step, x + p_held e (e·a) dt, ``(*B, n)``, m."""
        return x_object + stop(p_held) * self.along(a) * dt  # stops the gradient: p_grasp has it

    def approached(self, x_rel: Tensor, p_held: Tensor, a: Tensor, dt: Tensor) -> Tensor:
        """Where the tip then is from it, Δ + (a − p_held e (e·a)) dt, ``(*B, n)``, m."""
        return x_rel + (a - stop(p_held) * self.along(a)) * dt  # stops the gradient, likewise

    def __call__(
        self,
        x_object: Tensor,
        x_tip: Tensor,
        p_grasp: Tensor,
        p_held: Tensor,
        p_unlocked: Tensor,
        z_way: Tensor,
    ) -> Tensor:
        """x_obj: the handle where it is, with the gradients of what may move it.

        Args:
            x_object: Where it is, ``(*B, n)``, m.
            x_tip: The tip, like it, m.
            p_grasp: How likely it comes to be held, ``(*B, 1)``.
            p_held: How likely it is held, ``(*B, 1)``.
            p_unlocked: How likely it is unlocked, ``(*B, 1)``.
            z_way: How far it is from its first end, ``(*B, 1)``, m.

        Returns:
            ``(*B, n)``, m.
        """
        # Stops of each product the factor whose gradient is told otherwise.
        is_open, p_held = stop(p_unlocked), stop(p_held)
        grasped = by_worth(p_grasp * is_open, x_object, self.step)
        unlocked = by_worth(p_unlocked, x_object, self.step)
        follows = is_open * p_held * self.along(x_tip)
        moved = grasped + unlocked + follows

        # At an end nothing moves it on: no gradient that asks for that goes further.
        down = torch.where(z_way < END, stop(moved), moved)
        up = torch.where(z_way > self.travel - END, stop(moved), moved)
        return straight_through(x_object, by_sign(down, up))


@dataclass(frozen=True)
class Button:
    """z_state: whether a button is on, 1 or 0, which each press changes.

    p_press = exp(−D/ℓ) with the way D that is left: D = ‖Δ − h e_z‖ + o − o_min, where Δ is the tip
    from where the button is pressed down, and ℓ and h as for a grasp: closed fingers come to it
    from above, unless something is between them. If it is to stay as it is, the way leads upward
    instead: D = ‖Δ_xy‖ + Δ_z, of which the height alone has a gradient.

    Attributes:
        grasp: That of the same hand.
        clearance: The height at which nothing stands in the way, m.

    Raises:
        OptionError: If the clearance is not positive.
    """

    grasp: Grasp
    clearance: float

    def __post_init__(self) -> None:
        """Check the clearance."""
        check_positive(self, ("clearance",))

    def __call__(
        self, z_state: Tensor, x_tip: Tensor, x_opening: Tensor, pressed: Tensor, *others: Tensor
    ) -> Tensor:
        """z_state in value, with the gradient of a press, which changes it, ``(*B, 1)``.

        Args:
            z_state: 1 or 0, ``(*B, 1)``.
            x_tip: The tip, ``(*B, n)``, m, where x, y and z come first.
            x_opening: The opening, ``(*B, 1)``, m.
            pressed: Where the tip is when the button is down, ``(*B, 3)``, m.
            others: The tip from what the hand may hold, ``(*B, n)`` each, m.
        """
        narrowest = self.grasp.gripper.narrowest
        offset, too_open = x_tip[..., :3] - pressed, x_opening[..., 0] - narrowest
        way = way_from_above(offset, 0.0, self.clearance) + too_open
        upward = stop(norm(offset[..., :2])) + offset[..., 2]
        let_go = straight_through(way, upward)

        press = by_sign(*(likelihood_across(gap, self.grasp.reach) for gap in (let_go, way)))
        press = press.unsqueeze(-1)
        for other in others:
            press = press * (1 - self.grasp.between(other))
        return straight_through(z_state, (1 - 2 * z_state) * press)
