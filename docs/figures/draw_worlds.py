"""Draw docs/images/pointmaze.png and ogbench_mazes.png: where a ball rolls, and where it explores.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_worlds.py
"""

from importlib import import_module
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from episodes import moments

SEEDS = {
    "pointmaze": {"umaze": 400021, "medium": 400095, "large": 400010},
    "ogbench_mazes": {"medium_task1": 400000, "large_task1": 400000, "giant_task1": 400001},
}
IMAGES = Path(__file__).parents[1] / "images"


def draw(name: str, seeds: dict[str, int]) -> None:
    """Draw one episode in each maze of a world."""
    world = import_module(name)
    mazes = {one: world.TASK.policy_options(one)["maze"] for one in seeds}
    grids = {one: np.array(world.map_of(maze)) == 1 for one, maze in mazes.items()}
    widths = [grid.shape[1] for grid in grids.values()]
    _, axes = plt.subplots(1, 3, figsize=(12, 3.6), width_ratios=widths, layout="constrained")
    for axis, (condition, seed) in zip(axes, seeds.items(), strict=True):
        height, width = grids[condition].shape
        extent = (-width / 2, width / 2, -height / 2, height / 2)
        axis.imshow(grids[condition], cmap="Greys", vmax=2, extent=extent)

        *rolled, last = moments(f"{name}:TASK", condition, seed)
        places = np.stack([moment.info["position"][0] for moment in rolled])
        explored = np.array([bool(moment.memory["p_ball/exploring"]) for moment in rolled])
        goal = last.observation["z_goal"][0]
        for phase, color in ((explored, "tab:orange"), (~explored, "tab:blue")):
            axis.scatter(*places[phase].T, s=5, color=color, linewidths=0)
        axis.plot(*places[0], "o", color="black", markersize=7)
        axis.plot(*goal, "*", color="tab:red", markersize=14)
        axis.set_title(f"{condition}, {len(places) * world.STEP:.1f} s", fontsize=10)
        axis.set_axis_off()
    plt.savefig(IMAGES / f"{name}.png", dpi=90)


if __name__ == "__main__":
    for name, seeds in SEEDS.items():
        draw(name, seeds)
