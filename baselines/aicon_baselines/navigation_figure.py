"""The paper's navigation figure, drawn from a real rollout: how the potential changes while the agent moves.

The agent only ever computes one gradient, the one where it is. The figure asks what it would compute elsewhere: at each
of many positions the library's own sweep runs on the memory that the agent had at that moment.
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

import gymnasium
import numpy as np
import shapely
import torch
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Ellipse, Patch
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter
from numpy.typing import NDArray
from PIL import Image
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import splu
from shapely.geometry.base import BaseGeometry
from torch import Tensor
from tqdm import tqdm

from aicon_baselines.errors import ComparisonError
from aicon_envs.navigation import NavigationMap, shortest_path_length
from aicon_torch import make_policy
from aicon_torch.policy import ACTIVE, Policy
from aicon_torch.resolution import Memory

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
OnStep = Callable[[], object]

PATHS = {"p1": ("reach", "p_tar"), "p2": ("reach", "P_tar"), "p3": ("avoid", "x_obs")}
"""The paper's paths: each gradient at x_rob by its trace."""

VIDEOS = ("mp4", "gif", "none")

_MEETING = "x_rob"
_NEAREST_BELIEF = 0.1  # m; the agent keeps its target estimate at least this far away
_VIDEO_SECONDS = 22.0
_MARGIN = 0.45  # m of free space around what is shown

# Colours that colour-blind readers can tell apart (after Okabe and Ito, "Color Universal Design", 2008).
_AGENT, _TARGET, _BELIEF, _OBSTACLE, _EXPLORING = "#0059a8", "#c4122f", "#e08a00", "#3c4048", "#a3569b"
_ARROW = "#23454f"
_MARKS = (_AGENT, _TARGET, _BELIEF, _OBSTACLE, _EXPLORING, _ARROW)
_TINT, _STRIP_TINT = 0.24, 0.16  # opacity of what says "exploring", in the world and over time
_HEIGHT = LinearSegmentedColormap.from_list(
    "height", ["#fdfcf5", "#dfeae2", "#b5d2cb", "#86b3b1", "#5b8f96", "#3f6d7a"]
)


@dataclass(frozen=True)
class Recording:
    """A rollout with everything that the policy knew.

    Attributes:
        name: Class of the map.
        seed: Seed of the map and of the noise.
        world: The map.
        radius: Radius of the agent, m.
        policy: The policy.
        memories: The memory after each of the n steps.
        positions: True positions, (n + 1, 2), m; `memories[k]` was computed at `positions[k]`.
        ending: How the episode ended.
    """

    name: str
    seed: int
    world: NavigationMap
    radius: float
    policy: Policy
    memories: list[Memory]
    positions: FloatArray
    ending: Literal["arrival", "collision", "time limit"]

    @property
    def steps(self) -> int:
        """Number of steps n."""
        return len(self.memories)

    @cached_property
    def times(self) -> FloatArray:
        """When each step was decided, (n,), s."""
        return np.arange(self.steps, dtype=np.float64) * self.policy.model.dt

    @cached_property
    def strengths(self) -> dict[str, FloatArray]:
        """Norm of the gradient of each path at x_rob, (n,) each."""
        traces = [arrival.trace for arrival in self.policy.sweep.arrivals[_MEETING]]
        norms = self._series(f"{_MEETING}/gradients", lambda gradients: torch.linalg.vector_norm(gradients, dim=-1))
        return {name: norms[:, traces.index(trace)] for name, trace in PATHS.items()}

    @cached_property
    def uncertainty(self) -> FloatArray:
        """Trace of the target's covariance, (n,), m²."""
        return self._series("P_tar", torch.trace)

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether each step explored, (n,)."""
        return np.array([bool(memory.get(f"{_MEETING}/exploring", False)) for memory in self.memories])

    @cached_property
    def spans(self) -> list[tuple[int, int]]:
        """First step of each exploration and the first one after it."""
        edges = np.flatnonzero(np.diff(np.concatenate([[False], self.exploring, [False]]).astype(np.int8)))
        return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]

    @cached_property
    def travelled(self) -> FloatArray:
        """Length of the way to each position, (n + 1,), m."""
        pieces = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(pieces)])

    def belief(self, step: int) -> tuple[FloatArray, FloatArray]:
        """Mean (2,), m, and covariance (2, 2), m², of where the target is believed to be, in the world's frame.

        The agent believes it relative to itself; the figure adds the true position.
        """
        memory = self.memories[step]
        mean: FloatArray = self.positions[step] + memory["p_tar"].numpy(force=True)
        return mean, memory["P_tar"].numpy(force=True).astype(np.float64)

    def _series(self, key: str, reduce: Callable[[Tensor], Tensor]) -> FloatArray:
        return np.array([reduce(memory[key]).numpy(force=True) for memory in self.memories], dtype=np.float64)


def record(policy: Policy, name: str, seed: int, on_step: OnStep = lambda: None, limit: int | None = None) -> Recording:
    """Run an episode of aicon/Nav2D-v0 and keep the memory of every step.

    Args:
        policy: A navigation policy.
        name: Class of the map.
        seed: Seed of the map and of the noise.
        on_step: Called after every step.
        limit: Limit of the episode, steps; by default the environment's.

    Raises:
        ComparisonError: If the class of maps is unknown; it lists the valid ones.
    """
    try:
        env = gymnasium.make("aicon/Nav2D-v0", map=name, max_episode_steps=limit)
    except ValueError as error:
        raise ComparisonError(str(error)) from error
    observation, info = env.reset(seed=seed, options={"map": name, "map_seed": seed})
    memory: Memory | None = None
    memories: list[Memory] = []
    positions = [info["position"]]
    terminated = truncated = False
    while not (terminated or truncated):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        memories.append(memory)
        positions.append(info["position"])
        on_step()
    base: Any = env.unwrapped
    ending: Any = "arrival" if info["is_success"] else "collision" if info["collision"] else "time limit"
    recording = Recording(name, seed, base.map, base.physics.radius, policy, memories, np.array(positions), ending)
    env.close()
    return recording


class Field(NamedTuple):
    """What the agent would do at N positions.

    Attributes:
        descent: −∇ after the resolution at x_rob, (N, 2): where it would go, and how strongly.
        exploring: Whether it would explore there, (N,).
    """

    descent: FloatArray
    exploring: BoolArray


def sample(
    recording: Recording, step: int, points: FloatArray, obstacle: Literal["true", "remembered"] = "true"
) -> Field:
    """The resolved gradient that the agent would compute at other positions, there and then.

    All positions are one batch through the policy's own tapes and sweep, from the memory before the step: covariances,
    ranks, motion average and the exploration that goes on are those of that moment. Two things depend on the position
    y: the target estimate becomes (where the agent believes the target) − y, and the obstacle estimate (d, ∇d) becomes
    the *true* clearance at y and its slope. The agent cannot know the latter away from where it is: only this figure
    looks it up in the map.

    Args:
        recording: The rollout.
        step: Which step, 1 or later.
        points: The positions, (N, 2), m, outside the obstacles.
        obstacle: With "remembered" the agent's own obstacle estimate is used everywhere; at the agent's position this
            is the gradient that it followed.
    """
    policy, model = recording.policy, recording.policy.model
    if not 1 <= step < recording.steps:
        raise ValueError(f"step={step!r}: expected 1 to {recording.steps - 1}; the first step has no memory before it.")
    before = _spread(recording.memories[step - 1], len(points))
    now = _spread(recording.memories[step], len(points))
    values = {name: now[name] for name in model.quantities} | {name: before[name] for name in model.actuators}
    values["p_tar"] = _at_least(model.like.new_tensor(recording.belief(step)[0] - points), _NEAREST_BELIEF)
    if obstacle == "true":
        values["x_obs"] = model.like.new_tensor(clearance(recording.world, recording.radius, points))
    with torch.enable_grad():
        tapes = model.record(values)
    gradients, meetings = policy.sweep(tapes, values, before, before[ACTIVE])
    (gradient,) = gradients.values()
    nowhere = torch.zeros(len(points), dtype=torch.bool)
    exploring = meetings.get(f"{_MEETING}/exploring", nowhere).numpy(force=True)
    return Field(-gradient.numpy(force=True).astype(np.float64) / model.dt, exploring)  # x_rob = a dt


def clearance(world: NavigationMap, radius: float, points: FloatArray) -> FloatArray:
    """The true (d, ∇d) at positions (N, 2) outside the obstacles, (N, 3), m."""
    solid = _solid(world)
    if solid.is_empty:
        return np.tile([1e3, 0.0, 0.0], (len(points), 1))
    away: FloatArray = np.diff(
        shapely.get_coordinates(shapely.shortest_line(solid, shapely.points(points))).reshape(-1, 2, 2), axis=1
    )[:, 0]
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    return np.concatenate([distance - radius, away / np.maximum(distance, 1e-12)], axis=1)


def _solid(world: NavigationMap) -> BaseGeometry:
    return shapely.union_all([shapely.Polygon(vertices) for vertices in world.obstacles])


def _spread(memory: Mapping[str, Tensor], count: int) -> Memory:
    """The memory of one agent as that of a batch of them."""
    return {key: value.expand(count, *value.shape) for key, value in memory.items()}


def _at_least(vector: Tensor, length: float) -> Tensor:
    norm = torch.linalg.vector_norm(vector, dim=-1, keepdim=True)
    longer: Tensor = vector * (norm.clamp(min=length) / norm.clamp(min=1e-9))
    return longer


class Grid:
    """A rectangular grid over the free space, and the potential that fits a descent field on it best.

    Args:
        world: The map.
        low: Lower left corner (x, y), m.
        high: Upper right corner, m.
        spacing: Distance of neighbours, m.

    Attributes:
        shape: Rows and columns.
        extent: left, right, bottom, top of the picture made of one cell a point, m.
        points: The free points, (N, 2), m.
        free: Which points of the grid lie outside the obstacles, `shape`.
        nearest_free: Row and column of the nearest free point of each point, `shape` each.
    """

    def __init__(self, world: NavigationMap, low: FloatArray, high: FloatArray, spacing: float) -> None:
        self._spacing = spacing
        columns, rows = (np.arange(a, b + spacing / 2, spacing) for a, b in zip(low, high, strict=True))
        self.shape = (len(rows), len(columns))
        half = spacing / 2
        self.extent = (columns[0] - half, columns[-1] + half, rows[0] - half, rows[-1] + half)
        every = np.stack(np.meshgrid(columns, rows), axis=-1)
        self.free: BoolArray = ~shapely.contains_xy(_solid(world), every[..., 0], every[..., 1])
        self.points: FloatArray = every[self.free]
        index = np.full(self.shape, -1)
        index[self.free] = np.arange(len(self.points))
        pairs = [(index[:, :-1], index[:, 1:]), (index[:-1], index[1:])]
        joined = [np.stack([a.ravel(), b.ravel()])[:, ((a >= 0) & (b >= 0)).ravel()] for a, b in pairs]
        self._first, self._second = np.concatenate(joined, axis=1)
        self._axis = np.repeat([0, 1], [j.shape[1] for j in joined])
        links = np.arange(len(self._axis))
        ones = np.ones(len(links))
        self.nearest_free = tuple(distance_transform_edt(~self.free, return_distances=False, return_indices=True))
        entries = (np.concatenate([ones, -ones]), (np.tile(links, 2), np.concatenate([self._second, self._first])))
        self._difference = sparse.csr_array(entries, shape=(len(links), len(self.points)))
        laplacian = self._difference.T @ self._difference
        self._solver = splu((laplacian + 1e-9 * sparse.eye_array(len(self.points))).tocsc())  # fixes the free constant

    def potential(self, descent: FloatArray) -> FloatArray:
        """The heights φ whose slopes fit the field best: min Σ (φⱼ − φᵢ + h (fᵢ + fⱼ)/2)² over neighbours i, j.

        A field that turns about is no potential's; what turns is left out of the fit.

        Args:
            descent: f = −∇, (N, 2).

        Returns:
            φ as an array of the grid's shape, NaN in obstacles, from 0.
        """
        along = descent[self._first, self._axis] + descent[self._second, self._axis]
        heights = self._solver.solve(self._difference.T @ (-0.5 * self._spacing * along))
        return self.fill(heights - heights.min())

    def fill(self, values: FloatArray) -> FloatArray:
        """Values at the free points as an array of the grid's shape, NaN elsewhere."""
        whole = np.full(self.shape, np.nan)
        whole[self.free] = values
        return whole


class Panel(NamedTuple):
    """One moment of the rollout and what happens there, in plain words."""

    step: int
    title: str


def choose_panels(recording: Recording) -> list[Panel]:
    """Six moments, in order of time.

    (a) The uncertainty's path is the strongest for the last time; (b) the longest exploration begins; (c)-(e) from
    there to the end of the last exploration, a quarter of the way apart, one of them moved to the sharpest turn; (f)
    the end. Without exploration (b)-(e) are a fifth of the way apart.

    Raises:
        ComparisonError: If the rollout is too short for six panels.
    """
    last = recording.steps - 1
    if last < 6:
        raise ComparisonError(f"the rollout has {recording.steps} steps; six panels need 7 or more")
    if recording.spans:
        begin, _ = max(recording.spans, key=lambda span: span[1] - span[0])
        end = recording.spans[-1][1]
        marks = [begin, *_along(recording, begin, end, (0.25, 0.5, 0.75))]
        corner = _sharpest_turn(recording, begin, end)
        turned = min((1, 2, 3), key=lambda index: abs(recording.travelled[marks[index]] - recording.travelled[corner]))
        marks[turned] = corner
        titles = ["Conflict: the wall is in the way", *["Exploring along the wall"] * 3]
        titles[turned] = "Rounding a corner"
    else:
        marks = _along(recording, 0, last, (0.2, 0.4, 0.6, 0.8))
        titles = ["On the way"] * 4
    triangulating = _end_of_triangulation(recording, marks[0])
    endings = {"arrival": "Arrival at the target", "collision": "Collision", "time limit": "Out of time"}
    steps = [triangulating, *marks, last]
    for index, step in enumerate(steps):  # in order, whatever the rollout
        steps[index] = min(max(step, steps[index - 1] + 1 if index else 1), last - (len(steps) - 1 - index))
    named = ["Triangulating: sideways first", *titles, endings[recording.ending]]
    return [Panel(step, title) for step, title in zip(steps, named, strict=True)]


def _along(recording: Recording, begin: int, end: int, shares: Sequence[float]) -> list[int]:
    """The steps at shares of the way from one step to another."""
    way = recording.travelled
    return [int(np.searchsorted(way, way[begin] + share * (way[end] - way[begin]))) for share in shares]


def _sharpest_turn(recording: Recording, begin: int, end: int, reach: float = 0.7) -> int:
    """The step between two others where the way bends most, seen from `reach` m before to `reach` m after."""
    way, positions = recording.travelled, recording.positions
    inner = np.arange(begin, end)[(way[begin:end] > way[begin] + reach) & (way[begin:end] < way[end] - reach)]
    if not len(inner):
        return (begin + end) // 2
    behind = positions[inner] - positions[np.searchsorted(way, way[inner] - reach)]
    ahead = positions[np.minimum(np.searchsorted(way, way[inner] + reach), len(way) - 1)] - positions[inner]
    straight = (behind * ahead).sum(axis=1) / (np.linalg.norm(behind, axis=1) * np.linalg.norm(ahead, axis=1))
    return int(inner[np.argmin(straight)])


def _end_of_triangulation(recording: Recording, before: int) -> int:
    """The last step, in the first half before another, at which p₂ is the strongest, or else has its largest share."""
    early = slice(1, max(2, before // 2))
    stack = np.stack([recording.strengths[name][early] for name in ("p2", "p1", "p3")])
    strongest = np.flatnonzero(stack.argmax(axis=0) == 0)
    return 1 + int(strongest[-1] if len(strongest) else np.argmax(stack[0] / stack.sum(axis=0)))


def summary(recording: Recording, panels: Sequence[Panel]) -> dict[str, Any]:
    """The numbers of the figure."""
    dt = recording.policy.model.dt
    after = {f"{seconds:g}": round(seconds / dt) for seconds in (0.0, 1.0, 5.0)}
    world = recording.world
    return {
        "map": recording.name,
        "seed": recording.seed,
        "ending": recording.ending,
        "steps": recording.steps,
        "duration_s": round(recording.steps * dt, 3),
        "path_length_m": round(float(recording.travelled[-1]), 3),
        "shortest_path_m": round(shortest_path_length(world.obstacles, world.start, world.target, recording.radius), 3),
        "panels": [
            {"panel": letter, "time_s": round(panel.step * dt, 3), "title": panel.title}
            for letter, panel in zip("abcdef", panels, strict=True)
        ],
        "explorations_s": [[round(first * dt, 3), round(last * dt, 3)] for first, last in recording.spans],
        "trace_sigma_m2": {
            f"{seconds} s": float(recording.uncertainty[step])
            for seconds, step in after.items()
            if step < recording.steps
        },
    }


def draw_rollout(
    recording: Recording, panels: Sequence[Panel], path: Path, spacing: float = 0.04, on_step: OnStep = lambda: None
) -> None:
    """Save the figure: six panels of the evolving potential, and the strengths of the paths over time.

    Args:
        recording: The rollout.
        panels: The moments to show.
        path: Where to save the picture.
        spacing: Distance of the sampled positions, m.
        on_step: Called after every panel.
    """
    figure = Figure(figsize=(14, 8), dpi=150)
    canvas = FigureCanvasAgg(figure)
    panels_at = {"left": 0.012, "right": 0.988, "top": 0.928, "bottom": 0.333, "hspace": 0.115, "wspace": 0.025}
    cells = figure.add_gridspec(2, 3, **panels_at)
    low, high = frame(recording, aspect=1.95)
    grid = Grid(recording.world, low, high, spacing)
    for index, (letter, panel) in enumerate(zip("abcdef", panels, strict=True)):
        view = View(figure.add_subplot(cells[index // 3, index % 3]), recording, grid)
        view.show(panel.step)
        view.outline()
        view.axes.set_title(rf"$\mathbf{{{letter}}}$   {panel.title}", loc="left", fontsize=11, pad=4)
        view.axes.set_title(f"{recording.times[panel.step]:.1f} s", loc="right", fontsize=10, color="0.35", pad=4)
        on_step()
    strip = figure.add_axes((0.062, 0.118, 0.926, 0.147))
    draw_strengths(strip, recording)
    strip.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.1), ncols=5, frameon=False, fontsize=10, columnspacing=1.8)
    for letter, panel in zip("abcdef", panels, strict=True):
        strip.axvline(recording.times[panel.step], color="0.25", linewidth=0.8, linestyle=(0, (2, 2)))
        strip.annotate(
            letter,
            (recording.times[panel.step], 1.0),
            (0, 2),
            ("data", "axes fraction"),
            textcoords="offset points",
            ha="center",
            fontsize=10,
            fontweight="bold",
        )
    figure.legend(**_legend(), loc="upper center", bbox_to_anchor=(0.5, 1.004), ncols=7, frameon=False, fontsize=10)
    figure.text(0.012, 0.012, _CAPTION, fontsize=8.5, color="0.3", linespacing=1.35)
    fourths = np.minimum((_pixels(canvas).astype(np.uint16) + 2) // 4 * 4, 255)  # looks the same and is 30 % smaller
    Image.fromarray(fourths.astype(np.uint8)).save(path, optimize=True)


def _pixels(canvas: Any) -> NDArray[np.uint8]:
    """The picture on an Agg canvas (matplotlib leaves its methods untyped), (height, width, 3)."""
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


_CAPTION = (
    "Arrows: direction of the resolved descent, sampled densely with the agent's memory of that moment; the clearance "
    "at other positions is the true one. Background: the potential whose slope fits\n"
    "these samples best (least squares). The agent itself computes only the gradient at its own position. "
    "One rollout of aicon/Nav2D-v0 with its noise."
)


def draw_video(recording: Recording, path: Path, spacing: float = 0.06, on_step: OnStep = lambda: None) -> None:
    """Save the rollout as a video, mp4 or gif by the name of the file; long ones skip steps to last 22 s at most.

    Args:
        recording: The rollout.
        path: Where to save the video.
        spacing: Distance of the sampled positions, m.
        on_step: Called after every picture; there are `len(video_steps(recording, path))`.

    Raises:
        ComparisonError: If imageio is not installed and the video is no gif.
    """
    pictures = _pictures(recording, path, spacing, on_step)
    rate = _rate(path)
    if path.suffix == ".gif":
        palette = _palette()
        first, *others = (
            Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
        )
        first.save(path, save_all=True, append_images=others, duration=1000 // rate, loop=0)
        return
    try:
        import imageio.v2 as imageio  # an extra: the picture and the gif do without
    except ImportError as error:
        raise ComparisonError("mp4 needs imageio[ffmpeg]; install it or choose --video gif") from error
    writer: Any
    with imageio.get_writer(path, fps=rate, quality=6) as writer:
        for picture in pictures:
            writer.append_data(picture)


def _pictures(recording: Recording, path: Path, spacing: float, on_step: OnStep) -> Iterator[NDArray[np.uint8]]:
    """The pictures of a video, (height, width, 3); the last one rests for a second."""
    figure = Figure(figsize=(8, 5.28), dpi=60 if path.suffix == ".gif" else 100)
    canvas = FigureCanvasAgg(figure)
    low, high = frame(recording, aspect=1.95)
    view = View(figure.add_axes((0.015, 0.225, 0.97, 0.715)), recording, Grid(recording.world, low, high, spacing))
    strip = figure.add_axes((0.04, 0.035, 0.92, 0.12))
    draw_strengths(strip, recording)
    strip.set(yticks=[], xticks=[], xlabel="", ylabel="")
    strip.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.93), ncols=5, frameon=False, fontsize=8, columnspacing=1.4)
    cursor = strip.axvline(0.0, color=_AGENT, linewidth=1.4)
    for step in video_steps(recording, path):
        view.show(step)
        view.axes.set_title(_phase(recording, step), loc="left", fontsize=10, pad=4)
        view.axes.set_title(f"{recording.times[step]:.1f} s", loc="right", fontsize=10, color="0.35", pad=4)
        cursor.set_xdata([recording.times[step]])
        picture = _pixels(canvas)
        yield picture
        on_step()
    for _ in range(_rate(path)):
        yield picture


def _palette() -> Image.Image:
    """The colours of a gif: the heights, tinted ones where it would explore, and the marks with their soft edges."""
    heights = _HEIGHT(np.linspace(0, 1, 40))[:, :3]
    tint, marks = np.array(to_rgb(_EXPLORING)), np.array([to_rgb(mark) for mark in (*_MARKS, "black")])
    soft = [
        share * marks + (1 - share) * np.array(ground) for share in (1.0, 0.5) for ground in ((1, 1, 1), heights[20])
    ]
    pale = (1 - share * (1 - tint) for share in (0.0, _STRIP_TINT))
    colours = np.concatenate([heights, (1 - _TINT) * heights + _TINT * tint, *soft, list(pale)])
    image = Image.new("P", (1, 1))
    image.putpalette((255 * colours).round().astype(np.uint8).tobytes())
    return image


def video_steps(recording: Recording, path: Path) -> range:
    """The steps that a video shows."""
    return range(1, recording.steps, max(1, math.ceil(recording.steps / (_VIDEO_SECONDS * _rate(path)))))


def _rate(path: Path) -> int:
    """Pictures per second; a gif stores every picture almost in full."""
    return 5 if path.suffix == ".gif" else 15


def _phase(recording: Recording, step: int) -> str:
    """What the agent does, in plain words."""
    if recording.exploring[step]:
        return "Conflict: exploring along the obstacle"
    strongest = max(PATHS, key=lambda name: recording.strengths[name][step])
    return {"p1": "Approaching the target", "p2": "Triangulating", "p3": "Keeping clear"}[strongest]


def frame(recording: Recording, aspect: float) -> tuple[FloatArray, FloatArray]:
    """Corners of the smallest rectangle of an aspect that shows the way, the target and the obstacles, m."""
    world = recording.world
    points = np.array(
        [*recording.positions, world.target, *(vertex for polygon in world.obstacles for vertex in polygon)]
    )
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    width, height = high - low
    size = np.array([max(width, aspect * height), max(height, width / aspect)])
    centre = (low + high) / 2
    return centre - size / 2, centre + size / 2


class View:
    """The world at one step, which can be brought to another step.

    Args:
        axes: Where to draw.
        recording: The rollout.
        grid: Where to sample.
    """

    def __init__(self, axes: Axes, recording: Recording, grid: Grid) -> None:
        self.axes, self._recording, self._grid = axes, recording, grid
        left, right, bottom, top = grid.extent
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_color("0.6")
        self._image = axes.imshow(
            np.zeros(grid.shape), cmap=_HEIGHT, extent=grid.extent, origin="lower", interpolation="bilinear", zorder=0
        )
        tint = LinearSegmentedColormap.from_list("tint", [to_rgba(_EXPLORING, 0.0), to_rgba(_EXPLORING, _TINT)])
        self._tint = axes.imshow(
            np.zeros(grid.shape),
            cmap=tint,
            extent=grid.extent,
            origin="lower",
            vmin=0,
            vmax=1,
            interpolation="bilinear",
            zorder=1,
        )
        self._exploring = np.zeros(grid.shape)
        for polygon in _polygons(recording.world):
            axes.fill(*polygon.T, facecolor=_OBSTACLE, edgecolor=_OBSTACLE, linewidth=1.0, zorder=3)
        self._arrow_points = _arrow_points(recording, grid)
        none = np.zeros(len(self._arrow_points))
        self._quiver = axes.quiver(
            *self._arrow_points.T,
            none,
            none,
            pivot="middle",
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.0022,
            headwidth=4.2,
            headlength=4.6,
            headaxislength=4.0,
            color=_ARROW,
            zorder=2,
        )
        (self._way,) = axes.plot([], [], color="white", linewidth=4.2, solid_capstyle="round", zorder=4)
        (self._trail,) = axes.plot([], [], color=_AGENT, linewidth=2.2, solid_capstyle="round", zorder=5)
        self._belief = Ellipse(
            (0, 0), 1, 1, facecolor=to_rgba(_BELIEF, 0.13), edgecolor=_BELIEF, linewidth=1.8, zorder=6
        )
        axes.add_patch(self._belief)
        axes.plot(*recording.world.target, **_TARGET_MARK, zorder=7)
        (self._mean,) = axes.plot([], [], **_MEAN_MARK, zorder=8)
        self._agent = Circle((0, 0), recording.radius, facecolor=_AGENT, edgecolor="white", linewidth=1.2, zorder=9)
        axes.add_patch(self._agent)

    def show(self, step: int) -> None:
        """Bring the picture to a step, 1 or later."""
        recording = self._recording
        position = recording.positions[step]
        free = len(self._grid.points)
        field = sample(recording, step, np.concatenate([self._grid.points, self._arrow_points]))
        heights = self._grid.potential(field.descent[:free])
        self._image.set_data(heights[self._grid.nearest_free])
        self._image.set_clim(*np.nanpercentile(heights, (0.5, 99.5)))
        self._exploring = np.nan_to_num(self._grid.fill(field.exploring[:free].astype(np.float64)))
        self._tint.set_data(self._exploring)
        arrows = field.descent[free:]
        length = 0.72 * _arrow_spacing(self._grid)
        arrows = length * arrows / np.maximum(np.linalg.norm(arrows, axis=1, keepdims=True), 1e-9)
        self._quiver.set_UVC(*arrows.T)
        for line in (self._way, self._trail):
            line.set_data(*recording.positions[: step + 1].T)
        mean, covariance = recording.belief(step)
        variances, directions = np.linalg.eigh(covariance)
        self._belief.set_center((float(mean[0]), float(mean[1])))
        self._belief.set_width(4 * math.sqrt(variances[1]))  # from −2σ to 2σ
        self._belief.set_height(4 * math.sqrt(variances[0]))
        self._belief.set_angle(math.degrees(math.atan2(directions[1, 1], directions[0, 1])))
        self._mean.set_data([mean[0]], [mean[1]])
        self._agent.set_center((float(position[0]), float(position[1])))

    def outline(self) -> None:
        """Add the outline of where the agent would explore, which stays when the step changes."""
        if self._exploring.any():
            self.axes.contour(
                self._exploring, [0.5], extent=self._grid.extent, colors=_EXPLORING, linewidths=0.9, zorder=1
            )


def _polygons(world: NavigationMap) -> list[FloatArray]:
    """The obstacles' vertices, (n, 2) each, m."""
    return [np.array(vertices) for vertices in world.obstacles]


def _arrow_spacing(grid: Grid) -> float:
    left, right, _, _ = grid.extent
    return float(right - left) / 27


def _arrow_points(recording: Recording, grid: Grid) -> FloatArray:
    """Positions of the arrows: a coarse grid, clear of the obstacles."""
    left, right, bottom, top = grid.extent
    spacing = _arrow_spacing(grid)
    axes = [
        (np.arange(round((b - a) / spacing)) + 0.5) * (b - a) / round((b - a) / spacing) + a
        for a, b in ((left, right), (bottom, top))
    ]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    solid = _solid(recording.world)
    inside = shapely.contains_xy(solid, points[:, 0], points[:, 1])
    points = points[~inside]
    clear: FloatArray = points[clearance(recording.world, recording.radius, points)[:, 0] > -0.5 * recording.radius]
    return clear


def draw_strengths(axes: Axes, recording: Recording) -> None:
    """Draw the strength of each path and the uncertainty over time."""
    for first, last in recording.spans:
        axes.axvspan(
            recording.times[first], recording.policy.model.dt * last, color=_EXPLORING, alpha=_STRIP_TINT, linewidth=0
        )
    times = recording.times
    axes.fill_between([], [], color=_EXPLORING, alpha=_STRIP_TINT, linewidth=0, label="exploring")
    for name, style in _LINES.items():
        series = recording.uncertainty if name == "sigma" else recording.strengths[name]
        axes.plot(times, series, **style)
    axes.set(yscale="log", ylim=(2e-3, 60), xlim=(0, times[-1]), xlabel="time (s)")
    axes.set_ylabel("path strength,\nuncertainty (m²)")
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


_TARGET_MARK: dict[str, Any] = {
    "marker": "*",
    "markersize": 17,
    "markerfacecolor": _TARGET,
    "markeredgecolor": "white",
    "markeredgewidth": 1.0,
    "linestyle": "none",
}
_MEAN_MARK: dict[str, Any] = {
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": _BELIEF,
    "markeredgecolor": "white",
    "markeredgewidth": 0.9,
    "linestyle": "none",
}
_LINES: dict[str, dict[str, Any]] = {
    "p1": {"color": _TARGET, "linewidth": 1.8, "label": "p₁ nearer to the target"},
    "p2": {"color": _BELIEF, "linewidth": 1.4, "label": "p₂ less uncertainty"},
    "p3": {"color": _OBSTACLE, "linewidth": 1.4, "label": "p₃ clear of obstacles"},
    "sigma": {"color": _BELIEF, "linewidth": 1.8, "linestyle": (0, (4, 1.5)), "label": "uncertainty tr Σ"},
}


def _legend() -> dict[str, Any]:
    """Handles and labels of what the panels show."""
    trail = Line2D([], [], color=_AGENT, linewidth=2.2)
    agent = Line2D([], [], color=_AGENT, marker="o", markersize=8, markeredgecolor="white", linestyle="none")
    ellipse = Line2D(
        [], [], color=_BELIEF, marker="o", markersize=13, markerfacecolor=to_rgba(_BELIEF, 0.15), linestyle="none"
    )
    entries: list[tuple[Any, str]] = [
        ((trail, agent), "agent and its way"),
        (Line2D([], [], **_TARGET_MARK), "target"),
        ((ellipse, Line2D([], [], **_MEAN_MARK)), "believed target (2σ)"),
        (Patch(color=_OBSTACLE), "obstacle"),
        (Patch(facecolor=to_rgba(_EXPLORING, _TINT), edgecolor=_EXPLORING), "where it would explore"),
        (Patch(facecolor=_HEIGHT(0.85)), "potential high"),
        (Patch(facecolor=_HEIGHT(0.05), edgecolor="0.7"), "potential low"),
    ]
    return {
        "handles": [handle for handle, _ in entries],
        "labels": [label for _, label in entries],
        "handler_map": {tuple: HandlerTuple(ndivide=1)},
    }


def make_figure(
    name: str, seed: int, out: Path, video: str = "mp4", *, spacing: float = 0.04, progress: bool = True
) -> dict[str, Any]:
    """Roll the policy out and save `nav2d_rollout.png`, `.json` and, unless it is "none", the video.

    Args:
        name: Class of the map.
        seed: Seed of the map and of the noise.
        out: Folder, made if it does not exist.
        video: One of `VIDEOS`.
        spacing: Distance of the sampled positions in the picture, m; the video's are 1.5 times as far apart.
        progress: Whether to show a progress bar, on a terminal only.

    Returns:
        The numbers that the JSON file holds.
    """
    if video not in VIDEOS:
        raise ComparisonError(f"unknown video {video!r}; valid: {', '.join(VIDEOS)}")
    out.mkdir(parents=True, exist_ok=True)
    path = out / "nav2d_rollout.png"
    with tqdm(unit="step", desc="rollout", disable=None if progress else True) as bar:
        recording = record(make_policy("nav2d"), name, seed, bar.update)
        panels = choose_panels(recording)
        numbers = summary(recording, panels)
        path.with_suffix(".json").write_text(json.dumps(numbers, indent=2) + "\n")
        bar.reset(len(panels))
        bar.set_description("picture")
        draw_rollout(recording, panels, path, spacing, bar.update)
        if video != "none":
            moving = path.with_suffix(f".{video}")
            bar.reset(len(video_steps(recording, moving)))
            bar.set_description("video")
            draw_video(recording, moving, 1.5 * spacing, bar.update)
    return numbers
