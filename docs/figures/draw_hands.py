"""Draw docs/images/fetch.png and meta_world.png: moments of an episode, and what is left to go.

After `make worlds`: PYTHONPATH=.venv-worlds:examples/worlds python docs/figures/draw_hands.py
"""

from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from draw_picking import mark

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


class Episode:
    """Pictures at some moments, and in each step how far a thing is from its goal and the hand."""

    def __init__(self, shown: Shown) -> None:
        world = import_module(shown.module)
        self.shown = shown
        self.pictures: list[Any] = []
        self.to_goal: list[float] = []
        self.to_thing: list[float] = []

        env = world.TASK.make_env(1, shown.condition, world.TASK.horizon)
        options = world.Options(**world.TASK.policy_options(shown.condition))
        policy = world.build(options).compile()
        (observation, info), memory, ended = env.reset(seed=[shown.seed]), None, False
        scene = env.envs[0].unwrapped.world.unwrapped
        is_mocap = scene.model.body_mocapid[scene.model.geom_bodyid] >= 0
        scene.model.geom_rgba[is_mocap, 3] = 0.0  # what leads the hand, in the simulation
        renderer = mujoco.Renderer(scene.model, SIZE, SIZE)
        self._look(renderer, scene, observation, info)
        while not ended:
            action, memory = policy.predict(observation, memory)
            observation, _, arrived, late, info = env.step(action)
            self._look(renderer, scene, observation, info)
            ended = bool((arrived | late).all())
        env.close()

    def _look(self, renderer: Any, scene: Any, observation: Any, info: Any) -> None:
        hand, thing = observation[self.shown.hand][0, :2], observation[self.shown.thing][0, :2]
        self.to_goal.append(info["distance"][0])
        self.to_thing.append(float(np.linalg.norm(hand - thing)))
        if len(self.to_goal) - 1 in self.shown.moments:
            option = mujoco.MjvOption()
            option.sitegroup[:] = 0
            renderer.update_scene(scene.data, camera(*self.shown.camera), option)
            mark(renderer.scene, observation["z_goal"][0])
            self.pictures.append(renderer.render())


def camera(at: tuple[float, float, float], distance: float, azimuth: float, down: float) -> Any:
    """A camera that looks at a place, m, from angles, degrees."""
    view = mujoco.MjvCamera()
    view.lookat[:], view.distance, view.azimuth, view.elevation = at, distance, azimuth, down
    return view


def draw(name: str, shown: Shown) -> None:
    """Draw the moments, and beside them the curve."""
    episode = Episode(shown)
    time_step = import_module(shown.module).TASK.time_step
    count = len(shown.moments)
    _, axes = plt.subplots(1, count + 1, figsize=(13, 2.7), layout="constrained")
    for axis, picture, step in zip(axes, episode.pictures, shown.moments, strict=False):
        axis.imshow(picture)
        axis.set_title(f"{step * time_step:.2f} s", fontsize=10)
        axis.set_axis_off()

    seconds = np.arange(len(episode.to_goal)) * time_step
    axis = axes[-1]
    to_thing, to_goal = 100 * np.array(episode.to_thing), 100 * np.array(episode.to_goal)
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
