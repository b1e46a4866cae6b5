"""The contact-based dynamics model: where the object goes when it is touched."""

from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from aicon_torch.parts.contact import inward, norm
from aicon_torch.parts.rigid_object import Outline
from aicon_torch.shaping import by_gain, straight_through


@dataclass(frozen=True)
class ContactDynamics:
    """x_obj moves by the likelihood-weighted combination of what each contact does to it.

    A push along the inward normal n at a lever λ = (x_contact − c) × n moves an object with radius of gyration r by
    (n, λ/r²)/(1 + (λ/r)²) for each px, if it slides without friction at the contact and stops at once. As the effect of
    a contact this direction counts at unit length, (n, λ/r²)/√(1 + (Lλ/r²)²). In the text it is (n, α/L), with the
    angle α between the normal and the line to the centre; ``"sine"`` has sin α for α.

    Attributes:
        outline: The object.
        length: L, px: a rotation of one rad counts as much as a translation by L.
        effect: Which of them.
        intent: T, by which the gain b of a contact decides softly, by σ(−b/T), whether it is sought; 0 decides by sign.
    """

    outline: Outline
    length: float
    effect: Literal["quasi_static", "sine", "angle"] = "quasi_static"
    intent: float = 0.0

    def __call__(self, x_keypoints: Tensor, x_contact: Tensor, p_contact: Tensor, x_side: Tensor) -> Tensor:
        """x_obj ``(*B, 3)``: centre (px) and orientation (rad) by registration, moved by the contacts to come."""
        pose = self.outline.pose(x_keypoints)
        effects = self.effects(pose, x_contact, inward(x_side))
        motion = by_gain(effects, p_contact[..., 0], p_contact[..., 1], self.intent)
        return straight_through(pose, motion)  # the contacts to come give the gradient; the pose is where it is

    def effects(self, pose: Tensor, points: Tensor, normals: Tensor) -> Tensor:
        """Direction of the object's motion by each contact ``(*B, N, 2)``, ``(*B, N, 3)``."""
        arm = points - pose[..., None, :2]
        lever = cross(arm, normals)
        if self.effect != "quasi_static":
            angle = torch.atan2(lever, -(arm * normals).sum(-1)) if self.effect == "angle" else lever / norm(arm)
            return torch.cat((normals, angle.unsqueeze(-1) / self.length), dim=-1)
        turn = lever / self.outline.gyration**2
        effects = torch.cat((normals, turn.unsqueeze(-1)), dim=-1)
        return effects / torch.sqrt(1 + (self.length * turn) ** 2).unsqueeze(-1)

    def response(self, pose: Tensor, points: Tensor, normals: Tensor) -> Tensor:
        """Motion (x, y, θ) of the object by each px of a push, ``(*B, N, 3)``."""
        lever = cross(points - pose[..., None, :2], normals)
        turn = lever / self.outline.gyration**2
        return torch.cat((normals, turn.unsqueeze(-1)), dim=-1) / (1 + lever * turn).unsqueeze(-1)


def cross(first: Tensor, second: Tensor) -> Tensor:
    """The planar cross product ``(*B,)`` of vectors ``(*B, 2)``."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
