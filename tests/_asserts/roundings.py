"""What roundings may change: a bound from the computation itself, not from one machine.

A backward stable computation is exact for inputs within n u of its own, where u is the unit of
roundoff and n the number of roundings (N. J. Higham, Accuracy and Stability of Numerical
Algorithms, 2002, section 1.5). So two orders of the same sums may differ by what moving the inputs
by n u changes, and by n u of the result.
"""

from collections.abc import Callable, Mapping

import torch
from torch import Tensor

from aicon_torch import Policy

ROUNDINGS = 1000
"""How many roundings, one after the other, a step makes at most."""

DRAWS = 16
"""How often the inputs of a step are moved to see what that changes."""

UNSEEN = 4.0
"""How much more than all draws the worst of all moves may change: few random ones never meet it."""

Memory = dict[str, Tensor]


def assert_equal_but_for_roundings(
    policy: Policy,
    observation: Mapping[str, Tensor],
    memory: Mapping[str, Tensor] | None,
    found: Mapping[str, Tensor],
) -> Memory:
    """A step's result is what the policy computes, except for the order of its sums.

    What two orders decide differently, such as which of two equal gradients comes first, may be
    different, too.

    Args:
        policy: Computes the step again.
        observation: The readings ``(*B, n)``.
        memory: The memory before the step; None for the first one.
        found: The memory after the step, computed otherwise.

    Returns:
        The memory after the step as the policy computes it.
    """
    _, expected = policy.predict(observation, memory)
    assert found.keys() == expected.keys()
    if all(_is_near(found[name], value) for name, value in expected.items()):
        return expected

    before = None if memory is None else _moved(memory)
    like = policy.model.like
    as_read = {}
    for name, given in observation.items():
        reading = torch.as_tensor(given)
        as_read[name] = reading.to(like) if reading.is_floating_point() else reading
    _, around = policy.predict(_moved(as_read), before)
    for name, value in expected.items():
        _assert_within(name, found[name], value, around[name])
    return expected


def assert_same_but_for_roundings(
    function: Callable[[Tensor], Tensor], value: Tensor, found: Tensor
) -> None:
    """A number or tensor is f(x), except for the order of its sums.

    Args:
        function: f, which lets leading dimensions free.
        value: x.
        found: f(x), computed otherwise.
    """
    around = function(_moved({"x": value})["x"])
    _assert_within("f(x)", found, function(value), around)


def unit(value: Tensor) -> float:
    """n u of the largest entry: how far sums of such entries may be from each other."""
    finite = value[torch.isfinite(value)].abs()
    largest = float(finite.max()) if finite.numel() else 0.0
    return ROUNDINGS * torch.finfo(value.dtype).eps / 2 * largest


def _is_near(found: Tensor, value: Tensor) -> bool:
    """Whether two results are within n u of each other."""
    if not value.is_floating_point():
        return torch.equal(found, value)
    return torch.allclose(found, value, rtol=0.0, atol=unit(value), equal_nan=True)


def _assert_within(name: str, found: Tensor, value: Tensor, around: Tensor) -> None:
    """Two results differ by no more than what moved inputs may change, ``(DRAWS, *n)``."""
    if not value.is_floating_point():
        is_decided = (around == value).all(dim=0)
        assert torch.equal(found[is_decided], value[is_decided]), name
        return

    changes = torch.nan_to_num(around - value, posinf=0.0, neginf=0.0)
    bound = UNSEEN * float(changes.abs().max()) + unit(value)
    torch.testing.assert_close(
        found, value, rtol=0.0, atol=bound, equal_nan=True, msg=f"{name}: {{}}".format
    )


def _moved(values: Mapping[str, Tensor]) -> Memory:
    """Values ``(DRAWS, *n)``, each moved up or down by at most n u of the largest beside it.

    Moved by as much and by less, since a decision may change with small moves alone. Whole numbers,
    such as counts, are exact, and stay.
    """
    draws = torch.Generator().manual_seed(0)
    moved = {}
    for name, given in values.items():
        value = torch.as_tensor(given)
        moved[name] = value.expand(DRAWS, *value.shape)
        if value.is_floating_point():
            part = 2.0 * torch.rand(moved[name].shape, generator=draws) - 1.0
            part[::2] = part[::2].sign()
            moved[name] = moved[name] + part * unit(value) * (value != value.round())
    return moved
