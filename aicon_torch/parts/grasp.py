"""The grasp: how likely a gripper is to hold an object, and how the object then moves with it.

It is built like the contact of a pusher (:mod:`aicon_torch.parts.contact`): a likelihood that is
raised where the goal wants the object to move, and lowered where it does not, and the position of
what moves it. A contact moves an object along its normal; a grasp moves it anywhere.
"""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.parts.contact import likelihood_across
from aicon_torch.parts.gripper import Gripper
from aicon_torch.parts.planar import norm
from aicon_torch.shaping import by_sign, by_worth, straight_through
from aicon_torch.validation import check_positive, numbers

STEEPNESS = 4.0
"""How steeply the way leads up from an object's side, no unit."""


def way_from_above(
    offset: Tensor, slack: float, clearance: float, lacking: Tensor | None = None
) -> Tensor:
    """How far it is to a place to which one comes from above, ‖Δ − h e_z‖, ``(*B,)``, m.

    It is aimed above the place by h = min(c, 4 max(0, ‖Δ_xy‖ − r, w)): that rises while one is
    beside the place, or has no room for what stands there, and sinks as one comes.

    Args:
        offset: Δ, from the place, ``(*B, n)``, m, where x, y and z come first.
        slack: r, how far aside one may sink, m.
        clearance: c, the height at which nothing stands in the way, m.
        lacking: w, by how much that room is too narrow, ``(*B,)``, m.
    """
    beside = norm(offset[..., :2]) - slack
    if lacking is not None:
        beside = torch.maximum(beside, lacking)

    above = (STEEPNESS * beside).clamp(min=0.0).clamp(max=clearance)
    above = stop(above)  # stops the gradient: where to aim is no goal
    return norm(offset - above.unsqueeze(-1) * upward(offset))


def upward(offset: Tensor) -> Tensor:
    """e_z ``(n,)`` of what has components x, y, z and perhaps more, ``(*B, n)``."""
    return offset.new_tensor([float(axis == 2) for axis in range(offset.shape[-1])])


@dataclass(frozen=True)
class Grasp:
    """p_grasp: how likely it is that a gripper comes to hold an object, from above.

    It is exp(−D/ℓ) with the way D that is left. With the offset Δ of the tip from where it holds
    the object, and b how surely the object is between the fingers, b = exp(−(‖Δ‖/r)⁶),

        D = ‖Δ − h e_z‖ + b (o − o_min) + (1 − b) (o_max − o).

    So the fingers open on the way and close about the object. While the tip is beside the object by
    more than the slack of the open fingers, or these are by w too narrow for its diagonal, it is
    aimed above it, four times as far, up to a clearance:

        h = min(c, 4 max(0, ‖Δ_xy‖ − r, w)),    w = (1 − b) (min(√2 s, o_max) − o).

    So it rises before it comes, does not push, and does not close on the object's upper edge.

    Letting go is the other sign of the same path. Where p_grasp is to be reduced, the fingers open;
    as long as they are closed, the tip stays in the middle, and as they open, it rises until they
    are about the object no longer, a = exp(−(‖Δ‖/s)⁶), since they would drag it along:

        D = o + a ((1 − t) Δ_z − t ‖Δ‖),    t = (o_max − o)/(o_max − o_min).

    A hand that is about another object does not come to hold this one, either: p_grasp counts by
    Π (1 − a) over the others.

    Fingers that turn have a fourth component: how far they are turned from the object's side, as
    the way rψ of a point at its edge.

    Attributes:
        gripper: The gripper.
        size: s, width and height of the object, m: r is half of it.
        height: Where the tip holds the object, above its centre, m.
        reach: ℓ, m.
        clearance: c, the height above the object at which nothing stands in the way, m; by default
            its own.

    Raises:
        OptionError: If a length is not positive, or the height no number.
    """

    gripper: Gripper
    size: float
    height: float
    reach: float
    clearance: float | None = None

    def __post_init__(self) -> None:
        """Check the lengths."""
        check_positive(self, ("size", "reach"))
        numbers("height", self.height, 1)
        if self.clearance is not None:
            check_positive(self, ("clearance",))

    def likelihood(self, x_rel: Tensor, x_opening: Tensor, *others: Tensor) -> Tensor:
        """p_grasp, ``(*B, 1)``.

        Args:
            x_rel: The tip from the object's centre, ``(*B, 3)``, or with the turn ``(*B, 4)``, m.
            x_opening: The opening, ``(*B, 1)``, m.
            others: The tip from other objects, like x_rel.
        """
        offset, opening = self._offset(x_rel), x_opening[..., 0]
        between = self.between(x_rel).squeeze(-1)
        too_open, too_narrow = opening - self.gripper.narrowest, self.gripper.widest - opening

        # D: the way to the place, with the fingers closed as far as the object is between them.
        around = min(math.sqrt(2) * self.size, self.gripper.widest)
        lacking = (1 - between) * (around - opening)
        clearance = self.size if self.clearance is None else self.clearance
        approach = way_from_above(offset, self.size / 2, clearance, lacking)
        way = approach + between * too_open + (1 - between) * too_narrow

        # To let go has a way of its own: the fingers open in the middle, and then the tip rises.
        shut = stop(too_narrow / self.gripper.range)  # stops the gradient: it weighs
        leave = (1 - shut) * offset[..., 2] - shut * norm(offset)
        let_go = straight_through(way, opening + self.about(x_rel).squeeze(-1) * leave)

        # p_grasp in value; whether it is to grow or to fall decides which way leads there.
        grasped, released = (likelihood_across(gap, self.reach) for gap in (way, let_go))
        likelihood = by_sign(released, grasped).unsqueeze(-1)
        for other in others:
            likelihood = likelihood * (1 - self.about(other))
        return likelihood

    def between(self, x_rel: Tensor) -> Tensor:
        """b, how surely the object is between the fingers, ``(*B, 1)``."""
        return self._within(x_rel, self.size / 2)

    def about(self, x_rel: Tensor) -> Tensor:
        """a, how surely the fingers are about the object, and would drag it along, ``(*B, 1)``."""
        return self._within(x_rel, self.size)

    def _within(self, x_rel: Tensor, length: float) -> Tensor:
        """exp(−(‖Δ‖/l)⁶), ``(*B, 1)``."""
        share = norm(self._offset(x_rel)) / length
        likely = torch.exp(-(share**6))
        return stop(likely).unsqueeze(-1)  # stops the gradient: it weighs, and is no goal

    def _offset(self, x_rel: Tensor) -> Tensor:
        """Δ, like x_rel, m."""
        return x_rel - self.height * upward(x_rel)


class Held(Estimator):
    """p_held: how likely the object is held now, b exp(−(2 (o − o_min)/r)²), ``(*B, 1)``.

    What a step foresees is that it stays so: what is about to be closed moves nothing yet.

    Args:
        grasp: The grasp.
        name: What the names p_held and x_rel end with, where there are several objects.
        by_open_fingers: Whether it is held by fingers that are open, too, as a bar is that they go
            around: p_held = b.
    """

    nothing: Tensor

    def __init__(self, grasp: Grasp, name: str = "", by_open_fingers: bool = False) -> None:
        super().__init__()
        self.grasp, self.apart, self.by_open_fingers = grasp, f"x_rel{name}", by_open_fingers
        self.outputs = (f"p_held{name}",)
        self.inputs = (*self.outputs, self.apart, "x_opening")
        self.register_buffer("nothing", torch.zeros(1))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """Nothing is held."""
        return {self.outputs[0]: self.nothing}

    @torch.no_grad()
    def update(self, values: Values) -> dict[str, Tensor]:
        """How likely it is held, ``(*B, 1)``."""
        between = self.grasp.between(values[self.apart])
        if self.by_open_fingers:
            return {self.outputs[0]: between}

        # r is half of the size, so (2 (o − o_min)/r)² is (4 (o − o_min)/size)².
        too_open = values["x_opening"] - self.grasp.gripper.narrowest
        closed = torch.exp(-((4 * too_open / self.grasp.size) ** 2))
        return {self.outputs[0]: between * closed}

    def forward(self, values: Values, output: str) -> Tensor:
        """As it is now."""
        return stop(values[output])  # stops the gradient: p_grasp has it


def carried(x_object: Tensor, p_held: Tensor, a: Tensor, dt: Tensor) -> Tensor:
    """Where an object is after a step, x + p_held a dt, ``(*B, 3)``, m: it moves with the tip.

    Args:
        x_object: Its centre, ``(*B, 3)``, m.
        p_held: How likely it is held, ``(*B, 1)``.
        a: Velocity of the tip, ``(*B, 3)``, m/s.
        dt: s.
    """
    return x_object + stop(p_held) * a * dt  # stops the gradient, as all of p_held's


def approached(x_rel: Tensor, p_held: Tensor, a: Tensor, dt: Tensor) -> Tensor:
    """Where the tip then is from the object, Δ + (1 − p_held) a dt, ``(*B, 3)``, m."""
    return x_rel + (1 - stop(p_held)) * a * dt  # stops the gradient, as all of p_held's


@dataclass(frozen=True)
class Carrying:
    """x_obj: where the object goes, by three paths.

    A grasp may move it anywhere (p_grasp); on a table it moves aside only as far as it is off it
    (p_free), so that it is lifted before it is carried; and held, it goes where the tip goes.

    Attributes:
        step: s, m: how far a motion that is certain may take the object.
        rest: Height of its centre on the table, m.
        rise: Rise at which nothing holds it back, m.

    Raises:
        OptionError: If a length is not positive.
    """

    step: float
    rest: float
    rise: float

    def __post_init__(self) -> None:
        """Check the lengths."""
        check_positive(self, ("step", "rise"))
        numbers("rest", self.rest, 1)

    def free(self, x_object: Tensor) -> Tensor:
        """p_free ``(*B, 1)``: the rise of an object ``(*B, n)``, m, in rises, at most 1."""
        return ((x_object[..., 2:3] - self.rest) / self.rise).clamp(max=1.0)

    def __call__(
        self, x_object: Tensor, x_tip: Tensor, p_grasp: Tensor, p_held: Tensor, p_free: Tensor
    ) -> Tensor:
        """x_obj: the object where it is, with the gradients of what may move it.

        Args:
            x_object: Its centre, ``(*B, 3)``, or with its turn ``(*B, 4)``, m.
            x_tip: The tip, like it, m.
            p_grasp: How likely it comes to be held, ``(*B, 1)``.
            p_held: How likely it is held, ``(*B, 1)``.
            p_free: How free of the table it is, ``(*B, 1)``.

        Returns:
            ``(*B, 3)``, m.
        """
        p_held = stop(p_held)  # stops the gradient: that of a grasp is p_grasp's

        # What a grasp is worth, which moves the object anywhere, and what it is worth to be free of
        # the table, which moves it aside and not up.
        anywhere = by_worth(p_grasp, x_object, self.step)
        aside = by_worth(p_held * p_free, x_object[..., :2], self.step)
        upright = torch.zeros_like(x_object[..., 2:])

        # What is held goes where the tip goes: up at once, aside as far as it is off the table.
        share = (p_held * p_free.clamp(min=0.0)).expand_as(aside)
        follows = torch.cat((share, p_held.expand_as(upright)), dim=-1)
        follows = stop(follows)  # stops what the likelihoods are told
        return straight_through(
            x_object, anywhere + torch.cat((aside, upright), dim=-1) + follows * x_tip
        )
