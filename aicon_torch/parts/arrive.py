"""Arriving: an end effector that slows down as it comes near its target."""

import torch
from torch import Tensor, nn

from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.validation import check_positive


class Arrive(nn.Module):
    """a ← a·min(1, t*/T): the nearest point to the target is approached exponentially.

    With the velocity v = J a of x_ee and its error e = x_ee − x_target, the way is nearest to the
    target after t* = −e·v/‖v‖². Within the time constant T the action is shortened as a whole, so
    that it does not overshoot; an action that leads away from the target is left as it is.

    Args:
        end_effector: Of the arm.
        time: T, s.

    Raises:
        OptionError: If the time is not positive.

    Example:
        >>> Actuator(7, "rad/s", limit=speeds, constraints=[Arrive(end_effector, time=0.2)])
    """

    slows_for_targets = True
    """It holds on the way to a target, and not on a detour."""

    def __init__(self, end_effector: EndEffector, time: float) -> None:
        super().__init__()
        self.end_effector, self.time = end_effector, time
        check_positive(self, ("time",))

    def forward(self, a: Tensor, x_joints: Tensor, x_ee: Tensor, x_target: Tensor) -> Tensor:
        """The action within it.

        Args:
            a: The nominal velocity, ``(*B, n)``, rad/s.
            x_joints: Joint angles, ``(*B, n)``, rad.
            x_ee: The end effector there, ``(*B, k)``, m.
            x_target: Where it is to go, ``(*B, k)``, m.

        Returns:
            ``(*B, n)``, rad/s.
        """
        # v = J a and e, each length as much as the end effector lets it count.
        jacobian = self.end_effector.jacobian(x_joints)
        velocity, error = (jacobian @ a.unsqueeze(-1)).squeeze(-1), x_ee - x_target
        weights = self.end_effector.weights(x_ee, x_target)
        if weights is not None:
            velocity, error = weights * velocity, weights * error

        # t* = −e·v/‖v‖², without a division by zero where nothing is asked for.
        approach = -(error * velocity).sum(-1, keepdim=True)
        square = (velocity * velocity).sum(-1, keepdim=True)
        nearest = approach / square.clamp(min=torch.finfo(a.dtype).tiny ** 0.5)

        # min(1, t*/T), unless the action leads away, where t* is below zero.
        share = (nearest / self.time).clamp(max=1.0)
        return a * torch.where(approach > 0, share, 1.0)
