"""How often resolved gradients raise the cost of the one that leads, once they have gone from x_ee to the joints.

Example: python scripts/panda_merging.py

Gradients that are orthogonal at the arm's end effector are not so in the joints. For random stacks of gradients at x_ee
and random joint angles, this resolves the stack there and pulls back either the sum (merged), or each gradient, to be
resolved again in the joints by magnitude or in the order that they had at x_ee (inherited).
"""

import argparse
import os
from collections.abc import Callable

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import torch
from torch import Tensor

from aicon_torch.parts.chain import EE_SIZE, Kinematics
from aicon_torch.models.panda_push.robot import PANDA
from aicon_torch.resolution import NullspaceProjection

POSE = (0.1, 0.3, -0.2, -2.2, 0.1, 2.5, 0.6)
"""Joint angles about which to draw, rad."""


def main() -> None:
    """Parse the arguments and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=20_000, help="number of draws (default: 20000)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the draws (default: 0)")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    print("share of draws in which the leader's cost rises\ngradients  pull-back  merged  by magnitude  inherited")
    for count in (2, 3, 4):
        for pullback in ("natural", "transpose"):
            shares = rises(count, pullback, arguments.draws, torch.Generator().manual_seed(arguments.seed))
            print(f"{count:9}  {pullback:9}  {shares[0]:6.1%}  {shares[1]:12.1%}  {shares[2]:9.1%}")


def rises(count: int, pullback: str, draws: int, generator: torch.Generator) -> tuple[float, float, float]:
    """The shares: merged, resolved again by magnitude, and in the inherited order."""
    kinematics, rule = Kinematics(PANDA), NullspaceProjection(relative=True, exploration=None)
    q = torch.tensor(POSE, dtype=torch.float64) + 0.3 * torch.randn(draws, 7, generator=generator, dtype=torch.float64)
    jacobian = kinematics.jacobian(kinematics.frames(q))
    lengths = torch.rand(draws, count, 1, generator=generator, dtype=torch.float64)
    gradients = lengths * torch.randn(draws, count, EE_SIZE, generator=generator, dtype=torch.float64)
    weights = rule.weigh(gradients.norm(dim=-1))
    scaled = torch.nn.functional.normalize(gradients, dim=-1) * weights.unsqueeze(-1)
    taken, rank = rule.resolve(scaled, weights, torch.full((draws, count), -1))
    leader = gradients[torch.arange(draws), rank[:, 0]]

    def pull(gradient: Tensor) -> Tensor:
        if pullback == "natural":
            return kinematics.natural(jacobian, gradient)
        return (jacobian.mT @ gradient.unsqueeze(-1)).squeeze(-1)

    def share(motion: Tensor) -> float:
        change = -(leader * (jacobian @ motion.unsqueeze(-1)).squeeze(-1)).sum(-1)
        return float((change > 1e-9).double().mean())

    pulled = torch.stack([pull(gradient) for gradient in taken.unbind(-2)], dim=-2)
    again, _ = rule.resolve(pulled, pulled.norm(dim=-1), torch.full((draws, count), -1))
    return share(pull(taken.sum(-2))), share(again.sum(-2)), share(in_turn(pulled).sum(-2))


def in_turn(gradients: Tensor) -> Tensor:
    """Gradients ``(B, n, d)``, each projected into the nullspaces of those before it."""
    project: Callable[[Tensor, Tensor], Tensor] = NullspaceProjection().project
    taken = []
    for _ in range(gradients.shape[-2]):
        first, gradients = gradients[..., 0, :], gradients[..., 1:, :]
        taken.append(first)
        gradients = project(first, gradients)
    return torch.stack(taken, dim=-2)


if __name__ == "__main__":
    main()
