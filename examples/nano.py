"""nano-AICON: the whole method with torch alone, in the order in which the paper tells it.

What you learn: all of it. The library does the same for any graph, for batches, and in C.
A disc reads two noisy numbers, the bearing of its target and how near the nearest wall is. It has
no map and no position, and its target lies behind a U, the first trap of the comparison.

    python examples/nano.py
"""

from typing import NamedTuple

import torch
from torch import Tensor, eye
from torch.nn.functional import normalize

torch.set_default_dtype(torch.float64)
DT, SPEED = 0.05, 0.5  # s, m/s
BEARING, RANGE, DRIFT = 0.03, 0.01, 0.02 * DT  # standard deviations: rad, m, m a step
REST = torch.zeros(2)
Belief = tuple[Tensor, Tensor]  # a mean and its covariance


class Memory(NamedTuple):
    """All that lives from step to step."""

    target: Belief  # where it is, seen from here, m
    wall: Belief  # the clearance, m, and its gradient, which points away from the wall
    action: Tensor = REST  # a velocity, m/s
    step: int = 0
    ranks: tuple[int, ...] = (-1, -1)  # the strongest gradient, and the strongest of what it leaves
    average: Tensor = REST  # of the motion, m a step
    exploring: bool = False
    moved: Tensor = REST  # since exploring began, m


# 1. Beliefs: how they begin, what a motion x does to them, and what a reading says.
def begin(bearing: Tensor, clearance: Tensor) -> Memory:
    """The target is 5 m ahead, give or take 3, and the wall in any direction."""
    ahead, across = torch.stack([bearing.cos(), bearing.sin()]), (5.0 * BEARING) ** 2
    target = 5.0 * ahead, (3.0**2 - across) * ahead[:, None] * ahead + across * eye(2)
    return Memory(target, (clearance * eye(3)[0], torch.tensor([RANGE**2, 0.5, 0.5]).diag()))


def move(memory: Memory, x: Tensor) -> tuple[Belief, Belief]:
    """The target comes nearer by x; the clearance changes as beside a straight wall."""
    (target, spread), (wall, wall_spread) = memory[:2]
    slide = torch.cat([torch.cat([torch.ones(1), x])[None], eye(3)[1:]])
    drift = torch.tensor([DRIFT**2, 2.0 * DT, 2.0 * DT]).diag()
    slid = torch.cat([wall[:1] + (wall[1:] * x).sum(), wall[1:]])
    return (target - x, spread + DRIFT**2 * eye(2)), (slid, slide @ wall_spread @ slide.T + drift)


def correct(belief: Belief, error: Tensor, slope: Tensor, variance: float) -> Belief:
    """Kalman's correction by one number that is wrong by `error`."""
    mean, spread = belief
    cross = (spread * slope).sum(1)
    gain = cross / ((cross * slope).sum() + variance)
    return mean - gain * error, spread - torch.outer(gain, cross)


def see(target: Belief, bearing: Tensor) -> Belief:
    """A bearing tells the more of a target, the nearer it is."""
    x, y = target[0]
    error = torch.remainder(torch.atan2(y, x) - bearing + torch.pi, 2 * torch.pi) - torch.pi
    return correct(target, error, torch.stack([-y, x]) / (x**2 + y**2).clamp(1e-4), BEARING**2)


def feel(wall: Belief, clearance: Tensor) -> Belief:
    """A clearance is read; its gradient is known to be one metre a metre."""
    mean, spread = correct(wall, wall[0][0] - clearance, eye(3)[0], RANGE**2)
    steepness = mean[1:].norm()
    slope = torch.cat([torch.zeros(1), mean[1:] / steepness.clamp(1e-9)])
    return correct((mean, spread), steepness - 1.0, slope, 0.05)


# 2. Paths: from each goal back to the motion x that an action would be (Eq. 1).
def gradients(memory: Memory, action: Tensor) -> Tensor:
    """Keep clear, be there, know where: the slope of each where the action leads."""
    x = (action * DT).requires_grad_()
    target, (wall, _) = move(memory, x)
    _, spread = see(target, torch.zeros(()))  # after the next bearing, whatever it will be
    costs = torch.exp(-wall[0] / 0.04), target[0].norm(), spread.trace()
    return torch.stack([torch.autograd.grad(cost, x, retain_graph=True)[0] for cost in costs])


# 3. Gradients that meet are not summed: they are resolved (Eq. 3-8).
def resolve(stack: Tensor, memory: Memory) -> tuple[Tensor, Memory]:
    """Each gradient in the nullspaces of the stronger ones, or exploration in their place."""
    size, direction = stack.norm(dim=1), normalize(stack, dim=1, eps=1e-150)
    left = weighted = direction * torch.softmax(size / size.max() / 0.8, 0)[:, None]

    # Order by strength, with hysteresis, and project.
    resolved, ranks = REST, list[int]()
    for held in memory.ranks:
        ranks.append(int((left.norm(dim=1) * (1.0 + 0.1 * (torch.arange(3) == held))).argmax()))
        resolved, normal = resolved + left[ranks[-1]], normalize(left[ranks[-1]], dim=0)
        left = left - torch.outer(left @ normal, normal)

    # Explore where one opposes the strongest and is not much weaker, until the target is nearer.
    opposes = direction @ direction[ranks[0]] < (-0.4 if memory.exploring else -0.6)
    exploring = bool((opposes & (3.0 * size >= size[ranks[0]])).any())
    moved, target = (memory.moved + memory.action * DT) * memory.exploring, memory.target[0]
    exploring |= memory.exploring and bool(target.norm() >= (target + moved).norm() - 0.1)

    # Go on along the wall then, as near to it as makes it count as much as the others.
    average = torch.lerp(memory.average, memory.action * DT, DT / (DT + 0.4))
    along = direction[0].flip(0) * torch.tensor([-1.0, 1.0])
    onward = along * (along @ (average - 1e-6 * weighted.sum(0))).sign()
    if exploring:
        excess = (size[0] / size[1:].max() - 1.0).clamp(-1.0, 1.0)
        resolved = normalize(3.0 * excess * direction[0] - onward, dim=0)
    after = memory._replace(ranks=tuple(ranks), average=average, exploring=exploring, moved=moved)
    return resolved, after


# 4. The action: twenty gradients down (Eq. 2), each where the action so far would lead.
def act(memory: Memory, bearing: Tensor, clearance: Tensor) -> Memory:
    """One step: believe what is read, descend, and smooth."""
    target, wall = move(memory, memory.action * DT)
    memory = memory._replace(target=see(target, bearing), wall=feel(wall, clearance))

    chirp = (memory.step**2 * torch.tensor([1009, 1009**2]) + 2046) % 4093  # as good as noise
    action = SPEED / 3 * ((chirp - 2046) / 2046)
    for k in range(1, 21):
        gradient, after = resolve(gradients(memory, action), memory)
        action = action - SPEED / 3 / k * gradient / gradient.norm()
        action = action * (SPEED / action.norm().clamp(SPEED))
    action = torch.lerp(memory.action, action, DT / (DT + 0.02))
    return after._replace(action=action, step=memory.step + 1)


def main() -> None:
    """Drive to the target, by nothing but the two readings."""
    corners = torch.tensor([[0.0, -1.22], [-0.44, -1.03], [0.37, 0.86], [0.82, 0.67]])  # m
    shares = torch.linspace(0.0, 1.0, 500)[:, None, None]
    wall = torch.lerp(corners[:-1], corners[1:], shares).flatten(0, 1)
    place, target = torch.tensor([2.24, -0.9]), torch.tensor([-2.37, 1.05])
    memory, random = None, torch.Generator().manual_seed(0)
    while (target - place).norm() > 0.2:
        (x, y), noise = target - place, torch.randn(4, generator=random)
        clearance = (wall - place).norm(dim=1).min() - 0.215  # the disc, and half the wall
        readings = torch.atan2(y, x) + BEARING * noise[0], clearance + RANGE * noise[1]
        memory = act(memory or begin(*readings), *readings)
        place = place + memory.action * DT + DRIFT * noise[2:]
        assert clearance > 0, "the disc touched the wall"
    print(f"The disc is out of the trap and at its target, after {memory.step * DT:.1f} s.")


if __name__ == "__main__":
    main()
