"""An episode of the arm: what was seen from outside and from the hand, and what the policy knew."""

from functools import cached_property
from typing import Any

import numpy as np
from PIL import Image

from aicon_baselines.evaluation import recording
from aicon_baselines.evaluation.recording import FloatArray, Recording, to_array
from aicon_baselines.figures.rendering import Frame
from aicon_envs.arm_push import ArmPushEnv
from aicon_torch.policy import Policy

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


def record(policy: Policy, seed: int, horizon: int, *, progress: bool = False) -> ArmRecording:
    """Run an episode of a policy that uses the camera, and keep every tenth step.

    The episode ends by success, or after `horizon` steps: the film's own limit.
    """
    env = ArmPushEnv(render_mode="rgb_array", render_width=480, render_height=360)

    def look(observation: Any) -> tuple[Frame, Frame]:
        return env.picture("outside"), observation["rgb"]

    # A picture of the scene is slow to render: only the steps that are kept have one.
    return recording.record(
        ArmRecording,
        policy,
        env,
        {"seed": seed},
        horizon,
        stride=STRIDE,
        look=look,
        every=STRIDE,
        progress=progress,
    )
