"""PCGrad and UPGrad, computed by the aggregators of TorchJD."""

from dataclasses import dataclass
from typing import Any, ClassVar

import torch
from torch import Tensor

from aicon_baselines.resolutions.aggregation import Aggregation


@dataclass(frozen=True)
class PCGrad(Aggregation):
    """Σᵢ gᵢ', where each gᵢ' is gᵢ without its components against the others.

    For each other gⱼ in turn, gᵢ' ← gᵢ' − min(0, gᵢ'·gⱼ)/‖gⱼ‖² gⱼ. The turns are drawn at random,
    here from the same seed at every step, so that a gradient has one resolution.

    Source: Yu et al., Gradient Surgery for Multi-Task Learning, NeurIPS 2020, Algorithm 1.
    """

    modules: ClassVar[tuple[str, ...]] = ("torchjd",)

    def aggregate(self, matrix: Tensor) -> Tensor:
        """The sum of the projected gradients, ``(d,)``."""
        # TorchJD draws from torch's global random numbers, which are others' as well.
        with torch.random.fork_rng(devices=()):
            torch.default_generator.manual_seed(0)
            total: Tensor = _aggregator("PCGrad")(matrix)
        return total


@dataclass(frozen=True)
class UPGrad(Aggregation):
    """Σᵢ π(gᵢ), where π projects onto the dual cone {x : gⱼ·x ≥ 0 for all j}.

    No step along the result, if it is small, makes any of the goals worse.

    Source: Quinton and Rey, Jacobian Descent for Multi-Objective Optimization, 2024, Eq. 3-4. The
    text has the mean, which is this over n.
    """

    modules: ClassVar[tuple[str, ...]] = ("torchjd", "quadprog", "qpsolvers")

    def aggregate(self, matrix: Tensor) -> Tensor:
        """The sum of the projected gradients, ``(d,)``."""
        weights = torch.ones(len(matrix), dtype=torch.float64)
        total: Tensor = _aggregator("UPGrad", pref_vector=weights)(matrix)
        return total


def _aggregator(name: str, **options: Any) -> Any:
    """An aggregator of TorchJD, imported on demand."""
    from torchjd import aggregation

    return getattr(aggregation, name)(**options)
