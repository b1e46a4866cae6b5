"""Draw docs/images/pointmaze.png: where the ball of PointMaze rolls, and where it explores.

make worlds EPISODES=1 && PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_worlds.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

SEEDS = {"umaze": 400021, "medium": 400095, "large": 400010}
IMAGE = Path(__file__).parents[1] / "images" / "pointmaze.png"


def episode(world: Any, maze: str, seed: int) -> tuple[Any, Any, Any]:
    """Where the ball was, ``(T, 2)``, m, whether it explored there, and where the goal is."""
    env, policy = world.PointMaze(maze), world.build(world.Options(maze)).compile()
    (observation, info), memory, ended = env.reset(seed=seed), None, False
    places, explored = [], []
    while not ended:
        places.append(info["position"])
        action, memory = policy.predict(observation, memory)
        explored.append(bool(memory["p_ball/exploring"]))
        observation, _, arrived, late, info = env.step(action)
        ended = arrived or late
    env.close()
    return np.array(places), np.array(explored), observation["z_goal"]


def main() -> None:
    """One episode in each maze."""
    world = import_module("pointmaze")
    _, axes = plt.subplots(1, 3, figsize=(12, 3.6), width_ratios=(5, 8, 12), layout="constrained")
    for axis, (maze, seed) in zip(axes, SEEDS.items(), strict=True):
        grid = np.array(getattr(world.robotics(".envs.maze.maps"), world.MAPS[maze])) == 1
        height, width = grid.shape
        extent = (-width / 2, width / 2, -height / 2, height / 2)
        axis.imshow(grid, cmap="Greys", vmax=2, extent=extent)

        places, explored, goal = episode(world, maze, seed)
        for phase, color in ((explored, "tab:orange"), (~explored, "tab:blue")):
            axis.scatter(*places[phase].T, s=5, color=color, linewidths=0)
        axis.plot(*places[0], "o", color="black", markersize=7)
        axis.plot(*goal, "*", color="tab:red", markersize=14)
        axis.set_title(f"{maze}, {len(places) * world.STEP:.1f} s", fontsize=10)
        axis.set_axis_off()
    plt.savefig(IMAGE, dpi=90)


if __name__ == "__main__":
    main()
