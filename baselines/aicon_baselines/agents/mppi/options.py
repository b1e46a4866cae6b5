"""Options of model-predictive path integral control, and those that were found by tuning."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from aicon_torch.errors import OptionError
from aicon_torch.models.pusht import PIXEL
from aicon_torch.validation import check_not_negative, check_positive


@dataclass(frozen=True)
class Options:
    """Options of the planner.

    Attributes:
        samples: K, number of velocity sequences that are drawn in a step.
        horizon: H, their length, steps.
        temperature: λ, m: a sequence that costs λ more than the best weighs 1/e of it.
        noise: σ, standard deviation of each coordinate of a velocity, m/s.
        gap_weight: What a metre between pusher and object costs, in metres of pose error.
    """

    samples: int = 256
    horizon: int = 15
    temperature: float = 1e-4
    noise: float = 150.0 * PIXEL
    gap_weight: float = 0.1

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            OptionError: If one is not what it may be.
        """
        for name in ("samples", "horizon"):
            value = getattr(self, name)
            if not (type(value) is int and value >= 1):
                raise OptionError(f"{name}={value!r}: expected a whole number >= 1.")

        check_positive(self, ("temperature", "noise"))
        check_not_negative(self, ("gap_weight",))


PRESETS: Mapping[str, Options] = MappingProxyType(
    {
        "mppi": Options(),
        "mppi_small": Options(samples=32, horizon=10),
    }
)
"""The planner as it was tuned: within the control period of 0.1 s on a core, and in 2 ms or so."""
