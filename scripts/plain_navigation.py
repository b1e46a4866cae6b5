"""The navigation policy written out by hand in plain torch: no graph, no library, filters in closed form.

It is what the library is measured against (``scripts/benchmark.py``) and an independent second implementation of the
same law (``tests/test_plain_navigation.py``), with the default options written as numbers.
"""

import math
from typing import NamedTuple

import torch
from torch import Tensor

DT, SPEED, LENGTH = 0.05, 0.5, 0.04


class State(NamedTuple):
    """Beliefs of target and obstacle, action, ranks, exploring, motion average, displacement since the conflict."""

    target: Tensor
    target_cov: Tensor
    obstacle: Tensor
    obstacle_cov: Tensor
    action: Tensor
    rank: Tensor
    exploring: Tensor
    average: Tensor
    displacement: Tensor


def begin(bearing: Tensor, clearance: Tensor) -> State:
    """The state before the first step, from the first readings ``(*B, 1)``."""
    batch, new = bearing.shape[:-1], bearing.new_zeros
    sight = torch.cat((torch.cos(bearing), torch.sin(bearing)), -1)
    eye = torch.eye(2, dtype=bearing.dtype)
    target_cov = (9.0 - 0.15**2) * sight.unsqueeze(-1) * sight.unsqueeze(-2) + 0.15**2 * eye
    obstacle = torch.cat((clearance, new(*batch, 2)), -1)
    obstacle_cov = torch.diag(bearing.new_tensor((1e-4, 0.5, 0.5))).expand(*batch, 3, 3)
    rank = torch.full((*batch, 2), -1)
    exploring = torch.zeros(batch, dtype=torch.bool)
    rest = new(*batch, 2)
    return State(5.0 * sight, target_cov, obstacle, obstacle_cov, rest, rank, exploring, rest, rest)


def sight_slope(p: Tensor) -> Tensor:
    """∂ atan2(y, x) / ∂(x, y), ``(*B, 2)``."""
    return torch.stack((-p[..., 1], p[..., 0]), -1) / (p * p).sum(-1, keepdim=True).clamp(min=1e-4)


def shrink(covariance: Tensor, slope: Tensor, noise: float) -> tuple[Tensor, Tensor]:
    """Kalman gain ``(*B, n)`` and corrected covariance for a scalar measurement."""
    cross = (covariance @ slope.unsqueeze(-1)).squeeze(-1)
    gain = cross / ((slope * cross).sum(-1, keepdim=True) + noise)
    return gain, covariance - gain.unsqueeze(-1) * cross.unsqueeze(-2)


def step(state: State, bearing: Tensor, clearance: Tensor, closed_form: bool = False) -> State:
    """One control step from the readings ``(*B, 1)``; the new action is in the state.

    The gradient along each path is taken by autograd (Eq. 1), or written out where ``closed_form`` is set.
    """
    x = state.action * DT
    # target: predict, measure the bearing
    p = state.target - x
    noise = torch.eye(2, dtype=p.dtype) * (0.02 * DT) ** 2
    residual = (
        torch.remainder(torch.atan2(p[..., 1:], p[..., :1]) - bearing + math.pi, 2 * math.pi)
        - math.pi
    )
    gain, cov = shrink(state.target_cov + noise, sight_slope(p), 0.03**2)
    p = p - gain * residual
    # obstacle: predict, measure the clearance, then the slope's length
    d, g = state.obstacle[..., :1], state.obstacle[..., 1:]
    o = torch.cat((d + (g * x).sum(-1, keepdim=True), g), -1)
    f = torch.eye(3, dtype=x.dtype).repeat(*x.shape[:-1], 1, 1)
    f[..., 0, 1:] = x
    ocov = f @ state.obstacle_cov @ f.mT + torch.diag(
        x.new_tensor(((0.02 * DT) ** 2, 2 * DT, 2 * DT))
    )
    gain, ocov = shrink(ocov, x.new_tensor((1.0, 0.0, 0.0)).expand_as(o), 0.01**2)
    o = o - gain * (o[..., :1] - clearance)
    length = o[..., 1:].norm(dim=-1, keepdim=True)
    gain, ocov = shrink(
        ocov, torch.cat((torch.zeros_like(length), o[..., 1:] / length.clamp(min=1e-9)), -1), 0.05
    )
    o = o - gain * (length - 1.0)
    # the three gradients
    slopes = gradients_in_closed_form if closed_form else gradients_by_autograd
    stack = torch.stack(slopes(p, cov + noise, o, x), -2)
    norms = stack.norm(dim=-1)
    units = stack / norms.clamp(min=torch.finfo(x.dtype).tiny ** 0.5).unsqueeze(-1)
    weights = torch.softmax(norms / norms.amax(-1, keepdim=True) / 0.8, -1)
    scaled = units * weights.unsqueeze(-1)
    # order with hysteresis, project, add
    index = torch.arange(3)
    first = (weights * (1 + 0.1 * (index == state.rank[..., :1]))).argmax(-1, keepdim=True)
    is_first = index == first
    top = (scaled * is_first.unsqueeze(-1)).sum(-2)
    v = (units * is_first.unsqueeze(-1)).sum(-2)
    rest = (scaled - (scaled @ v.unsqueeze(-1)) * v.unsqueeze(-2)) * ~is_first.unsqueeze(-1)
    strengths = rest.norm(dim=-1)
    strength, second = (strengths * (1 + 0.1 * (index == state.rank[..., 1:]))).max(
        -1, keepdim=True
    )
    pursuit = top + (rest * (index == second).unsqueeze(-1)).sum(-2)
    # conflict of the strongest with the strongest that opposes it
    cosines = (units * v.unsqueeze(-2)).sum(-1)
    agrees = cosines > torch.where(state.exploring, -0.4, -0.6).to(x.dtype).unsqueeze(-1)
    rival, opponent = norms.masked_fill(is_first | agrees, -1.0).max(-1, keepdim=True)
    cosine = cosines.gather(-1, opponent).masked_fill(rival < 0, 1.0).squeeze(-1)
    decided = (norms.gather(-1, first) > 3.0 * rival).squeeze(-1)
    average = torch.lerp(state.average, x, DT / (DT + 0.4))
    displacement = (state.displacement + x) * state.exploring.unsqueeze(-1)
    spread = cov.diagonal(dim1=-2, dim2=-1).sum(-1)
    no_nearer = p.norm(dim=-1) + spread >= (p + displacement).norm(dim=-1) + spread - 0.1
    stay = ((cosine <= -0.4) & ~decided) | no_nearer
    exploring = torch.where(state.exploring, stay, (cosine < -0.6) & ~decided)
    # explore along the obstacle's level
    n = units[..., 2, :]
    axis = torch.arange(2) == n.abs().argmin(-1, keepdim=True)
    wish = average - 1e-6 * scaled.sum(-2) + 1e-9 * axis
    t = wish - (wish * n).sum(-1, keepdim=True) * n
    t = t / t.norm(dim=-1, keepdim=True).clamp(min=torch.finfo(x.dtype).tiny ** 0.5)
    error = (norms[..., 2] / norms[..., :2].amax(-1) - 1.0).clamp(-1.0, 1.0).unsqueeze(-1)
    t = t - 3.0 * error * n
    t = t / t.norm(dim=-1, keepdim=True)
    # act
    wish = clip(-20.0 * DT * torch.where(exploring.unsqueeze(-1), -t, pursuit))
    action = clip(torch.lerp(state.action, wish, DT / (DT + 0.1)))
    rank = torch.cat((first, second.masked_fill(strength == 0, -1)), -1)
    return State(p, cov, o, ocov, action, rank, exploring, average, displacement)


def gradients_by_autograd(p: Tensor, prior: Tensor, o: Tensor, x: Tensor) -> tuple[Tensor, ...]:
    """∇ₓ of each path at displacement x: distance and uncertainty of the target, likelihood of collision."""
    leaves = [x.detach().requires_grad_() for _ in range(3)]
    with torch.enable_grad():
        at = p - leaves[1]
        _, cov = shrink(prior, sight_slope(at), 0.03**2)
        costs = (
            (p - leaves[0] + x).norm(dim=-1),  # at the current estimate, which x has led to
            cov.diagonal(dim1=-2, dim2=-1).sum(-1),
            torch.exp(-(o[..., 0] + (o[..., 1:] * (leaves[2] - x)).sum(-1)) / LENGTH),
        )
        return tuple(
            torch.autograd.grad(cost, leaf, torch.ones_like(cost))[0]
            for cost, leaf in zip(costs, leaves, strict=True)
        )


def gradients_in_closed_form(p: Tensor, prior: Tensor, o: Tensor, x: Tensor) -> tuple[Tensor, ...]:
    """The same, differentiated by hand."""
    p1 = -p / p.norm(dim=-1, keepdim=True)
    p3 = torch.exp(-o[..., :1] / LENGTH) * (-1 / LENGTH) * o[..., 1:]
    return p1, uncertainty_slope(p - x, prior), p3


def uncertainty_slope(p: Tensor, prior: Tensor) -> Tensor:
    """∇ₓ tr Σ⁺ at displacement x, with p = μ − x and Σ⁺ = Σ − Σhhᵀ Σ/(hᵀΣh + R), h = sight_slope(p); ``(*B, 2)``.

    With c = Σh, s = hᵀc + R: d tr Σ⁺ = −2 (Σc/s − c·(cᵀc)/s²)ᵀ dh, and dh/dp for h = (−y, x)/r².
    """
    h = sight_slope(p)
    c = (prior @ h.unsqueeze(-1)).squeeze(-1)
    s = (h * c).sum(-1, keepdim=True) + 0.03**2
    by_h = -2 * (
        (prior @ c.unsqueeze(-1)).squeeze(-1) / s - c * (c * c).sum(-1, keepdim=True) / s**2
    )
    square = (p * p).sum(-1, keepdim=True)
    r2 = square.clamp(min=1e-4)  # a constant nearer than 1 cm
    turned = torch.stack((by_h[..., 1], -by_h[..., 0]), -1)
    by_p = turned / r2 - 2 * p * (by_h * h).sum(-1, keepdim=True) / r2 * (square > 1e-4)
    return -by_p


def clip(action: Tensor) -> Tensor:
    """The action within the speed limit."""
    norm = action.norm(dim=-1, keepdim=True)
    shortened: Tensor = action * (SPEED / norm.clamp(min=SPEED))
    return shortened.clamp(-SPEED, SPEED)
