"""An episode of an arm that reaches: pictures, errors and gaps."""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from aicon_baselines.evaluation import recording
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.evaluation.recording import BoolArray, FloatArray, Recording
from aicon_baselines.figures.rendering import Frame
from aicon_baselines.tasks import side_by_side
from aicon_envs.reach import ReachEnv
from aicon_envs.reach.simulation import CONTROL_STEP
from aicon_torch import Policy

STRIDE = 2
"""Control steps from one picture to the next; the last is of the end."""


@dataclass(frozen=True)
class ReachRecording(Recording):
    """An episode of n control steps: its curves tell what each of them led to.

    Attributes:
        robot: Name of the robot.
    """

    robot: str = ""

    @cached_property
    def times(self) -> FloatArray:
        """When each step ended, (n,), s."""
        return CONTROL_STEP * np.arange(1.0, self.steps + 1.0, dtype=np.float64)

    def after(self, name: str) -> FloatArray:
        """What the environment told by this name after each step, (n,)."""
        return self.told(name)[1:]

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether the policy explored, (n,); never for one that has no gradients."""
        if not isinstance(self.policy, Policy):
            return np.zeros(self.steps, np.bool_)
        return super().exploring


def record(
    policy: Predictor,
    robot: str,
    seed: int,
    horizon: int,
    *,
    balls: int = 0,
    progress: bool = False,
) -> ReachRecording:
    """Run an episode of a robot that reaches for a pose from its home, with balls on its way.

    Raises:
        RuntimeError: If nothing can be rendered.
    """
    size: dict[str, Any] = {"render_width": 480, "render_height": 480}
    env = ReachEnv(robot, balls=balls, render_mode="rgb_array", **size)

    def look(_: Any) -> Frame:
        picture = env.render()
        assert picture is not None
        return picture

    return recording.record(
        partial(ReachRecording, robot=robot),
        policy,
        side_by_side(lambda: env, 1, horizon),
        {"seed": [seed]},
        horizon,
        look=look,
        every=STRIDE,
        progress=progress,
    )
