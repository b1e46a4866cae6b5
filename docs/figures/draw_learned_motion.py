"""Draw docs/images/learned_motion.png: robots whose wheels slip drive home in the dark.

PYTHONPATH=examples python docs/figures/draw_learned_motion.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import torch

IMAGE = Path(__file__).parents[1] / "images" / "learned_motion.png"
STEPS, LIT = 150, 10
"""Steps of an episode, and how many of them the camera sees."""


def ways(example: Any, policy: Any, count: int) -> torch.Tensor:
    """Where robots were, ``(STEPS, count, 2)``, m, from the starts that the example reports."""
    generator = torch.Generator().manual_seed(300_000)
    pose, memory, places = example.starts(count, generator), None, []
    for step in range(STEPS):
        places.append(pose[:, :2])
        reading = example.seen(pose, generator) if step < LIT else torch.full_like(pose, torch.nan)
        action, memory = policy.predict({"z_pose": reading}, memory)
        pose = example.roll(pose, action)
    return torch.stack(places)


def main() -> None:
    """The same starts before and after, and beside them what the network has learned."""
    example = import_module("08_learned_motion")
    rolling = example.make_policy()
    learned = example.learn(rolling)
    _, axes = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")

    for axis, policy, title in (
        (axes[0], rolling, "as wheels roll"),
        (axes[1], learned, "as was learned"),
    ):
        places = ways(example, policy, 12)
        axis.plot(*places[:LIT].unbind(-1), color="tab:blue", linewidth=2.5)
        axis.plot(*places[LIT:].unbind(-1), color="tab:orange", linewidth=1)
        axis.plot(*places[-1].T, "o", color="tab:orange", markersize=4)
        axis.plot(0, 0, "*", color="tab:red", markersize=14)
        axis.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal")

    # The right wheel stands still, and the left one turns.
    left = torch.linspace(-0.5, 0.5, 101, dtype=torch.float64)
    wheels = torch.stack((left, torch.zeros_like(left)), dim=-1)
    with torch.no_grad():
        gain = 1 + learned.model.declaration.estimators[0].relation.function.gain(2 * wheels)
    true = 0.8 * (1 - 0.5 * left**2)
    axes[2].plot(left, true, color="black", label="the world")
    axes[2].plot(left, gain[:, 0], "--", color="tab:orange", label="learned")
    axes[2].set(
        title="how far the left wheel gets",
        xlabel="left wheel (m/s), the right one at rest",
        ylabel="share of its turning",
        ylim=(0.5, 1.05),
    )
    axes[2].axhline(1.0, color="tab:blue", linewidth=1, label="as wheels roll")
    axes[2].legend(frameon=False)
    plt.savefig(IMAGE, dpi=90)


if __name__ == "__main__":
    main()
