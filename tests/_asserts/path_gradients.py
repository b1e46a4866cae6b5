"""The gradient along one path, in two independent ways."""

from collections.abc import Iterator
from itertools import pairwise

import torch
from torch import Tensor

from aicon_torch import WorldModel
from aicon_torch.graph import LocalGraphs, Path


def along(path: Path, model: WorldModel, local: LocalGraphs) -> Tensor:
    """The gradient along one complete path (Eq. 1).

    One factor after the other, each a product with a Jacobian.
    """
    gradient = torch.ones_like(local[path.goal].output)

    for output, leaf, row in _factors(path, model, local):
        (gradient,) = torch.autograd.grad(output, leaf, gradient, retain_graph=True)
        gradient = gradient if row is None else gradient[..., row, :]

    return gradient


def through_jacobians(path: Path, model: WorldModel, local: LocalGraphs) -> Tensor:
    """The same without batch dimensions, with every factor of the chain rule as a full matrix."""
    gradient = torch.ones(1, 1, dtype=torch.float64)

    for output, leaf, row in _factors(path, model, local):
        jacobian = [_slope(component, leaf, row) for component in output.flatten()]
        gradient = gradient @ torch.stack(jacobian)

    return gradient.squeeze(0)


def sums_over_paths(model: WorldModel, local: LocalGraphs) -> dict[str, Tensor]:
    """For each actuator the sum of the gradients along all paths that end there."""
    sums: dict[str, Tensor] = {}

    for path in model.paths():
        gradient = along(path, model, local)
        sums[path.actuator] = sums.get(path.actuator, torch.zeros_like(gradient)) + gradient

    return sums


def _factors(
    path: Path, model: WorldModel, local: LocalGraphs
) -> Iterator[tuple[Tensor, Tensor, int | None]]:
    """For each edge of a path the output of its local graph, the leaf, and the row that it stands
    for.
    """
    for label, further in pairwise((path.goal, *path.quantities, path.actuator)):
        target, row = _quantity_and_row(label)
        source, _ = _quantity_and_row(further)

        sources = [edge.source for edge in model.edges[target]]
        yield local[target].output, local[target].leaves[sources.index(source)], row


def _quantity_and_row(label: str) -> tuple[str, int | None]:
    """``x_contact[3]`` is ``("x_contact", 3)``, and ``x_pusher`` is ``("x_pusher", None)``."""
    name, _, row = label.rstrip("]").partition("[")
    return name, int(row) if row else None


def _slope(component: Tensor, leaf: Tensor, row: int | None) -> Tensor:
    """One row of a Jacobian, by one row of the leaf's copies."""
    (slope,) = torch.autograd.grad(component, leaf, retain_graph=True, allow_unused=True)
    slope = torch.zeros_like(leaf) if slope is None else slope

    return (slope if row is None else slope[row]).flatten()
