"""Gradient shaping: tensors whose value comes from one place and whose gradient from another."""

from typing import Any

import torch
from torch import Tensor

from aicon_torch.differentiation import is_hop, learns, stop


def straight_through(value: Tensor, model: Tensor) -> Tensor:
    """``value`` with the gradient of ``model``, such as a measurement with its prediction's.

    Args:
        value: ``(*B, n)``; no gradient reaches it.
        model: ``(*B, n)``.
    """
    return model + stop(value - model)  # a value only, so the gradient is the model's


def straight_through_clamp(x: Tensor, low: float, high: float) -> Tensor:
    """``x`` clamped to [low, high] with the gradient of ``x``: saturated, it can still be steered.

    Args:
        x: ``(*B, n)``.
        low: Lowest value.
        high: Highest value.
    """
    return straight_through(x.clamp(low, high), x)


def by_sign(positive: Tensor, negative: Tensor) -> Tensor:
    """``negative`` in value; a gradient > 0 goes to ``positive``, any other to ``negative``.

    Where ∂g/∂x > 0 the cost falls as x falls, where it is negative the cost falls as x grows. With
    this rule an edge may react differently to what is to be reduced and to what is to be increased,
    though no estimator knows a goal.

    Args:
        positive: ``(*B, n)``, differentiated where the quantity is to be reduced.
        negative: ``(*B, n)``, differentiated where it is to be increased, and the value.
    """
    chosen: Tensor = _BySign.apply(positive, negative)  # type: ignore[no-untyped-call]  # torch leaves apply untyped
    return chosen


class _BySign(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, positive: Tensor, negative: Tensor) -> Tensor:
        ctx.learns = learns()
        return negative.clone()

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, Tensor]:
        if ctx.learns and not is_hop():  # of a loss: the value's own derivative
            return torch.zeros_like(gradients[0]), gradients[0]
        return gradients[0].clamp(min=0), gradients[0].clamp(max=0)


def by_gain(effects: Tensor, intended: Tensor, incidental: Tensor, softness: float = 0.0) -> Tensor:
    """Σᵢ wᵢ eᵢ, whose weights depend on whether an effect is wanted where the gradient comes from.

    When a gradient h arrives, the gain of an effect is bᵢ = h·eᵢ. Where b < 0 the effect lowers the
    cost and its weight is ``intended``; elsewhere it is ``incidental``. With a softness T, w =
    σ(−b/T) intended + (1 − σ(−b/T)) incidental. The choice itself is not differentiated, and no
    part of the graph needs to know the goal. In value w is ``intended``.

    Args:
        effects: eᵢ, ``(*B, n, d)``.
        intended: Weights of effects that are wanted, ``(*B, n)``.
        incidental: Weights of those that are not, ``(*B, n)``.
        softness: T, in the unit of the gain; 0 decides by the sign.

    Returns:
        ``(*B, d)``.
    """
    weigh = _ByGain.apply
    motion: Tensor = weigh(effects, intended, incidental, softness)  # type: ignore[no-untyped-call]  # as above
    return motion


class _ByGain(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, effects: Tensor, intended: Tensor, incidental: Tensor, softness: float
    ) -> Tensor:
        ctx.save_for_backward(effects, intended, incidental)
        ctx.softness, ctx.learns = softness, learns()
        return (intended.unsqueeze(-1) * effects).sum(-2)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, Tensor, Tensor, None]:
        effects, intended, incidental = ctx.saved_tensors
        arriving = gradients[0].unsqueeze(-2)
        if ctx.learns and not is_hop():  # of a loss: the value's own derivative
            gain = (effects * arriving).sum(-1)
            return intended.unsqueeze(-1) * arriving, gain, torch.zeros_like(gain), None

        # How far each effect is wanted where the gradient comes from.
        gain = (effects * arriving).sum(-1)
        if ctx.softness:
            share = torch.sigmoid(-gain / ctx.softness)
        else:
            share = (gain < 0).to(gain.dtype)

        # To each effect by its weight; to each weight the gain of the effects that it counted for.
        weight = share * intended + (1 - share) * incidental
        return weight.unsqueeze(-1) * arriving, share * gain, (1 - share) * gain, None


def by_worth(weight: Tensor, like: Tensor, step: float) -> Tensor:
    """Zero, whose gradient tells a weight what a motion in any direction would be worth.

    When a gradient h arrives, a motion of at most s could lower a cost of curvature 1, such as
    ½‖x − x*‖², by

        V(h) = max over t ≤ s of t‖h‖ − t²/2,

    which is ½‖h‖² near the optimum and grows as s‖h‖ far from it. The weight says how likely it is
    that there can be such a motion, so its gradient is −V(h). Nothing has to be known of the goal.

    Args:
        weight: ``(*B, 1)``.
        like: What would move, ``(*B, d)``; no gradient reaches it.
        step: s, in the unit of h.

    Returns:
        Zeros, ``(*B, d)``.
    """
    zero: Tensor = _ByWorth.apply(weight, like, step)  # type: ignore[no-untyped-call]  # as above
    return zero


class _ByWorth(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, weight: Tensor, like: Tensor, step: float) -> Tensor:
        ctx.step, ctx.learns = step, learns()
        return torch.zeros_like(like)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, None, None]:
        if ctx.learns and not is_hop():  # of a loss: the value is zero, whatever the weight
            return torch.zeros_like(gradients[0][..., :1]), None, None

        slope = torch.linalg.vector_norm(gradients[0], dim=-1, keepdim=True)

        # t‖h‖ − t²/2 is largest at t = min(‖h‖, s).
        way = slope.clamp(max=ctx.step)
        return way * way / 2 - way * slope, None, None
