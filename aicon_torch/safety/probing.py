"""What a safety goal is like, as a few random values of its model tell when that is built."""

import warnings
from collections.abc import Sequence

import torch
from torch import Tensor

from aicon_torch.differentiation import hop_from, pull
from aicon_torch.errors import GraphError
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.quantities import AGE, PRESENT

PROBES = 4
"""So many random values of every reading."""

ROUNDING = 64
"""So many units in the last place of the largest component of a slope are but rounding."""

COASTS, SMALL = 0.1, 1e-6
"""The share of a change that comes after its action where that is no velocity, and what is none."""

Values = dict[str, Tensor]


def probe_values(model: WorldModel) -> Values:
    """Values of a model after random readings in [0, 1], the same at every run, ``(4, …)``."""
    generator, like = torch.Generator("cpu").manual_seed(0), model.like
    readings: Values = {}
    for name, sensor in model.sensors.items():
        size = (PROBES, sensor.size)
        reading = torch.rand(size, generator=generator, dtype=torch.float64, device="cpu")
        readings[name] = reading.to(like)
        readings[name + PRESENT] = like.new_ones(PROBES, dtype=torch.bool)
        readings[name + AGE] = like.new_zeros(PROBES)
    return model.update(model.initial(readings, (PROBES,)))


def check_gaps(goal: Goal, gaps: Tensor, slopes: Tensor) -> None:
    """Check that a goal can bound actions.

    Args:
        goal: The goal.
        gaps: Its gaps at some values, ``(4, m)``.
        slopes: How they grow with the action there, ``(4, m, n)``.

    Raises:
        GraphError: If it has no gaps, or lets none of them bound an action.
    """
    if gaps.shape[-1] == 0 or goal.most_gaps < 1:
        raise GraphError(
            f"Safety goal {goal.name!r}: it has {gaps.shape[-1]} gaps, of which the "
            f"{goal.most_gaps} smallest (most_gaps) bound an action; expected one at least, or "
            "nothing is kept."
        )

    # Where a cost is none, it says nothing of what is near.
    knows_gaps = hasattr(goal.cost.function, "gaps")
    is_flat = (gaps[..., 0] == goal.tolerance) & (slopes == 0).all((-1, -2))
    if not knows_gaps and is_flat.any():
        warnings.warn(
            f"Safety goal {goal.name!r}: its cost is 0 where nothing is violated, so it bounds no "
            "action until something is. Let it be below 0 there, as 0.3 - distance is, without "
            "clamp(min=0), or give it a method gaps.",
            stacklevel=2,
        )


def read_by_gaps(goal: Goal, values: Values) -> set[str]:
    """What the gaps of a goal depend on, of what its cost reads.

    Args:
        goal: The goal.
        values: Some values, ``(4, …)``.
    """
    leaves = {name: hop_from(values[name]).requires_grad_() for name in goal.inputs}
    with torch.enable_grad():
        gaps = goal.gaps({**values, **leaves})
    slopes: Sequence[Tensor | None] = [None] * len(leaves)
    if gaps.requires_grad:
        slopes = pull(gaps.sum(), list(leaves.values()), allow_unused=True)

    # A gradient may be stopped where the value counts.
    read = {name for name, slope in zip(leaves, slopes, strict=True) if slope is not None}
    for name in goal.inputs:
        elsewhere = goal.gaps({**values, name: values[name] + 1.0})
        if not torch.allclose(elsewhere, gaps, rtol=0.0, atol=0.0, equal_nan=True):
            read.add(name)
    return read


def is_going_on(by_action: Tensor, afterwards: Tensor) -> bool:
    """Whether gaps go on changing after an action, as they do by a share of it at least.

    Args:
        by_action: How they change in the step of the action, ``(4, m)``.
        afterwards: And in the next one, at rest; what is read again goes back, and not on.
    """
    goes_on = by_action * afterwards >= 0.0
    return bool((goes_on & (afterwards.abs() > SMALL + COASTS * by_action.abs())).any())


def is_box(slopes: Tensor) -> bool:
    """Whether each gap depends on one component of the action at most, as joint stops do.

    Then the components can be bounded one by one, which no sweep needs to approach. A joint without
    a stop has a gap that depends on none.

    Args:
        slopes: How the gaps grow with the action at some values, ``(4, m, n)``.
    """
    components = (without_rounding(slopes) != 0).sum(-1)
    return bool((components <= 1).all() and (components == 1).any())


def without_rounding(slopes: Tensor) -> Tensor:
    """Slopes ``(*B, m, n)`` with zeros where a component is but the rounding of another."""
    smallest = ROUNDING * torch.finfo(slopes.dtype).eps * slopes.abs().amax(-1, keepdim=True)
    return torch.where(slopes.abs() > smallest, slopes, 0.0)
