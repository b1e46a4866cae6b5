"""Smooth functions of named quantities, different for every seed."""

import inspect
from collections.abc import Mapping

import torch
from torch import Tensor

from _inputs.random_numbers import normal


class Smooth:
    """tanh(b + Σ W x) + Σ V x over named quantities.

    Smooth, nonlinear, and different for every seed.

    Around a quantity it is that quantity plus a fifth of this, so that a filter that predicts with
    it stays stable.
    """

    def __init__(
        self, reads: Mapping[str, tuple[int, ...]], rows: int, seed: int, around: str | None = None
    ) -> None:
        self.shapes = tuple(reads.values())
        self.position = None if around is None else list(reads).index(around)

        sizes = [torch.Size(shape).numel() for shape in self.shapes]
        self.bias = normal(rows, seed=seed)
        self.inner = [normal(rows, size, seed=7 * seed + i) / size for i, size in enumerate(sizes)]
        self.outer = [
            normal(rows, size, seed=11 * seed + i + 1) / size for i, size in enumerate(sizes)
        ]

        # The names of the parameters are the wiring, as for a function that is written down.
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        self.__signature__ = inspect.Signature([inspect.Parameter(name, kind) for name in reads])

    def __call__(self, *inputs: Tensor) -> Tensor:
        bent, straight = self.bias, torch.zeros_like(self.bias)
        for x, shape, inner, outer in zip(inputs, self.shapes, self.inner, self.outer, strict=True):
            flat = x.flatten(-len(shape)).unsqueeze(-2)
            bent = bent + (inner * flat).sum(-1)
            straight = straight + (outer * flat).sum(-1)

        value: Tensor = torch.tanh(bent) + 0.3 * straight
        return value if self.position is None else inputs[self.position] + 0.2 * value


class Anchors(Smooth):
    """Rows ``(*B, N, n)`` that the reading places."""

    def __init__(self, rows: int, size: int, seed: int) -> None:
        super().__init__({"z": (2,)}, rows * size, seed)
        self.rows = rows

    def __call__(self, *inputs: Tensor) -> Tensor:
        return super().__call__(*inputs).unflatten(-1, (self.rows, -1))


class Cost(Smooth):
    """Half the squared length of a smooth function: a scalar cost."""

    def __call__(self, *inputs: Tensor) -> Tensor:
        return 0.5 * (super().__call__(*inputs) ** 2).sum(-1)
