"""The navigation policy written out by hand in plain torch: no graph, no library.

It is what the library is measured against (``scripts/benchmark.py``) and an independent second
implementation of the same law (``tests/scripts/test_plain_navigation.py``), with filters in closed
form and the options written as numbers: the default ones, but for the law.
That is one gradient a step, ``DirectDescent(GAIN, smoothing=SMOOTHING)``.
"""

import math
from typing import NamedTuple

import torch
from torch import Tensor

GAIN, SMOOTHING = 20.0, 0.1  # m/s², s
DT, SPEED, LENGTH = 0.05, 0.5, 0.04  # s, m/s, m
BEARING_VARIANCE, CLEARANCE_VARIANCE, SLOPE_VARIANCE = 0.03**2, 0.01**2, 0.05
DRIFT = (0.02 * DT) ** 2  # variance that a step adds to positions


class State(NamedTuple):
    """What lives from step to step.

    Attributes:
        target: Position of the target, ``(*B, 2)``.
        target_cov: Its covariance.
        obstacle: Clearance and its slope in the plane, ``(*B, 3)``.
        obstacle_cov: Its covariance.
        action: Velocity, ``(*B, 2)``.
        rank: Index of the leading and of the second gradient, ``(*B, 2)``; −1 for none.
        exploring: Whether a conflict is on, ``(*B,)``.
        average: Average displacement of a step, ``(*B, 2)``.
        displacement: Displacement since the conflict began, ``(*B, 2)``.
    """

    target: Tensor
    target_cov: Tensor
    obstacle: Tensor
    obstacle_cov: Tensor
    action: Tensor
    rank: Tensor
    exploring: Tensor
    average: Tensor
    displacement: Tensor


class Stack(NamedTuple):
    """Three gradients: of distance and uncertainty of the target, and of a collision's likelihood.

    Attributes:
        norms: Their magnitudes, ``(*B, 3)``.
        units: Their directions, ``(*B, 3, 2)``.
        weights: Their softmax, ``(*B, 3)``.
        scaled: Directions times weights, ``(*B, 3, 2)``.
    """

    norms: Tensor
    units: Tensor
    weights: Tensor
    scaled: Tensor


def begin(bearing: Tensor, clearance: Tensor) -> State:
    """The state before the first step, from the first readings ``(*B, 1)``."""
    batch, zeros = bearing.shape[:-1], bearing.new_zeros

    # The target is 5 m away, give or take 3 m, and 15 cm to the side.
    sight = torch.cat((torch.cos(bearing), torch.sin(bearing)), -1)
    aside = 0.15**2 * torch.eye(2, dtype=bearing.dtype)
    target_cov = (9.0 - 0.15**2) * sight.unsqueeze(-1) * sight.unsqueeze(-2) + aside

    # The obstacle may be in any direction.
    obstacle_cov = torch.diag(bearing.new_tensor((1e-4, 0.5, 0.5)))
    rest = zeros(*batch, 2)
    return State(
        target=5.0 * sight,
        target_cov=target_cov,
        obstacle=torch.cat((clearance, zeros(*batch, 2)), -1),
        obstacle_cov=obstacle_cov.expand(*batch, 3, 3),
        action=rest,
        rank=torch.full((*batch, 2), -1),
        exploring=torch.zeros(batch, dtype=torch.bool),
        average=rest,
        displacement=rest,
    )


def step(state: State, bearing: Tensor, clearance: Tensor, closed_form: bool = False) -> State:
    """One control step from the readings ``(*B, 1)``; the new action is in the state.

    The gradient along each path is taken by autograd (Eq. 1), or written out where ``closed_form``
    is set.
    """
    x = state.action * DT
    prior, target, target_cov = update_target(state, x, bearing)
    obstacle, obstacle_cov = update_obstacle(state, x, clearance)

    slopes = gradients_in_closed_form if closed_form else gradients_by_autograd
    stack = weigh(torch.stack(slopes(target, prior, obstacle, x), -2))
    pursuit, rank = project(stack, state.rank)

    displacement = (state.displacement + x) * state.exploring.unsqueeze(-1)
    average = torch.lerp(state.average, x, DT / (DT + 0.4))
    exploring = in_conflict(stack, rank, state.exploring, target, target_cov, displacement)
    escape = follow_level(stack, average)

    wish = torch.where(exploring.unsqueeze(-1), -escape, pursuit)
    wished = clip(-GAIN * DT * wish)
    action = clip(torch.lerp(state.action, wished, DT / (DT + SMOOTHING)))
    return State(
        target,
        target_cov,
        obstacle,
        obstacle_cov,
        action,
        rank,
        exploring,
        average,
        displacement,
    )


def update_target(state: State, x: Tensor, bearing: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Predict the target after a displacement x, and correct it by its bearing.

    Returns:
        The covariance before the prediction's noise, which the gradients start from, the position
        and its covariance.
    """
    p = state.target - x
    noise = torch.eye(2, dtype=p.dtype) * DRIFT
    difference = torch.atan2(p[..., 1:], p[..., :1]) - bearing
    residual = torch.remainder(difference + math.pi, 2 * math.pi) - math.pi

    gain, cov = shrink(state.target_cov + noise, sight_slope(p), BEARING_VARIANCE)
    return cov + noise, p - gain * residual, cov


def update_obstacle(state: State, x: Tensor, clearance: Tensor) -> tuple[Tensor, Tensor]:
    """Predict clearance and slope, and correct them by the clearance and the slope's length, 1."""
    d, g = state.obstacle[..., :1], state.obstacle[..., 1:]
    o = torch.cat((d + (g * x).sum(-1, keepdim=True), g), -1)
    f = torch.eye(3, dtype=x.dtype).repeat(*x.shape[:-1], 1, 1)
    f[..., 0, 1:] = x
    cov = f @ state.obstacle_cov @ f.mT + torch.diag(x.new_tensor((DRIFT, 2 * DT, 2 * DT)))

    by_clearance = x.new_tensor((1.0, 0.0, 0.0)).expand_as(o)
    gain, cov = shrink(cov, by_clearance, CLEARANCE_VARIANCE)
    o = o - gain * (o[..., :1] - clearance)

    length = o[..., 1:].norm(dim=-1, keepdim=True)
    direction = o[..., 1:] / length.clamp(min=1e-9)
    by_length = torch.cat((torch.zeros_like(length), direction), -1)
    gain, cov = shrink(cov, by_length, SLOPE_VARIANCE)
    return o - gain * (length - 1.0), cov


def sight_slope(p: Tensor) -> Tensor:
    """∂ atan2(y, x) / ∂(x, y), ``(*B, 2)``."""
    across = torch.stack((-p[..., 1], p[..., 0]), -1)
    return across / (p * p).sum(-1, keepdim=True).clamp(min=1e-4)


def shrink(covariance: Tensor, slope: Tensor, noise: float) -> tuple[Tensor, Tensor]:
    """Kalman gain ``(*B, n)`` and corrected covariance for a scalar measurement."""
    cross = (covariance @ slope.unsqueeze(-1)).squeeze(-1)
    gain = cross / ((slope * cross).sum(-1, keepdim=True) + noise)
    return gain, covariance - gain.unsqueeze(-1) * cross.unsqueeze(-2)


def weigh(gradients: Tensor) -> Stack:
    """Magnitudes, directions and softmax weights of gradients ``(*B, 3, 2)`` (Eq. 7)."""
    norms = gradients.norm(dim=-1)
    units = gradients / norms.clamp(min=_smallest(gradients)).unsqueeze(-1)
    weights = torch.softmax(norms / norms.amax(-1, keepdim=True) / 0.8, -1)
    return Stack(norms, units, weights, units * weights.unsqueeze(-1))


def project(stack: Stack, last: Tensor) -> tuple[Tensor, Tensor]:
    """The leader, and the second in its nullspace (Eq. 8); a rank is kept unless beaten by 10 %.

    Returns:
        Their sum, ``(*B, 2)``, and the new ranks.
    """
    index = torch.arange(3)
    first = (stack.weights * (1 + 0.1 * (index == last[..., :1]))).argmax(-1, keepdim=True)
    leads = index == first
    leader = (stack.scaled * leads.unsqueeze(-1)).sum(-2)

    v = (stack.units * leads.unsqueeze(-1)).sum(-2)
    along = (stack.scaled @ v.unsqueeze(-1)) * v.unsqueeze(-2)
    rest = (stack.scaled - along) * ~leads.unsqueeze(-1)

    held = 1 + 0.1 * (index == last[..., 1:])
    strength, second = (rest.norm(dim=-1) * held).max(-1, keepdim=True)
    follower = (rest * (index == second).unsqueeze(-1)).sum(-2)
    rank = torch.cat((first, second.masked_fill(strength == 0, -1)), -1)
    return leader + follower, rank


def in_conflict(
    stack: Stack,
    rank: Tensor,
    exploring: Tensor,
    target: Tensor,
    target_cov: Tensor,
    displacement: Tensor,
) -> Tensor:
    """Whether to explore: the leader is opposed, and nothing has been gained since that began."""
    first = rank[..., :1]
    leads = torch.arange(3) == first
    v = (stack.units * leads.unsqueeze(-1)).sum(-2)

    # The strongest of those that oppose the leader.
    cosines = (stack.units * v.unsqueeze(-2)).sum(-1)
    bound = torch.where(exploring, -0.4, -0.6).to(v.dtype).unsqueeze(-1)
    no_rival = leads | (cosines > bound)
    rival, opponent = stack.norms.masked_fill(no_rival, -1.0).max(-1, keepdim=True)
    cosine = cosines.gather(-1, opponent).masked_fill(rival < 0, 1.0).squeeze(-1)
    decided = (stack.norms.gather(-1, first) > 3.0 * rival).squeeze(-1)

    # Progress: a cost 10 cm lower than where the conflict began.
    spread = target_cov.diagonal(dim1=-2, dim2=-1).sum(-1)
    cost, cost_then = target.norm(dim=-1), (target + displacement).norm(dim=-1)
    no_nearer = cost + spread >= cost_then + spread - 0.1

    stays = ((cosine <= -0.4) & ~decided) | no_nearer
    begins = (cosine < -0.6) & ~decided
    return torch.where(exploring, stays, begins)


def follow_level(stack: Stack, average: Tensor) -> Tensor:
    """The direction along the obstacle's level, as the motion was, that holds this level."""
    n = stack.units[..., 2, :]
    least_steep = torch.arange(2) == n.abs().argmin(-1, keepdim=True)
    wish = average - 1e-6 * stack.scaled.sum(-2) + 1e-9 * least_steep
    t = wish - (wish * n).sum(-1, keepdim=True) * n
    t = t / t.norm(dim=-1, keepdim=True).clamp(min=_smallest(t))

    # At the level both are equally strong.
    balance = stack.norms[..., 2] / stack.norms[..., :2].amax(-1) - 1.0
    t = t - 3.0 * balance.clamp(-1.0, 1.0).unsqueeze(-1) * n
    direction: Tensor = t / t.norm(dim=-1, keepdim=True)
    return direction


def gradients_by_autograd(p: Tensor, prior: Tensor, o: Tensor, x: Tensor) -> tuple[Tensor, ...]:
    """∇ₓ of each path at displacement x.

    The costs are distance and uncertainty of the target and the likelihood of a collision.
    """
    leaves = [x.detach().requires_grad_() for _ in range(3)]
    with torch.enable_grad():
        moved = p - leaves[1]
        _, cov = shrink(prior, sight_slope(moved), BEARING_VARIANCE)
        clearance = o[..., 0] + (o[..., 1:] * (leaves[2] - x)).sum(-1)
        costs = (
            (p - leaves[0] + x).norm(dim=-1),  # at the current estimate, which x has led to
            cov.diagonal(dim1=-2, dim2=-1).sum(-1),
            torch.exp(-clearance / LENGTH),
        )

    gradients = []
    for cost, leaf in zip(costs, leaves, strict=True):
        gradients.append(torch.autograd.grad(cost, leaf, torch.ones_like(cost))[0])
    return tuple(gradients)


def gradients_in_closed_form(p: Tensor, prior: Tensor, o: Tensor, x: Tensor) -> tuple[Tensor, ...]:
    """The same, differentiated by hand."""
    of_distance = -p / p.norm(dim=-1, keepdim=True)
    of_collision = torch.exp(-o[..., :1] / LENGTH) * (-1 / LENGTH) * o[..., 1:]
    return of_distance, uncertainty_slope(p - x, prior), of_collision


def uncertainty_slope(p: Tensor, prior: Tensor) -> Tensor:
    """∇ₓ tr Σ⁺ at displacement x, ``(*B, 2)``, where p = μ − x.

    Σ⁺ = Σ − Σhhᵀ Σ/(hᵀΣh + R) with h = sight_slope(p). With c = Σh, s = hᵀc + R:
    d tr Σ⁺ = −2 (Σc/s − c·(cᵀc)/s²)ᵀ dh, and dh/dp for h = (−y, x)/r².
    """
    h = sight_slope(p)
    c = (prior @ h.unsqueeze(-1)).squeeze(-1)
    s = (h * c).sum(-1, keepdim=True) + BEARING_VARIANCE
    c_square = (c * c).sum(-1, keepdim=True)
    by_h = -2 * ((prior @ c.unsqueeze(-1)).squeeze(-1) / s - c * c_square / s**2)

    # Nearer than 1 cm, r² is a constant.
    square = (p * p).sum(-1, keepdim=True)
    r2 = square.clamp(min=1e-4)
    turned = torch.stack((by_h[..., 1], -by_h[..., 0]), -1)
    by_p = turned / r2 - 2 * p * (by_h * h).sum(-1, keepdim=True) / r2 * (square > 1e-4)
    return -by_p


def clip(action: Tensor) -> Tensor:
    """The action within the speed limit."""
    norm = action.norm(dim=-1, keepdim=True)
    shortened: Tensor = action * (SPEED / norm.clamp(min=SPEED))
    return shortened.clamp(-SPEED, SPEED)


def _smallest(like: Tensor) -> float:
    """The least length that can be divided by and squared."""
    return float(torch.finfo(like.dtype).tiny ** 0.5)
