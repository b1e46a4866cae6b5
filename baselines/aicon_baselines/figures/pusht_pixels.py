"""Pushing by pictures: what is seen, what a network makes of it, and what the filter believes."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray, record, to_array
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.rollout import Rollout, save_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import prepare_timeline
from aicon_baselines.figures.view import PictureView, dot
from aicon_baselines.tasks.pusht import TASK
from aicon_baselines.worlds import Shape, believed, disc, pushing
from aicon_baselines.worlds.paper import Paper
from aicon_envs.pusht import OBJECTS
from aicon_envs.pusht.simulation import PUSHER_RADIUS, SIZE
from aicon_torch import make_policy
from aicon_torch.models.pusht import PIXEL, Options, rigid_object

CONDITION = "pixels_covered"

DEFAULT_SEED = 1007
"""A tuning seed: the object is out of sight again and again while it is pushed."""

UNSURE = 10.0
"""Standard deviation of a coordinate from which on the object counts as not seen, px."""


class SeenRecording(PushRecording):
    """An episode that is seen in pictures."""

    body = rigid_object(Options())

    @property
    def outline(self) -> FloatArray:
        """Corners of the object in its body frame, in order around it, (N, 2), px."""
        outline: FloatArray = OBJECTS["T"].outline
        return outline

    @cached_property
    def truth(self) -> FloatArray:
        """True poses of the centre of mass, (n + 1, 3), px and rad."""
        frames = torch.from_numpy(self.poses * [PIXEL, PIXEL, 1.0])
        return _in_pixels(self.body.pose_of_frame(frames))

    @cached_property
    def seen(self) -> FloatArray:
        """Poses as the network sees them, (n + 1, 3), px and rad."""
        return _in_pixels(self.memory["z_seen"][..., :3])

    @cached_property
    def seen_deviations(self) -> FloatArray:
        """Standard deviations that it tells, (n + 1, 3), px and rad."""
        return _in_pixels((0.5 * self.memory["z_seen"][..., 3:]).exp())

    @cached_property
    def believed(self) -> FloatArray:
        """Poses as the filter believes them, (n + 1, 3), px and rad."""
        return _in_pixels(self.memory["x_pose"])

    @cached_property
    def covariances(self) -> FloatArray:
        """Covariances of the position that it believes, (n + 1, 2, 2), px²."""
        return to_array(self.memory["P_pose"][..., :2, :2]) / PIXEL**2

    def outline_at(self, pose: FloatArray) -> FloatArray:
        """The object's outline at a pose of its centre of mass, (N, 2), px."""
        corners = self.body.keypoints_at(torch.from_numpy(pose * [PIXEL, PIXEL, 1.0]))
        return to_array(corners[list(self.body.outline_order)]) / PIXEL


def _in_pixels(poses: torch.Tensor) -> FloatArray:
    """Poses ``(*B, 3)``, m and rad, in px and rad."""
    return to_array(poses) / [PIXEL, PIXEL, 1.0]


class SeenView(PictureView):
    """The picture that the policy is given, and over it what it makes of it.

    Args:
        axes: Where to draw.
        recording: The episode.
    """

    def __init__(self, axes: Axes, recording: SeenRecording) -> None:
        super().__init__(axes, recording.times, recording.pictures.__getitem__)
        self._recording = recording
        self._image.set(extent=(0, SIZE, SIZE, 0), interpolation="nearest")
        axes.set(xlim=(0, SIZE), ylim=(SIZE, 0))
        self._paper = Paper(axes)

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step."""
        super().show(step)
        recording = self._recording
        seen, spread = recording.seen[step], np.diag(recording.seen_deviations[step, :2] ** 2)
        held, covariance = recording.believed[step], recording.covariances[step]
        true, goal = recording.outline_at(recording.truth[step]), recording.goal
        self._paper.clear()
        self._paper.draw(
            {
                "goal": pushing(recording.outline, goal, goal)["goal.outline"],
                "truth": Shape(true, 3, edge=palette.WHITE, width=1.6),
                "outline": Shape(recording.outline_at(held), 4, edge=palette.BELIEF, width=2.4),
                "pusher": disc(recording.pushers[step], PUSHER_RADIUS, 5, palette.ROBOT),
                "seen": believed(seen[:2], spread, 6, palette.AWAY),
                "believed": believed(held[:2], covariance, 7, palette.BELIEF),
            }
        )


class SeenRollout(Rollout):
    """An episode of pushing by pictures."""

    name = "pusht_pixels"
    aspect = 1.0
    curves = {"off": 1.1, "unsure": 1.1}
    caption = (
        "The pictures that the policy is given, and over them what it makes of them. White: where "
        "the object really is.\nOne episode of aicon/PushT-v0; a third of each picture is "
        "covered, elsewhere at each step."
    )
    arrival = "Arrival in the goal pose"
    recording: SeenRecording

    def doing(self, step: int) -> str:
        """Whether the object is seen, and pushed."""
        recording = self.recording
        is_seen = recording.seen_deviations[step, :2].max() < UNSURE
        doing = "pushed" if recording.touched[step] else "not touched"
        return f"{'In sight' if is_seen else 'Out of sight'}, {doing}"

    def make_view(self, axes: Axes, coarseness: float = 1.0) -> SeenView:
        """The picture and what is made of it."""
        return SeenView(axes, self.recording)

    def draw_curves(self, *diagrams: Axes) -> None:
        """How far network and filter are off, and how far they say that they may be."""
        recording = self.recording
        off = (recording.seen, recording.believed)
        filtered = np.sqrt(recording.covariances.diagonal(axis1=-2, axis2=-1))
        told = (recording.seen_deviations[:, :2], filtered)
        for axes in diagrams:
            prepare_timeline(axes, recording)
            axes.set_yscale("log")

        looks = (("network", palette.AWAY), ("filter", palette.BELIEF))
        for poses, deviations, (name, color) in zip(off, told, looks, strict=True):
            distance = np.linalg.norm((poses - recording.truth)[:, :2], axis=-1)
            spread = np.linalg.norm(deviations, axis=-1)
            diagrams[0].plot(recording.times, distance, color=color, linewidth=1.6, label=name)
            diagrams[1].plot(recording.times, spread, color=color, linewidth=1.6)
        diagrams[0].set_ylabel("off by\n(px)")
        diagrams[1].set_ylabel("standard\ndeviation (px)")
        diagrams[1].set_xlabel("time (s)")

    def marks(self) -> dict[str, Any]:
        """What is seen, and what is believed."""
        return {
            "where the network sees it, 2σ": Patch(facecolor=palette.AWAY, alpha=0.5),
            "where the filter believes it, 2σ": Patch(facecolor=palette.BELIEF, alpha=0.5),
            "its outline there": Line2D([], [], color=palette.BELIEF, linewidth=2.4),
            "goal pose": Patch(facecolor="none", edgecolor=palette.GOAL, linewidth=2),
            "pusher": dot(palette.ROBOT, 10),
        }

    def numbers(self) -> dict[str, Any]:
        """Medians of what network and filter are off by."""
        recording, off = self.recording, {}
        for name, poses in (("network", recording.seen), ("filter", recording.believed)):
            distances = np.linalg.norm((poses - recording.truth)[:, :2], axis=-1)
            off[name] = round(float(np.median(distances)), 2)
        return {"median_off_px": off}


def make_figure(out: Path, seed: int = DEFAULT_SEED, video: str = "mp4") -> FigureSummary:
    """Roll the policy out and save `pusht_pixels.png`, `.json` and, unless "none", the video.

    The arguments and errors are those of :func:`aicon_baselines.figures.nav2d.make_figure`.
    """
    files = FigureFiles(out, SeenRollout.name, video)
    policy = make_policy("pusht", **TASK.policy_options(CONDITION)).compile()
    recording = record(
        SeenRecording,
        policy,
        TASK.make_env(1, CONDITION, 300),
        {"seed": [seed]},
        look=lambda observation: np.array(observation["pixels"][0]),
        beyond=True,
    )
    return save_rollout(SeenRollout(recording), files)
