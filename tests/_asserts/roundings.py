"""What roundings may change in a step: a bound from the step itself, not from one machine."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch import Policy

ROUNDINGS = 1000
"""How many roundings, one after the other, a step makes at most."""

DRAWS = 8
"""How often the inputs of a step are moved to see what that changes."""


def assert_equal_but_for_roundings(
    policy: Policy,
    observation: Mapping[str, Tensor],
    memory: Mapping[str, Tensor] | None,
    found: Mapping[str, Tensor],
) -> None:
    """A step's result is what the policy computes, except for the order of its sums.

    A backward stable computation is exact for inputs within n u of its own, where u is the unit of
    roundoff and n the number of roundings (N. J. Higham, Accuracy and Stability of Numerical
    Algorithms, 2002, section 1.5). So two orders of the same sums may differ by what moving the
    inputs by n u changes, and by n u of the result.

    Args:
        policy: Computes the step again.
        observation: The readings of one robot, without a batch.
        memory: Its memory before the step; None for the first one.
        found: Its memory after the step, computed otherwise.
    """
    _, expected = policy.predict(observation, memory)
    before = None if memory is None else _moved(memory)
    _, around = policy.predict(_moved(observation), before)

    assert found.keys() == expected.keys()
    for name, value in expected.items():
        if not value.is_floating_point():
            assert torch.equal(found[name], value), name
            continue

        changes = torch.nan_to_num(around[name] - value, posinf=0.0, neginf=0.0)
        bound = float(changes.abs().max()) + _unit(value)
        torch.testing.assert_close(
            found[name], value, rtol=0.0, atol=bound, equal_nan=True, msg=f"{name}: {{}}".format
        )


def _moved(values: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Values ``(DRAWS, *n)``, each moved up or down by n u of the largest beside it."""
    signs = torch.Generator().manual_seed(0)
    moved = {}
    for name, value in values.items():
        moved[name] = value.expand(DRAWS, *value.shape)
        if value.is_floating_point():
            sign = torch.randint(0, 2, moved[name].shape, generator=signs) * 2 - 1
            moved[name] = moved[name] + sign * _unit(value)
    return moved


def _unit(value: Tensor) -> float:
    """n u of the largest entry."""
    finite = value[torch.isfinite(value)].abs()
    largest = float(finite.max()) if finite.numel() else 0.0
    return ROUNDINGS * torch.finfo(value.dtype).eps / 2 * largest
