"""Gradient shaping: tensors whose value comes from one place and whose gradient from another."""

from typing import Any, cast

import torch
from torch import Tensor


def straight_through(value: Tensor, model: Tensor) -> Tensor:
    """The value of ``value`` with the gradient of ``model``, e.g. a measurement with the gradient of a prediction.

    Args:
        value: ``(*B, n)``; no gradient reaches it.
        model: ``(*B, n)``.
    """
    return model + (value - model).detach()  # the difference is a value only, so the gradient is the model's


def straight_through_clamp(x: Tensor, low: float, high: float) -> Tensor:
    """``x`` clamped to [low, high] with the gradient of ``x``, so that a saturated quantity can still be steered.

    Args:
        x: ``(*B, n)``.
        low: Lowest value.
        high: Highest value.
    """
    return straight_through(x.clamp(low, high), x)


def by_sign(positive: Tensor, negative: Tensor) -> Tensor:
    """``negative`` in value; the gradient goes to ``positive`` where it arrives > 0 and to ``negative`` elsewhere.

    Where ∂g/∂x > 0 the cost falls as x falls, where it is negative the cost falls as x grows. With this rule an edge
    may react differently to what is to be reduced and to what is to be increased, though no estimator knows a goal.

    Args:
        positive: ``(*B, n)``, differentiated where the quantity is to be reduced.
        negative: ``(*B, n)``, differentiated where it is to be increased, and the value.
    """
    return cast(Tensor, _BySign.apply(positive, negative))  # type: ignore[no-untyped-call]  # torch leaves apply untyped


class _BySign(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, positive: Tensor, negative: Tensor) -> Tensor:
        return negative.clone()

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, Tensor]:
        return gradients[0].clamp(min=0), gradients[0].clamp(max=0)
