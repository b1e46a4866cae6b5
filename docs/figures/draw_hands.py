"""Draw docs/images/fetch.png and meta_world.png: moments of an episode, and what is left to go.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_hands.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from aicon_baselines.figures.rendering import camera, mark
from draw_picking import BALL, COLOR
from episodes import moments

IMAGES = Path(__file__).parents[1] / "images"
SIZE = 300  # px, of a moment


class Shown(NamedTuple):
    """An episode, and how it is looked at.

    Attributes:
        module: The world.
        condition: What there is to do.
        seed: Of the episode.
        moments: Steps of the pictures.
        camera: Where it looks at, m, from how far, m, and from which angles, degrees.
        hand: What reads where the hand is.
        thing: What reads where the thing is.
        name: Of the thing.
    """

    module: str
    condition: str
    seed: int
    moments: tuple[int, ...]
    camera: tuple[tuple[float, float, float], float, float, float]
    hand: str
    thing: str
    name: str


FIGURES = {
    "fetch": Shown(
        "fetch",
        "push",
        400006,
        (0, 12, 27, 50),
        ((1.35, 0.75, 0.45), 0.85, 150.0, -35.0),
        "z_hand",
        "z_place",
        "block",
    ),
    "meta_world": Shown(
        "meta_world_puck",
        "push",
        400050,
        (0, 10, 20, 125),
        ((0.0, 0.75, 0.05), 0.8, 150.0, -25.0),
        "z_tip",
        "z_block",
        "puck",
    ),
}


class Eye:
    """Renders a world, without what leads the hand in the simulation."""

    def __init__(self, world: Any, view: Any) -> None:
        self.data, self.view = world.data, view
        leads = world.model.body_mocapid[world.model.geom_bodyid] >= 0
        world.model.geom_rgba[leads, 3] = 0.0
        self.renderer = mujoco.Renderer(world.model, SIZE, SIZE)

    def picture(self, goal: Any) -> Any:
        """The world as it is now, and the goal ``(3,)``, m, in it."""
        option = mujoco.MjvOption()
        option.sitegroup[:] = 0
        self.renderer.update_scene(self.data, self.view, option)
        mark(self.renderer.scene, goal, BALL, COLOR)
        return self.renderer.render()


def draw(name: str, shown: Shown) -> None:
    """Draw the moments, and beside them the curve."""
    eye: Eye | None = None
    pictures: list[Any] = []
    to_goal: list[float] = []
    to_thing: list[float] = []
    for step, moment in enumerate(moments(f"{shown.module}:TASK", shown.condition, shown.seed)):
        seen = moment.observation
        eye = eye or Eye(moment.world.unwrapped, camera(*shown.camera))
        if step in shown.moments:
            pictures.append(eye.picture(seen["z_goal"][0]))
        to_goal.append(100 * moment.info["distance"][0])  # cm
        hand, thing = (seen[name][0, :2] for name in (shown.hand, shown.thing))
        to_thing.append(100 * float(np.linalg.norm(hand - thing)))

    time_step = import_module(shown.module).TASK.time_step
    count = len(shown.moments)
    _, axes = plt.subplots(1, count + 1, figsize=(13, 2.7), layout="constrained")
    for axis, picture, step in zip(axes, pictures, shown.moments, strict=False):
        axis.imshow(picture)
        axis.set_title(f"{step * time_step:.2f} s", fontsize=10)
        axis.set_axis_off()

    seconds = np.arange(len(to_goal)) * time_step
    axis = axes[-1]
    axis.plot(seconds, to_thing, color="tab:blue", label=f"hand to {shown.name}")
    axis.plot(seconds, to_goal, color="tab:orange", label=f"{shown.name} to goal")
    for step in shown.moments:
        axis.axvline(step * time_step, color="lightgray", zorder=0)
    axis.set(xlabel="s", ylabel="cm", ylim=(0, None))
    axis.legend(frameon=False, fontsize=8)
    plt.savefig(IMAGES / f"{name}.png", dpi=90)


if __name__ == "__main__":
    for name, shown in FIGURES.items():
        draw(name, shown)
