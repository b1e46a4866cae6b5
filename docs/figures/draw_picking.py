"""Draw how SO-101 and a UR5e lift, carry and place: from the side, and as films.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_picking.py

It saves picking.png, and the film of each of FILMS, with the path from a goal along which tip and
jaw are led.
"""

from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import mujoco
import numpy as np
from matplotlib.font_manager import findfont
from PIL import Image, ImageDraw, ImageFont

from aicon_baselines.figures.rendering import Frame, mark, save_video
from aicon_baselines.palette import GOAL, INK, rgb
from episodes import Moment, moments

WORLDS = {
    "SO-101": ("so101_pick_place:TASK", "none", 400601),
    "SO-101, put back in mid-carry": ("so101_pick_place:TASK", "knocked", 400601),
    "SO-101, a board on the way": ("so101_in_the_way:TASK", "board", 402600),
    "UR5e, OGBench": ("ogbench_cubes:SINGLE", "task1", 400001),
}
FILMS = {
    "so101_knocked": ("so101_pick_place:TASK", "knocked", 400601),
    "so101_pick_cube": ("so101_pick_cube:TASK", "near", 404250),
    "cube_single": ("ogbench_cubes:SINGLE", "task1", 400001),
    "cube_double": ("ogbench_cubes:DOUBLE", "task4", 406000),
    "cube_triple": ("ogbench_cubes:TRIPLE", "task5", 406000),
    "scene": ("ogbench_scene:TASK", "task4", 406000),
}
IMAGES = Path(__file__).parents[1] / "images"

SIZE = (480, 360)  # px
RATE = 5  # pictures a second, of which each shows a step
REST = 5  # pictures at the end
BALL = 0.012  # radius of a place, m
COLOR = (*(part / 255 for part in rgb(GOAL)), 1.0)
FONT = ImageFont.truetype(findfont("DejaVu Sans"), 13)


def save_film(chosen: tuple[str, str, int], path: Path) -> None:
    """Save the film of an episode."""
    film = Film()
    for moment in moments(*chosen):
        film.add(moment)
    save_video(film.frames + film.frames[-1:] * REST, path, RATE)


class Film:
    """Pictures of a world and the places in it, with what leads tip and jaw."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.renderer: Any = None

    def add(self, moment: Moment) -> None:
        """Add a picture."""
        (width, height), world, policy = SIZE, moment.world, moment.policy
        if self.renderer is None:
            world.model.vis.global_.offwidth, world.model.vis.global_.offheight = SIZE
            self.renderer = mujoco.Renderer(world.model, height, width)
        self.renderer.update_scene(world.data, camera="front")
        for name in moment.observation:
            if name.startswith("z_goal"):
                mark(self.renderer.scene, moment.observation[name][0], BALL, COLOR)
        picture = Image.fromarray(self.renderer.render())

        pen = ImageDraw.Draw(picture)
        pen.rectangle((0, height - 42, width, height), fill="white")
        trace = policy.trace(moment.memory)
        for line, actuator in enumerate(policy.model.actuators):
            led = " → ".join(trace.leading_path(actuator, (0,)))
            pen.text((8, height - 40 + 19 * line), led, font=FONT, fill=INK)
        self.frames.append(np.asarray(picture))


def main() -> None:
    """One episode in each world; to the right is where the block is to go."""
    _, axes = plt.subplots(1, 4, figsize=(14, 3.4), sharey=True, layout="constrained")

    for axis, (title, chosen) in zip(axes, WORLDS.items(), strict=True):
        *seen, last = [moment.observation for moment in moments(*chosen)]
        tips, blocks = (np.stack([o[name][0, :3] for o in seen]) for name in ("z_tip", "z_block"))
        goal = last["z_goal"][0]

        # Along the straight way from where the block lay to its place.
        way = (goal - blocks[0])[:2]
        along = way / np.linalg.norm(way)
        for places, color, label in ((tips, "tab:blue", "tip"), (blocks, "tab:orange", "block")):
            x, z = (places - blocks[0])[:, :2] @ along, places[:, 2]
            axis.plot(100 * x, 100 * z, ".-", color=color, label=label)
        length = float(np.linalg.norm(way))
        if chosen[1] == "board":
            board = import_module(chosen[0].split(":")[0])
            axis.bar(50 * length, 100 * board.HIGH, 100 * board.THIN, color="tab:gray")
        axis.plot(100 * length, 100 * goal[2], "*", color="tab:red", markersize=14)
        axis.plot(0, 100 * blocks[0][2], "s", color="black", markersize=8)

        axis.set_title(f"{title}: {len(tips)} steps", fontsize=10)
        axis.set_xlabel("toward the place (cm)")

    axes[0].set_ylabel("height (cm)")
    axes[0].legend(frameon=False)
    plt.savefig(IMAGES / "picking.png", dpi=90)

    for name, chosen in FILMS.items():
        save_film(chosen, IMAGES / f"{name}.webp")


if __name__ == "__main__":
    main()
