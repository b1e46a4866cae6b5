"""Limits of the pusher's motion near the object. They are ours: the text has none.

They are reactive: each is a bound on the next displacement that follows from where the pusher, the object and the
target are now. They belong to the actuator and know the target, like the goal; a goal that is switched off leaves them.
"""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.contact import norm, tangent
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.servo import RADIUS, Servo
from aicon_torch.vectors import select


def pose_error(x_obj: Tensor, x_target: Tensor, length: float) -> Tensor:
    """The object's error (x, y, length·θ), θ in [−π, π), ``(*B, 3)``, px."""
    error = x_obj - x_target
    angle = torch.remainder(error[..., 2:] + math.pi, 2 * math.pi) - math.pi
    return torch.cat((error[..., :2], length * angle), dim=-1)


@dataclass(frozen=True)
class ContactLimits:
    """A contact is pushed no farther than it helps, and the pusher does not slide far off the side that it pushes.

    One pass over the nearest sides takes away from the displacement d what goes beyond, nearest first; where sides form
    a notch a later one may push it back a little. Toward each side: d·n ≤ max(gap, 0) + s, where n points from the
    pusher to the side. A push by s moves the object by s·J, so s* = −E·J/|J|² brings the error E nearest to zero along
    it (a Gauss-Newton step on g = |E|). Where s* > 0 it is the bound, within [s_min, s_max]; elsewhere the pusher may
    not push farther than s_bad.

    Along the nearest side, if it is of use: |d·t| ≤ 0.7 (distance to the side's end) + 3 px, so that the pusher comes
    to the end in several steps and leaves it in small ones.

    Attributes:
        dynamics: What a push does.
        servo: Whose motion within the step must keep the bound too; None if only its end must.
        push: s_min and s_max, px.
        harm: s_bad, px.
        slide_gap: Gap to the nearest side below which the second limit acts, px; 0 switches it off.
        sides: Number of sides that are considered, the nearest ones.
        radius: Radius of the pusher, px.
    """

    dynamics: ContactDynamics
    servo: Servo | None
    push: tuple[float, float] = (0.5, 40.0)
    harm: float = 2.0
    slide_gap: float = 15.0
    sides: int = 4
    radius: float = RADIUS

    def __call__(
        self,
        a: Tensor,
        x_pusher: Tensor,
        v_pusher: Tensor,
        x_contact: Tensor,
        x_side: Tensor,
        x_obj: Tensor,
        x_target: Tensor,
        dt: float,
    ) -> Tensor:
        """The velocity within the limits, ``(*B, 2)``, px/s."""
        to_contact = x_contact - x_pusher.unsqueeze(-2)
        distance = norm(to_contact)
        normals, gaps = to_contact / distance.unsqueeze(-1), distance - self.radius
        gain = self.gain(x_contact, normals, x_obj, x_target)
        bounds = gaps.clamp(min=0.0) + torch.where(gain > 0, gain.clamp(*self.push), self.harm)
        nearest = gaps.topk(min(self.sides, gaps.shape[-1]), largest=False).indices
        normals = normals.gather(-2, nearest.unsqueeze(-1).expand(*nearest.shape, 2))
        bounds = bounds.gather(-1, nearest)
        if self.servo is not None:
            bounds = self.servo.farthest(bounds, (v_pusher.unsqueeze(-2) * normals).sum(-1))
        motion = a * dt
        for normal, bound in zip(normals.unbind(-2), bounds.unbind(-1), strict=True):
            excess = ((motion * normal).sum(-1) - bound).clamp(min=0.0)
            motion = motion - excess.unsqueeze(-1) * normal
        if self.slide_gap:
            index = nearest[..., :1]
            acts = (gaps.gather(-1, index) < self.slide_gap) & (gain.gather(-1, index) > 0)
            motion = self.held(motion, select(x_contact, index), select(x_side, index), acts.squeeze(-1))
        return motion / dt

    def gain(self, points: Tensor, normals: Tensor, x_obj: Tensor, x_target: Tensor) -> Tensor:
        """s*, the push that helps most, for each contact, ``(*B, N)``, px; negative where a push does harm."""
        scale = x_obj.new_tensor((1.0, 1.0, self.dynamics.length))
        response = self.dynamics.response(x_obj, points, normals) * scale
        error = pose_error(x_obj, x_target, self.dynamics.length).unsqueeze(-2)
        gain: Tensor = -(error * response).sum(-1) / (response * response).sum(-1)
        return gain

    @staticmethod
    def held(motion: Tensor, point: Tensor, side: Tensor, acts: Tensor) -> Tensor:
        """The motion without what would leave a side at its end, ``(*B, 2)``, px."""
        along = tangent(side)
        before, after = ((point - side[..., :2]) * along).sum(-1), ((side[..., 2:] - point) * along).sum(-1)
        inside = (before > 1e-6) & (after > 1e-6)
        slide = (motion * along).sum(-1)
        room = 0.7 * torch.where(slide > 0, after, before) + 3.0
        excess = (slide.abs() - room).clamp(min=0.0) * slide.sign()
        return motion - torch.where(acts & inside, excess, 0.0).unsqueeze(-1) * along


@dataclass(frozen=True)
class SlowApproach:
    """A speed limit: fast in the open, slow near contact, and slower near the goal.

    |a|·dt ≤ (1 − p)·60 + p·30·clip(g/30, 0.1, 1) px with p = exp(−max(gap, 0)/20).

    Attributes:
        length: L of the pose error, px.
        radius: Radius of the pusher, px.
    """

    length: float
    radius: float = RADIUS

    def __call__(
        self, a: Tensor, x_pusher: Tensor, x_contact: Tensor, x_obj: Tensor, x_target: Tensor, dt: float
    ) -> Tensor:
        """The velocity at the limit of speed or below, ``(*B, 2)``, px/s."""
        gap = norm(x_contact - x_pusher.unsqueeze(-2)).amin(-1) - self.radius
        near = torch.exp(-gap.clamp(min=0.0) / 20.0)
        cost = norm(pose_error(x_obj, x_target, self.length))
        limit = ((1 - near) * 60.0 + near * 30.0 * (cost / 30.0).clamp(0.1, 1.0)) / dt
        return a * (limit / norm(a).clamp(min=1e-9)).clamp(max=1.0).unsqueeze(-1)
