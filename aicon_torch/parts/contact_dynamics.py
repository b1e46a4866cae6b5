"""The contact-based dynamics model: where the object goes when it is touched."""

from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from aicon_torch.parts.contact import inward_normal
from aicon_torch.parts.planar import cross
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.shaping import by_gain, straight_through

ContactEffect = Literal["quasi_static", "angle"]
"""What a contact is taken to do to the object: see :class:`ContactDynamics`."""


@dataclass(frozen=True)
class ContactDynamics:
    """x_obj moves by the likelihood-weighted combination of what each contact does to it.

    A push along the inward normal n with the lever λ = (x_contact − c) × n moves an object with
    radius of gyration r by (n, λ/r²)/(1 + (λ/r)²) for each metre, if it slides without friction at
    the contact and stops at once. As the effect Δ of a contact this direction counts at unit
    length, (n, λ/r²)/√(1 + (Lλ/r²)²), and all contacts move the object by s Σᵢ pᵢ Δᵢ. In the text Δ
    is (n, α/L), with the angle α between the normal and the line to the centre.

    Attributes:
        body: The object.
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.
        step: s, m: how far a contact that is certain moves the object.
        effect: Which of the two effects.
        intent: T, by which the gain b of a contact (that of Δ) decides softly, by σ(−b/T), whether
            it is intended; 0 decides by sign.
    """

    body: RigidObject
    rotation_length: float
    step: float
    effect: ContactEffect = "quasi_static"
    intent: float = 0.0

    def __call__(
        self, x_keypoints: Tensor, x_contact: Tensor, p_contact: Tensor, x_side: Tensor
    ) -> Tensor:
        """x_obj: the object's pose by registration, moved by the contacts to come.

        Args:
            x_keypoints: Corners of the object, ``(*B, K, 2)``, m.
            x_contact: A contact for each side, ``(*B, N, 2)``, m.
            p_contact: Their likelihoods as intended and as incidental, ``(*B, N, 2)``.
            x_side: The sides, ``(*B, N, 4)``, m.

        Returns:
            Centre and orientation (x, y, θ), ``(*B, 3)``, m and rad.
        """
        pose = self.body.registration(x_keypoints)
        effects = self.effects(pose, x_contact, inward_normal(x_side))

        # s Σᵢ pᵢ Δᵢ, where the gain of a contact decides which of its two likelihoods is pᵢ.
        intended, incidental = p_contact.unbind(-1)
        motion = self.step * by_gain(effects, intended, incidental, self.step * self.intent)

        # The contacts to come give the gradient; the pose is where it is.
        return straight_through(pose, motion)

    def effects(self, pose: Tensor, points: Tensor, normals: Tensor) -> Tensor:
        """Direction of the object's motion by each contact.

        Args:
            pose: Centre and orientation, ``(*B, 3)``, m and rad.
            points: The contacts, ``(*B, N, 2)``, m.
            normals: Unit normals into the object there, ``(*B, N, 2)``.

        Returns:
            (n, rotation by translation), ``(*B, N, 3)``, the last in rad/m.
        """
        # λ = (x_contact − c) × n, m: above zero where the push turns the object to the left.
        arm = points - pose[..., None, :2]
        lever = cross(arm, normals)
        if self.effect == "quasi_static":
            direction, turn = self._direction(lever, normals)

            # At unit length, where a turn by one rad is as long as L.
            length = torch.sqrt(1 + (self.rotation_length * turn) ** 2)
            return direction / length.unsqueeze(-1)

        # The text's angle α between the normal and the line to the centre.
        angle = torch.atan2(lever, -(arm * normals).sum(-1))
        return torch.cat((normals, angle.unsqueeze(-1) / self.rotation_length), dim=-1)

    def response(self, pose: Tensor, points: Tensor, normals: Tensor) -> Tensor:
        """(n, λ/r²)/(1 + (λ/r)²): motion of the object by each metre of a push.

        Args:
            pose: Centre and orientation, ``(*B, 3)``, m and rad.
            points: Where it is pushed, ``(*B, N, 2)``, m.
            normals: Unit vectors along which, ``(*B, N, 2)``.

        Returns:
            (x, y, θ) by m, ``(*B, N, 3)``, the last in rad/m.
        """
        lever = cross(points - pose[..., None, :2], normals)
        direction, turn = self._direction(lever, normals)

        # This direction moves the contact by 1 + λ · λ/r² along n, and a push of one metre by one.
        return direction / (1 + lever * turn).unsqueeze(-1)

    def _direction(self, lever: Tensor, normals: Tensor) -> tuple[Tensor, Tensor]:
        """(n, λ/r²), ``(*B, N, 3)``, and λ/r² alone, rad/m."""
        turn = lever / self.body.radius_of_gyration**2
        return torch.cat((normals, turn.unsqueeze(-1)), dim=-1), turn
