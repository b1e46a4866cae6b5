"""Arms that reach, simulated by their kinematics alone."""

from typing import Any

import torch
from torch import Tensor

from aicon_torch import Policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts import Capsule, Capsules, Chain, Joint

DT = 0.02


def shift(x: float = 0.0) -> tuple[tuple[float, ...], ...]:
    """A transform along x, m."""
    return (1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)


def planar_arm(speed: float = 1.5, links: int = 3, shape: bool = True) -> Robot:
    """Links of 30 cm in a plane, as capsules with a radius of 3 cm."""
    joints = [Joint(f"joint_{i}", low=-2.8, high=2.8, speed=speed) for i in range(1, links + 1)]
    chain = Chain([shift(), *[shift(0.3)] * (links - 1)], shift(0.3), joints)
    if not shape:
        return Robot(chain)

    capsules = [Capsule(i, (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), 0.03) for i in range(1, links + 1)]
    pairs = [(i, j) for j in range(links) for i in range(j - 1)]
    return Robot(chain, Capsules(tuple(capsules), chain.names, tuple(pairs)))


def targets_of(robot: Robot, count: int, seed: int, inside: float = 0.1) -> Tensor:
    """The tip's transforms ``(count, 4, 4)`` at random joints in the middle of their ranges."""
    chain = robot.chain
    generator = torch.Generator().manual_seed(seed)
    share = torch.rand(count, len(chain.names), generator=generator, dtype=torch.float64)
    low, high = chain.low.clamp(min=-torch.pi), chain.high.clamp(max=torch.pi)
    return chain(low + (inside + (1 - 2 * inside) * share) * (high - low))


def reach(
    policy: Policy, q: Tensor, seconds: float, dt: float = DT, **observation: Any
) -> tuple[Tensor, dict[str, Tensor]]:
    """The joints ``(steps + 1, *B, n)`` on the way, and the last memory."""
    way, memory = [q], None
    for _ in range(round(seconds / dt)):
        action, memory = policy.predict({"q": way[-1], **observation}, memory)
        way.append(way[-1] + dt * action)

    assert memory is not None
    return torch.stack(way), memory
