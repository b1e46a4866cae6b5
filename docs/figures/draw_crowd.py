"""Draw docs/images/crowd.png: how a robot crosses a circle, and two streams, of people.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_crowd.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle

from episodes import moments

EPISODES = {
    "AICON, people who do not see it": ("circle10_blind", 400006, "aicon"),
    "ORCA, the same people": ("circle10_blind", 400006, "orca"),
    "AICON, two streams": ("streams10_blind", 400001, "aicon"),
}
crowd = import_module("crowd")
IMAGE = Path(__file__).parents[1] / "images" / "crowd.png"


def episode(condition: str, seed: int, name: str) -> tuple[Any, Any, Any]:
    """Where all were, the robot first, ``(T, 1 + N, 2)``, m, whether it explored, and the end."""
    places, explored = [], []
    policy = crowd.Orca() if name == "orca" else None
    for moment in moments("crowd:TASK", condition, seed, policy):
        seen = moment.observation
        everybody = np.concatenate([seen["z_robot"][0], seen["z_people"][0]])
        places.append(everybody.reshape(-1, 2))

        is_exploring = policy is None and bool(moment.memory["p_robot/exploring"])
        explored.append(is_exploring and not moment.is_last)
    return np.array(places), np.array(explored), moment.info


def draw(axis: Any, title: str, condition: str, seed: int, name: str) -> None:
    """Draw an episode."""
    places, explored, info = episode(condition, seed, name)
    robot, people = places[:, 0], places[:, 1:]
    for person in range(people.shape[1]):
        axis.plot(*people[:, person].T, color="0.75", linewidth=1)
        axis.add_patch(Circle(people[-1, person], crowd.RADIUS, color="0.75"))

    for phase, color in ((explored, "tab:orange"), (~explored, "tab:blue")):
        axis.scatter(*robot[phase].T, s=6, color=color, linewidths=0, zorder=3)
    touches = bool(info["collision"][0])
    axis.add_patch(Circle(robot[-1], crowd.RADIUS, color="tab:red" if touches else "tab:blue"))
    axis.plot(*robot[0], "o", color="black", markersize=7)
    axis.plot(0.0, crowd.SIZE, "*", color="tab:red", markersize=14, zorder=4)

    end = "touches somebody after" if touches else "there after"
    axis.set_title(f"{title}: {end} {(len(robot) - 1) * crowd.STEP:.1f} s", fontsize=10)
    axis.set_aspect("equal")
    axis.set_axis_off()


def main() -> None:
    """Draw the episodes side by side."""
    _, axes = plt.subplots(1, len(EPISODES), figsize=(14, 4.6), layout="constrained")
    for axis, (title, shown) in zip(axes, EPISODES.items(), strict=True):
        draw(axis, title, *shown)
    plt.savefig(IMAGE, dpi=90)


if __name__ == "__main__":
    main()
