"""Limits of the pusher's motion near the object. They are ours: the text has none.

They are reactive: each is a bound on the next displacement that follows from where the pusher, the
object and the target are now. They belong to the actuator and know the target, like the goal; a
goal that is switched off leaves them.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.contact import END_TOLERANCE, tangent
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.vectors import select

SLIDE_SHARE = 0.7
"""Share of what is left of a side that the pusher may slide along it in one step."""


@dataclass(frozen=True)
class ContactLimits:
    """No contact is pushed farther than it helps, and the pusher stays on the side that it pushes.

    One pass over the nearest sides takes away from the displacement d what goes beyond, nearest
    first; where sides form a notch a later one may push it back a little. Toward each side: d·n ≤
    max(gap, 0) + s, where n points from the pusher to the side. A push by s moves the object by
    s·J, so s* = −E·J/|J|² brings the error E nearest to zero along it (a Gauss-Newton step on g =
    |E|). Where s* > 0 it is the bound, within [s_min, s_max]; elsewhere the pusher may not push
    farther than s_bad.

    Along the nearest side, if it is of use: |d·t| ≤ 0.7 (distance to the side's end) + s_end, so
    that the pusher comes to the end in several steps and leaves it in small ones.

    Attributes:
        dynamics: What a push does.
        radius: Radius of the pusher, m.
        push: s_min and s_max, m.
        harm: s_bad, m.
        slide_gap: Gap to the nearest side below which the second limit acts, m; 0 switches it off.
        end_step: s_end, m.
        nearest_sides: Number of sides that are considered, the nearest ones.
    """

    dynamics: ContactDynamics
    radius: float
    push: tuple[float, float]
    harm: float
    slide_gap: float
    end_step: float
    nearest_sides: int = 4

    def __call__(
        self,
        a: Tensor,
        x_pusher: Tensor,
        x_contact: Tensor,
        x_side: Tensor,
        x_obj: Tensor,
        x_target: Tensor,
        dt: float,
    ) -> Tensor:
        """The velocity within the limits.

        Args:
            a: The velocity that is wished for, ``(*B, 2)``, m/s.
            x_pusher: Centre of the pusher, ``(*B, 2)``, m.
            x_contact: The closest point of each side, ``(*B, N, 2)``, m.
            x_side: The sides, ``(*B, N, 4)``, m.
            x_obj: The object's pose, ``(*B, 3)``, m and rad.
            x_target: Its target, likewise.
            dt: Duration of the step, s.

        Returns:
            ``(*B, 2)``, m/s.
        """
        # From the pusher to each side, and the push that helps most there.
        to_contact = x_contact - x_pusher.unsqueeze(-2)
        distances = norm(to_contact)
        normals, gaps = to_contact / distances.unsqueeze(-1), distances - self.radius
        helpful = self.helpful_push(x_contact, normals, x_obj, x_target)

        # The bounds towards the nearest sides.
        count = min(self.nearest_sides, gaps.shape[-1])
        nearest = gaps.topk(count, largest=False).indices
        bounds = self._push_bounds(gaps, helpful).gather(-1, nearest)
        near_normals = normals.gather(-2, nearest.unsqueeze(-1).expand(*nearest.shape, 2))

        # The displacement within them.
        motion = _within(a * dt, near_normals, bounds)
        if self.slide_gap:
            side = nearest[..., :1]
            useful = (gaps.gather(-1, side) < self.slide_gap) & (helpful.gather(-1, side) > 0)
            on_side = self._kept_on_side(motion, select(x_contact, side), select(x_side, side))
            motion = torch.where(useful, on_side, motion)
        return motion / dt

    def helpful_push(
        self, points: Tensor, normals: Tensor, x_obj: Tensor, x_target: Tensor
    ) -> Tensor:
        """s* = −E·J/|J|²: the push that brings the object nearest to its target, for each contact.

        Args:
            points: The contacts, ``(*B, N, 2)``, m.
            normals: Unit vectors along which they are pushed, ``(*B, N, 2)``.
            x_obj: The object's pose, ``(*B, 3)``, m and rad.
            x_target: Its target, likewise.

        Returns:
            ``(*B, N)``, m; negative where a push does harm.
        """
        rotation_length = self.dynamics.rotation_length
        scale = x_obj.new_tensor((1.0, 1.0, rotation_length))
        response = self.dynamics.response(x_obj, points, normals) * scale

        error = pose_error(x_obj, x_target, rotation_length).unsqueeze(-2)
        helpful: Tensor = -(error * response).sum(-1) / (response * response).sum(-1)
        return helpful

    def _push_bounds(self, gaps: Tensor, helpful: Tensor) -> Tensor:
        """The largest displacement towards each side, ``(*B, N)``, m."""
        allowed = torch.where(helpful > 0, helpful.clamp(*self.push), self.harm)
        return gaps.clamp(min=0.0) + allowed

    def _kept_on_side(self, motion: Tensor, point: Tensor, side: Tensor) -> Tensor:
        """The motion ``(*B, 2)`` without what would leave a side ``(*B, 4)`` at its end, m."""
        along = tangent(side)
        from_start = ((point - side[..., :2]) * along).sum(-1)
        to_end = ((side[..., 2:] - point) * along).sum(-1)
        interior = (from_start > END_TOLERANCE) & (to_end > END_TOLERANCE)

        slide = (motion * along).sum(-1)
        left = torch.where(slide > 0, to_end, from_start)
        room = SLIDE_SHARE * left + self.end_step
        excess = (slide.abs() - room).clamp(min=0.0) * slide.sign()
        return motion - torch.where(interior, excess, 0.0).unsqueeze(-1) * along


def _within(motion: Tensor, normals: Tensor, bounds: Tensor) -> Tensor:
    """The displacement ``(*B, 2)`` less what exceeds bounds ``(*B, N)`` along normals, in turn."""
    for normal, bound in zip(normals.unbind(-2), bounds.unbind(-1), strict=True):
        excess = ((motion * normal).sum(-1) - bound).clamp(min=0.0)
        motion = motion - excess.unsqueeze(-1) * normal
    return motion
