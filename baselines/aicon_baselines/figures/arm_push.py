"""The arm's figure: from outside and from the hand, above its gradients and its errors."""

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from PIL import Image

from aicon_baselines.evaluation.recording import FloatArray, Recording, record, to_array
from aicon_baselines.figures.rendering import Frame
from aicon_baselines.figures.rollout import Rollout, save_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import gaps_at_zero, prepare_timeline
from aicon_baselines.figures.view import PictureView
from aicon_baselines.palette import ANGLE, DISTANCE, GOALS, INK
from aicon_baselines.tasks.arm_push import TASK
from aicon_envs.arm_push import ArmPushEnv
from aicon_torch import Policy, make_policy

STRIDE = 10
"""Control steps from frame to frame: ten frames a second, in real time."""

_END_EFFECTOR = "x_ee"


class ArmRecording(Recording):
    """An episode with m frames, each of the scene from outside and of the camera in the hand."""

    def side_by_side(self, step: int) -> Frame:
        """The scene from outside, and the camera in the hand as the policy sees it, as large."""
        outside, hand = self.pictures[step]
        height, width, _ = outside.shape
        return np.hstack([outside, np.asarray(Image.fromarray(hand).resize((width, height)))])

    @cached_property
    def height(self) -> FloatArray:
        """Height of the tip, (m,), mm."""
        return 1e3 * self.told("tip")[:-1, 2]

    @cached_property
    def distance(self) -> FloatArray:
        """Distance to the target, (m,), mm."""
        return 1e3 * self.told("distance")[:-1]

    @cached_property
    def angle(self) -> FloatArray:
        """Angle to the target, (m,), degrees."""
        return np.degrees(self.told("angle")[:-1])

    @cached_property
    def strengths(self) -> dict[str, FloatArray]:
        """Strength of each gradient by the names that it came through, (m,) each."""
        strengths: dict[str, FloatArray] = {}
        for place in (_END_EFFECTOR, "x_joints"):
            arrived = self.trace.quantities[place]
            columns = to_array(arrived.magnitudes).T

            for path, values in zip(arrived.paths, columns, strict=True):
                came_through = path[:-1]
                if _END_EFFECTOR not in came_through:  # what came through it is shown already
                    strengths[" → ".join(came_through)] = values
        return strengths


class ArmRollout(Rollout):
    """An episode of the arm, with a step every tenth of a second."""

    name = "arm_push_film"
    aspect = 8 / 3
    curves = {"gradients": 1.3, "errors": 1.0}
    legend_rows = 3
    caption = (
        "Left: from outside, where the green shape is the target. Right: the camera in the hand, "
        "by which the policy sees the object. Gradients: the strengths of those that meet at the "
        "tip and at\nthe joints, by the quantities that they came through. One episode of "
        "aicon/ArmPush-v0."
    )
    recording: ArmRecording

    def doing(self, step: int) -> str:
        """What the tip does, or for which goals it moves."""
        if self.recording.exploring[step]:
            return "Conflict: exploring"

        met = self.recording.trace.quantities["x_ee"]
        return f"Descending: {', '.join(met.goals[int(met.dominant[step])])}"

    def make_view(self, axes: Axes, coarseness: float = 1.0) -> PictureView:
        """Both pictures, side by side."""
        return PictureView(axes, self.recording.times, self.recording.side_by_side)

    def draw_curves(self, *diagrams: Axes) -> None:
        """The strength of each gradient; the errors and the height of the tip."""
        strengths, errors = diagrams
        for axes in diagrams:
            prepare_timeline(axes, self.recording)
            axes.set(yscale="log")

        times = self.recording.times
        for (label, values), color in zip(self.recording.strengths.items(), GOALS, strict=False):
            shown = gaps_at_zero(values)
            strengths.plot(times, shown, ".", color=color, label=label, markersize=3)
        strengths.set_ylabel("strength")

        curves = (
            ("distance, mm", DISTANCE, self.recording.distance),
            ("angle, degrees", ANGLE, self.recording.angle),
            ("height of the tip, mm", INK, self.recording.height),
        )
        for label, color, values in curves:
            errors.plot(times, np.maximum(values, 0.1), color=color, label=label, linewidth=1.4)
        errors.set(xlabel="time (s)", ylabel="errors")

    def numbers(self) -> dict[str, Any]:
        """The errors in the end."""
        distance, angle = self.recording.distance[-1], self.recording.angle[-1]
        return {"distance_mm": round(float(distance), 2), "angle_deg": round(float(angle), 2)}


def make_figure(
    out: Path, seed: int = 1000, video: str = "mp4", *, horizon: int = 6_000
) -> FigureSummary:
    """Run an episode and save `arm_push_film.png`, `.json` and, unless "none", the video.

    The arguments are those of :func:`aicon_baselines.figures.nav2d.make_figure`, and the steps
    after which the episode ends.
    """
    files = FigureFiles(out, ArmRollout.name, video)
    policy = make_policy("arm_push", **TASK.policy_options("camera")).compile()
    recording = record_arm(policy, seed, horizon)
    return save_rollout(ArmRollout(recording), files)


def record_arm(policy: Policy, seed: int, horizon: int) -> ArmRecording:
    """Run an episode of a policy that uses the camera, and keep every tenth step.

    The episode ends by success, or after `horizon` steps: the film's own limit.
    """
    env = ArmPushEnv(render_mode="rgb_array", render_width=480, render_height=360)

    def look(observation: Any) -> tuple[Frame, Frame]:
        return env.picture("outside"), observation["rgb"]

    # A picture of the scene is slow to render: only the steps that are kept have one.
    return record(ArmRecording, policy, env, {"seed": seed}, horizon, stride=STRIDE, look=look)
