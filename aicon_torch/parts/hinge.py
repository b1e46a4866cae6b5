"""The cost of coming too near: nothing beyond a margin, growing with the square within it."""

from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor

from aicon_torch.validation import check_not_negative, check_positive


class Margin:
    """A cost of distances: as a safety goal, what is left of each beyond the margin is its gap."""

    cost: "SquaredHinge"
    distances: Callable[..., Tensor]

    def gaps(self, *values: Tensor) -> Tensor:
        """How far each distance is from where it costs something, dᵢ − d₀, ``(*B, n)``."""
        return self.distances(*values) - self.cost.margin


@dataclass(frozen=True)
class SquaredHinge:
    """g = w Σᵢ max(0, 1 − dᵢ/d₀)² for distances dᵢ: 0 beyond the margin, w where nothing is left.

    Attributes:
        margin: d₀, in the unit of the distances.
        weight: w, in the unit of the cost.

    Raises:
        OptionError: If the margin is not positive, or the weight is negative.

    Example:
        >>> SquaredHinge(margin=0.1, weight=0.5)(torch.tensor([0.2, 0.05]))
        tensor(0.1250)
    """

    margin: float
    weight: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("margin",))
        check_not_negative(self, ("weight",))

    def __call__(self, distances: Tensor) -> Tensor:
        """The cost ``(*B,)`` of distances ``(*B, n)``, negative where a limit is exceeded."""
        nearness = (1 - distances / self.margin).clamp(min=0.0)
        return self.weight * (nearness * nearness).sum(-1)
