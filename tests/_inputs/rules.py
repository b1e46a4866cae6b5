"""The projection and the exploration as the paper has them, and what they make of a stack of
gradients.
"""

import dataclasses
from typing import Any

from torch import Tensor

from _inputs.gradients import Memory, fresh, gradient_stack, lengths
from aicon_torch import Exploration, NullspaceProjection, Resolution, TrapEscape

PROJECTORS: tuple[Any, ...] = ("orthogonal", "qr", "pinv")
"""The projectors that are equal to each other."""


def projection_in_paper(**options: Any) -> NullspaceProjection:
    """The paper's nullspace projection, with some of its options changed."""
    return dataclasses.replace(NullspaceProjection.as_in_paper(), **options)


def exploration_in_paper(**options: Any) -> Exploration:
    """The paper's exploration, with some of its options changed."""
    return dataclasses.replace(Exploration.as_in_paper(), **options)


def weighted(**options: Any) -> NullspaceProjection:
    """The paper's projection without exploration, so that every result is a resolved sum."""
    return projection_in_paper(**options, exploration=None)


def unweighted(**options: Any) -> NullspaceProjection:
    """The same with magnitudes as they are."""
    return projection_in_paper(**options, temperature=None, exploration=None)


def literal(escape: TrapEscape | None = None, **options: Any) -> NullspaceProjection:
    """The paper's rule with magnitudes as they are and no hysteresis of ranks.

    So the stack says exactly what is in conflict.
    """
    exploration = exploration_in_paper(escape=escape or TrapEscape(), **options)
    return projection_in_paper(temperature=None, margin=0.0, exploration=exploration)


def pursuit() -> NullspaceProjection:
    """The same without exploration."""
    return unweighted(margin=0.0)


def resolve(
    rule: Resolution, gradients: Tensor, memory: Memory | None = None, **context: Any
) -> tuple[Tensor, Memory]:
    """One step of a rule from a stack ``(*B, n, d)``, without a history unless there is a memory.

    The context is what :func:`gradient_stack` takes beside the gradients.
    """
    memory = fresh(rule, gradients) if memory is None else memory
    total, after = rule(gradient_stack(gradients, **context), memory)
    return total, after


def resolved(rule: Resolution, gradients: Tensor) -> Tensor:
    """The gradient that goes on, ``(*B, d)``."""
    return resolve(rule, gradients)[0]


def ranks(rule: NullspaceProjection, gradients: Tensor) -> Tensor:
    """The candidate of each rank, ``(*B, k)``."""
    return resolve(rule, gradients)[1]["rank"]


def explores(rule: Resolution, gradients: Tensor, memory: Memory | None = None) -> bool:
    """Whether a stack ``(n, d)`` is a conflict that is explored."""
    return bool(resolve(rule, gradients, memory)[1]["exploring"])


def selected(rule: NullspaceProjection, gradients: Tensor) -> tuple[Tensor, Tensor]:
    """The projected gradient of each rank, ``(*B, k, d)``, and the candidates ``(*B, k)``."""
    return rule.project_in_order(gradients, lengths(gradients), fresh(rule, gradients)["rank"])
