"""The film of an episode of the arm: from outside, from the hand, and the strengths of the gradients over time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aicon_baselines.tasks.panda_push import TASK
from aicon_baselines.figures.pictures import check_video, pixels, save_video
from aicon_envs.panda_push import PandaPushEnv
from aicon_torch import Policy, make_policy

STEP = 10
"""Control steps from picture to picture: ten pictures a second, in real time."""

_COLOURS = ("#0072B2", "#56B4E9", "#D55E00", "#009E73", "#CC79A7", "#E69F00")


class Film(NamedTuple):
    """What was recorded, a row for every picture.

    Attributes:
        times: s, ``(n,)``.
        outside: ``(n, H, W, 3)``.
        hand: ``(n, h, w, 3)``, as the policy sees it.
        labels: Names of the gradients.
        strengths: Their magnitudes where they meet, ``(n, labels)``.
        exploring: Whether gradients are explored anywhere, ``(n,)``.
        height: Height of the tip, mm, ``(n,)``.
        distance: Distance to the target, mm, ``(n,)``.
        angle: Angle to the target, degrees, ``(n,)``.
        success: Whether the episode succeeded.
    """

    times: NDArray[np.float64]
    outside: list[NDArray[np.uint8]]
    hand: list[NDArray[np.uint8]]
    labels: tuple[str, ...]
    strengths: NDArray[np.float64]
    exploring: NDArray[np.bool_]
    height: NDArray[np.float64]
    distance: NDArray[np.float64]
    angle: NDArray[np.float64]
    success: bool


def make_film(seed: int, out: Path, video: str = "mp4", horizon: int = 6_000) -> Film:
    """Run an episode and save `panda_film.mp4` (or .gif) and its last picture as `panda_film.png`.

    Args:
        seed: Seed of the episode.
        out: Folder, made if it does not exist.
        video: One of `aicon_baselines.figures.pictures.VIDEOS`.
        horizon: Steps after which it ends.
    """
    check_video(video)
    out.mkdir(parents=True, exist_ok=True)
    film = record(make_policy("panda_push", **TASK.policy_options("camera")), seed, horizon)
    pictures = list(draw(film))
    if video != "none":
        save_video(iter(pictures), out / f"panda_film.{video}", 10, _palette())
    from PIL import Image

    Image.fromarray(pictures[len(pictures) // 2]).save(out / "panda_film.png")
    return film


def record(policy: Policy, seed: int, horizon: int) -> Film:
    """Run an episode with the camera and take a picture of every tenth step."""
    env = PandaPushEnv(render_mode="rgb_array", render_width=480, render_height=360)
    observation, info = env.reset(seed=seed)
    memory: Any = None
    places = [name for name in ("x_ee", "x_joints") if name in policy.backward_pass.arrivals]
    labels = [(place, str(arrival)) for place in places for arrival in policy.backward_pass.arrivals[place]]
    rows: list[tuple[Any, ...]] = []
    for step in range(horizon):
        action, memory = policy.predict(observation, memory)
        if step % STEP == 0:
            strengths = np.concatenate([memory[f"{place}/gradients"].norm(dim=-1).numpy() for place in places])
            explored = any(bool(memory[key]) for key in memory if key.endswith("/exploring"))
            state = (1e3 * info["tip"][2], 1e3 * info["distance"], np.degrees(info["angle"]))
            rows.append(
                (step * TASK.time_step, env.picture("outside"), observation["rgb"], strengths, explored, *state)
            )
        observation, _, terminated, _, info = env.step(action)
        if terminated:
            break
    env.close()
    shown = [index for index, (place, label) in enumerate(labels) if place == "x_ee" or "x_ee" not in label]
    times, outside, hand, found, exploring, height, distance, angle = zip(*rows, strict=True)
    return Film(
        times=np.array(times),
        outside=list(outside),
        hand=list(hand),
        labels=tuple(labels[index][1] for index in shown),
        strengths=np.array(found)[:, shown],
        exploring=np.array(exploring),
        height=np.array(height),
        distance=np.array(distance),
        angle=np.array(angle),
        success=bool(info["is_success"]),
    )


def draw(film: Film) -> Iterator[NDArray[np.uint8]]:
    """The pictures of the film."""
    figure = Figure(figsize=(9.6, 6.4), dpi=100)
    views = [figure.add_axes((0.01, 0.44, 0.54, 0.51)), figure.add_axes((0.56, 0.44, 0.43, 0.51))]
    shown = [axes.imshow(pictures[0]) for axes, pictures in zip(views, (film.outside, film.hand), strict=True)]
    for axes, title in zip(views, ("outside", "camera in the hand"), strict=True):
        axes.set_axis_off()
        axes.set_title(title, fontsize=10)
    strengths, errors = figure.add_axes((0.08, 0.23, 0.67, 0.17)), figure.add_axes((0.08, 0.07, 0.67, 0.13))
    for label, colour, values in zip(film.labels, _COLOURS, film.strengths.T, strict=False):
        strengths.semilogy(
            film.times, np.where(values > 0, values, np.nan), ".", color=colour, label=label, markersize=3
        )
    strengths.fill_between(
        film.times, 0, 1, film.exploring, transform=strengths.get_xaxis_transform(), color="0.9", label="exploring"
    )
    strengths.set_ylabel("gradients", fontsize=9)
    strengths.legend(loc="upper left", bbox_to_anchor=(1.01, 1.05), fontsize=7.5, frameon=False)
    for values, name, colour in (
        (film.distance, "distance, mm", "#0072B2"),
        (film.angle, "angle, degrees", "#D55E00"),
        (film.height, "height of the tip, mm", "#009E73"),
    ):
        errors.semilogy(film.times, np.maximum(values, 0.1), color=colour, label=name, linewidth=1.2)
    errors.legend(loc="upper left", bbox_to_anchor=(1.01, 1.05), fontsize=7.5, frameon=False)
    errors.set_xlabel("s", fontsize=9)
    for axes in (strengths, errors):
        axes.set_xlim(0, film.times[-1])
        axes.tick_params(labelsize=8)
    cursors = [axes.axvline(0.0, color="black", linewidth=1.0) for axes in (strengths, errors)]
    for index, time in enumerate(film.times):
        shown[0].set_data(film.outside[index])
        shown[1].set_data(film.hand[index])
        for cursor in cursors:
            cursor.set_xdata([time])
        yield pixels(figure)


def _palette() -> NDArray[np.float64]:
    levels = np.linspace(0, 1, 6)
    grid: NDArray[np.float64] = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)
    return grid
