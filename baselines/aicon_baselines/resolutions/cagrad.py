"""CAGrad: near the mean gradient, the direction that is best for the goal it serves least."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.resolutions.aggregation import Aggregation
from aicon_torch.errors import OptionError

_SMALLEST = 1e-4
"""Length of g_w, beside the longest gradient, below which its direction means less and less."""


@dataclass(frozen=True)
class CAGrad(Aggregation):
    """n argmax over x of minᵢ gᵢ·x, subject to ‖x − g₀‖ ≤ c ‖g₀‖, with the mean g₀ = Σᵢ gᵢ/n.

    That is n (g₀ + c ‖g₀‖ g_w/‖g_w‖), where g_w = Σᵢ wᵢ gᵢ and the weights w ≥ 0, Σᵢ wᵢ = 1
    minimise g_w·g₀ + c ‖g₀‖ ‖g_w‖. Where g_w vanishes, n g₀ is left, as in the authors' code. The
    text has no factor n.

    TorchJD's CAGrad solves the same program, with two differences. It writes it with CVXPY, which
    takes 60 times as long and would make an episode take hours; here Clarabel, the solver
    underneath, gets it directly. And where g_w vanishes it gives 0, so that one goal without a
    gradient, such as a far obstacle's, would stop the robot.

    Source: Liu et al., Conflict-Averse Gradient Descent for Multi-task Learning, NeurIPS 2021,
    Algorithm 1.

    Attributes:
        c: Radius of the ball around g₀ in which x may lie, over ‖g₀‖. The text takes 0.2 to 0.8.
    """

    c: float = 0.5
    modules: ClassVar[tuple[str, ...]] = ("clarabel",)

    def __post_init__(self) -> None:
        """Check the radius, and that the solver is there."""
        super().__post_init__()
        if not 0.0 <= self.c < 1.0:
            raise OptionError(f"c={self.c!r}: expected a number in [0, 1).")

    def aggregate(self, matrix: Tensor) -> Tensor:
        """The conflict-averse gradient, ``(d,)``."""
        gradients = matrix.numpy(force=True).astype(np.float64)
        mean = gradients.mean(0)
        radius = self.c * float(np.linalg.norm(mean))

        # 1. What serves the goals that g₀ serves least.
        weighted = _minimal_weights(gradients, mean, radius) @ gradients
        length = max(float(np.linalg.norm(weighted)), _SMALLEST)

        # 2. As far that way as the ball allows.
        total = len(gradients) * (mean + radius / length * weighted)
        return torch.as_tensor(total, dtype=matrix.dtype, device=matrix.device)


def _minimal_weights(
    gradients: NDArray[np.float64], mean: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Weights w ``(n,)`` that minimise (Jᵀw)·g₀ + r ‖Jᵀw‖ for the gradients J ``(n, d)``."""
    import clarabel
    from scipy import sparse

    # The variables are w and t, the objective is linear in them: t stands for ‖Jᵀw‖.
    count, size = gradients.shape
    objective = np.append(gradients @ mean, radius)
    nothing_quadratic = sparse.csc_matrix((count + 1, count + 1))

    # b − A(w, t) lies in cones: Σᵢ wᵢ = 1, then w ≥ 0, then ‖Jᵀw‖ ≤ t.
    constraints = np.zeros((1 + count + 1 + size, count + 1))
    constraints[0, :count] = 1.0
    constraints[1 : 1 + count, :count] = -np.eye(count)
    constraints[1 + count, count] = -1.0
    constraints[2 + count :, :count] = -gradients.T
    bounds = np.zeros(len(constraints))
    bounds[0] = 1.0

    cones = [
        clarabel.ZeroConeT(1),
        clarabel.NonnegativeConeT(count),
        clarabel.SecondOrderConeT(1 + size),
    ]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    matrix = sparse.csc_matrix(constraints)
    solver = clarabel.DefaultSolver(nothing_quadratic, objective, matrix, bounds, cones, settings)
    return np.asarray(solver.solve().x[:count], np.float64)
