"""Draw docs/images/picking.png: how SO-101 and a UR5e lift, carry and place, seen from the side.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_picking.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

WORLDS = {
    "SO-101": ("so101_pick_place", "none", 400601),
    "SO-101, put back in mid-carry": ("so101_pick_place", "knocked", 400601),
    "UR5e, OGBench": ("ogbench_cubes", "task1", 400001),
}
IMAGE = Path(__file__).parents[1] / "images" / "picking.png"


def episode(name: str, condition: str, seed: int) -> tuple[Any, Any, Any]:
    """Where tip and block were, ``(T, 3)``, m, and the place."""
    world = import_module(name)
    make_env = world.SINGLE.make_env if name == "ogbench_cubes" else world.make_env
    env = make_env(1, condition, horizon=100)
    policy = world.build(world.Options()).compile()
    (observation, _), memory, ended = env.reset(seed=[seed]), None, False
    tips, blocks = [], []
    while not ended:
        tips.append(observation["z_tip"][0, :3])
        blocks.append(observation["z_block"][0, :3])
        action, memory = policy.predict(observation, memory)
        observation, _, arrived, late, _ = env.step(action)
        ended = bool((arrived | late).all())
    env.close()
    return np.array(tips), np.array(blocks), observation["z_goal"][0]


def main() -> None:
    """One episode in each world; to the right is where the block is to go."""
    _, axes = plt.subplots(1, 3, figsize=(12, 3.4), sharey=True, layout="constrained")

    for axis, (title, chosen) in zip(axes, WORLDS.items(), strict=True):
        tips, blocks, goal = episode(*chosen)

        # Along the straight way from where the block lay to its place.
        way = (goal - blocks[0])[:2]
        along = way / np.linalg.norm(way)
        for places, color, label in ((tips, "tab:blue", "tip"), (blocks, "tab:orange", "block")):
            x, z = (places - blocks[0])[:, :2] @ along, places[:, 2]
            axis.plot(100 * x, 100 * z, ".-", color=color, label=label)
        axis.plot(100 * np.linalg.norm(way), 100 * goal[2], "*", color="tab:red", markersize=14)
        axis.plot(0, 100 * blocks[0][2], "s", color="black", markersize=8)

        axis.set_title(f"{title}: {len(tips)} steps", fontsize=10)
        axis.set_xlabel("toward the place (cm)")

    axes[0].set_ylabel("height (cm)")
    axes[0].legend(frameon=False)
    plt.savefig(IMAGE, dpi=90)


if __name__ == "__main__":
    main()
