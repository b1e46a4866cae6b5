"""Joint limits as a goal."""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from aicon_torch.errors import OptionError
from aicon_torch.parts.hinge import Margin, SquaredHinge


class JointLimits(Margin, nn.Module):
    """g = w Σᵢ max(0, 1 − mᵢ/m₀)², where mᵢ is the distance of joint i to its nearer limit.

    The paper's g₃ = p_limit(x_joints).

    Args:
        low: Lower limits of the n joints, rad, or m where they slide; −∞ for none.
        high: Upper limits, likewise.
        cost: Margin m₀ (rad), farther than which from its limits a joint is free, and weight w.

    Raises:
        OptionError: If there is not an upper limit above each lower one.

    Example:
        >>> cost = SquaredHinge(margin=0.1, weight=0.5)
        >>> Goal("joint_limits", JointLimits(low=(-2.9, -1.8), high=(2.9, 1.8), cost=cost))
        >>> stops = JointLimits(chain.low, chain.high, SquaredHinge(0.02, 1.0))
        >>> Goal("joint_stops", stops, safety=True)  # no joint comes nearer than 0.02 rad
    """

    low: Tensor
    high: Tensor

    def __init__(
        self, low: Sequence[float] | Tensor, high: Sequence[float] | Tensor, cost: SquaredHinge
    ) -> None:
        super().__init__()
        has_room = [below < above for below, above in zip(low, high, strict=False)]
        if len(low) != len(high) or not all(has_room):
            raise OptionError(
                f"low={tuple(low)!r}, high={tuple(high)!r}: expected a limit of each joint, the "
                "lower one below the upper one."
            )
        self.cost = cost
        self.register_buffer("low", torch.as_tensor(low, dtype=torch.float64).clone())
        self.register_buffer("high", torch.as_tensor(high, dtype=torch.float64).clone())

    def forward(self, x_joints: Tensor) -> Tensor:
        """The cost ``(*B,)`` of the joint angles ``(*B, n)``, rad."""
        return self.cost(self.distances(x_joints))

    def gaps(self, *values: Tensor) -> Tensor:
        """How far each joint is from where each of its limits costs something, ``(*B, 2 n)``, rad.

        A step may be longer than half of a short range, so that both limits count.
        """
        return torch.cat(self.room(*values), dim=-1)

    def room(self, x_joints: Tensor) -> tuple[Tensor, Tensor]:
        """How far each joint may turn down and up until that costs something, ``(*B, n)``, rad."""
        to_low, to_high = self._to_limits(x_joints)
        return to_low - self.cost.margin, to_high - self.cost.margin

    def distances(self, x_joints: Tensor) -> Tensor:
        """mᵢ: the distance of each joint to its nearer limit, ``(*B, n)``, rad."""
        return torch.minimum(*self._to_limits(x_joints))

    def _to_limits(self, x_joints: Tensor) -> tuple[Tensor, Tensor]:
        """The distances to the lower and to the upper limit, ``(*B, n)``, rad."""
        return x_joints - self.low.to(x_joints), self.high.to(x_joints) - x_joints
