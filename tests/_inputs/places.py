"""A cost and a gap of two components, for what looks for places at which they are kept."""

import torch
from torch import Tensor

DT = 0.02
LIMITS = torch.full((2,), 1.5, dtype=torch.float64)
RANGE = (torch.tensor([2.0, 2.0]).double(), torch.tensor([2.0, 2.0]).double())


class Distance:
    """G = ‖x − target‖ from x = 0; within a radius of a place, a metre, a gap is closed."""

    def __init__(self, target: Tensor, closed: Tensor | None = None, radius: float = 1.0) -> None:
        self.target, self.closed, self.radius = target, closed, radius
        self.at_rest = target.norm()

    def steepness(self, limits: Tensor) -> Tensor:
        return torch.tensor(1.0).double()

    def slope(self, action: Tensor) -> tuple[Tensor, Tensor]:
        offset = DT * action - self.target
        distance = offset.norm(dim=-1)
        return distance, DT * offset / distance.clamp(min=1e-9).unsqueeze(-1)

    def of_safety(self, action: Tensor) -> Tensor:
        if self.closed is None:
            return torch.zeros_like(action[..., 0])
        distance = torch.linalg.vector_norm(DT * action - self.closed, dim=-1)
        closed: Tensor = (self.radius - distance).clamp(min=0.0)
        return closed


def doubled(memory: dict[str, Tensor]) -> dict[str, Tensor]:
    """A memory in double precision."""
    return {k: v.double() if v.is_floating_point() else v for k, v in memory.items()}
