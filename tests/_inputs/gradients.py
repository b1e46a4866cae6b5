"""Stacks of gradients, and what a resolution sees beside them."""

import math
from collections.abc import Callable, Mapping, Sequence

import torch
from torch import Tensor

from _inputs.random_numbers import BATCHES, normal
from aicon_torch import Resolution
from aicon_torch.resolution import GradientStack

Memory = dict[str, Tensor]


# --- a table of stacks


def _random_stacks() -> dict[str, Tensor]:
    """A stack of n gradients in d dimensions for each n and d; the batch shapes take turns."""
    sizes = [(n, d) for n in range(1, 6) for d in range(1, 5)]
    stacks: dict[str, Tensor] = {}

    for seed, (n, d) in enumerate(sizes):
        batch = BATCHES[seed % len(BATCHES)]
        stacks[f"{n} in {d}D, batch {batch}"] = normal(*batch, n, d, seed=seed)

    return stacks


def _stack(*gradients: Sequence[float]) -> Tensor:
    return torch.tensor(gradients, dtype=torch.float64)


_PLAIN = normal(3, 4, 3, seed=99)

DEGENERATE: dict[str, Tensor] = {
    "all zero": torch.zeros(2, 3, 2, dtype=torch.float64),
    "one zero": _stack([0.0, 0.0], [1.0, 2.0], [-1.0, 0.5]),
    "all but one zero": _stack([0.0, 0.0], [0.0, 0.0], [0.3, -1.0]),
    "duplicates": _stack([1.0, 2.0, 0.0], [1.0, 2.0, 0.0], [0.0, 1.0, 1.0]),
    "nearly duplicates": _stack([1.0, 2.0, 0.0], [1.0, 2.0, 1e-9], [0.0, 1.0, 1.0]),
    "opposed": _stack([1.0, -1.0], [-1.0, 1.0], [0.2, 0.1]),
    "parallel to an axis": _stack([0.0, 1.0], [0.0, -0.7]),
    "equally long": _stack([1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]),
    "small": 1e-6 * _PLAIN,
    "tiny": 1e-30 * _PLAIN,
    "one tiny": _stack([1e-30, 3e-30], [1.0, 2.0], [-1.0, 0.5]),
    "large": 1e6 * _PLAIN,
    "huge": 1e15 * _PLAIN,
    "one huge": _stack([1e15, 3e15], [1.0, 2.0], [-1.0, 0.5]),
}
RANDOM = _random_stacks()
STACKS = RANDOM | DEGENERATE


# --- what a resolution is called with


def gradient_stack(
    gradients: Tensor,
    *,
    motion: Tensor | None = None,
    goals: Sequence[str] | None = None,
    costs: Mapping[str, Tensor] | None = None,
    displaced_cost: Callable[[str, Tensor], Tensor] | None = None,
    dt: float = 0.05,
    is_last: bool = True,
) -> GradientStack:
    """Gradients ``(*B, n, d)`` at a quantity at rest, of goals ``g0``, ``g1``, ….

    ``g0+g1`` is merged.
    """
    names = goals or [f"g{i}" for i in range(gradients.shape[-2])]
    zero = gradients.new_zeros(gradients.shape[:-2])
    at_rest = torch.zeros_like(gradients[..., 0, :])

    return GradientStack(
        gradients=gradients,
        goals=tuple(frozenset(name.split("+")) for name in names),
        motion=at_rest if motion is None else motion,
        costs=dict.fromkeys(names, zero) if costs is None else dict(costs),
        displaced_cost=displaced_cost or (lambda goal, shift: zero),
        dt=dt,
        is_last=is_last,
    )


def fresh(rule: Resolution, gradients: Tensor) -> Memory:
    """What a resolution remembers before its first step, for a stack ``(*B, n, d)``."""
    *batch, count, size = gradients.shape
    memory: Memory = {}

    for key, value in rule.initial(count, size).items():
        dtype = gradients.dtype if value.is_floating_point() else value.dtype
        memory[key] = value.to(dtype).expand((*batch, *value.shape))

    return memory


def exploring_memory(gradients: Tensor, rule: Resolution, **known: Tensor) -> Memory:
    """The same while a conflict lasts."""
    exploring = torch.ones(gradients.shape[:-2], dtype=torch.bool)
    return fresh(rule, gradients) | {"exploring": exploring} | known


# --- conflicts


def lengths(vectors: Tensor) -> Tensor:
    """‖v‖ of vectors ``(*B, d)``."""
    return torch.linalg.vector_norm(vectors, dim=-1)


def direction(vector: Tensor) -> Tensor:
    """The vectors ``(*B, d)`` at length one."""
    return vector / lengths(vector).unsqueeze(-1)


def pair(cosine: float, ratio: float = 1.5, dtype: torch.dtype = torch.float64) -> Tensor:
    """Two gradients in the plane with a given cosine, the first longer by a given ratio."""
    return _stack([ratio, 0.0], [cosine, math.sqrt(1.0 - cosine**2)]).to(dtype)


def conflict(
    *batch: int, size: int = 3, seed: int = 0, dtype: torch.dtype = torch.float64
) -> Tensor:
    """Two gradients that oppose each other, up to a little, and a weak third one."""
    first, noise, third = normal(3, *batch, size, seed=seed, dtype=dtype)
    across = lengths(first).unsqueeze(-1) * direction(noise)

    second = -0.8 * first + 0.2 * across
    return torch.stack((first, second, 0.05 * third), dim=-2)


THREE = _stack([1.0, 0.0], [0.3, 0.9], [-0.8, 0.1])
"""The second strongest is nearly at right angles to the first; the third opposes it."""

SCENARIOS = [
    # exploring before, cosine, ratio → exploring after
    (False, -0.59, 1.5, False),
    (False, -0.61, 1.5, True),
    (False, -1.0, 1.0, True),
    (False, -0.61, 2.99, True),
    (False, -0.61, 3.01, False),
    (False, -1.0, 10.0, False),
    (False, -0.5, 1.5, False),
    (False, 0.0, 1.5, False),
    (False, 0.9, 1.5, False),
    (True, -0.61, 1.5, True),
    (True, -0.5, 1.5, True),
    (True, -0.41, 1.5, True),
    (True, -0.39, 1.5, False),
    (True, 0.9, 1.5, False),
    (True, -0.5, 2.99, True),
    (True, -0.5, 3.01, False),
    (True, -1.0, 3.01, False),
]
"""When a conflict of two begins and ends, with the paper's thresholds."""
