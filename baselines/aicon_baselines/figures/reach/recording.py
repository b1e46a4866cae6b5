"""An episode of an arm that reaches: pictures, errors and gaps."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.figures.recording import BoolArray, FloatArray, track
from aicon_baselines.figures.rendering import Frame
from aicon_envs.reach import ReachEnv
from aicon_envs.reach.simulation import CONTROL_STEP
from aicon_torch import Policy


@dataclass(frozen=True, kw_only=True)
class ReachRecording:
    """An episode, with n control steps.

    Attributes:
        robot: Name of the robot.
        seed: Seed of the episode.
        success: Whether it arrived.
        frames: Pictures, one in `stride` steps, the first before the first step.
        stride: Steps from one picture to the next.
        distance: To the target, (n,), m.
        angle: (n,), rad.
        self_gap: Smallest gap of the robot to itself, (n,), m.
        limit_margin: Smallest distance of a joint to its stops, (n,), rad.
        exploring: Whether the policy explored, (n,); never for one that has no gradients.
    """

    robot: str
    seed: int
    success: bool
    frames: list[Frame]
    stride: int
    distance: FloatArray
    angle: FloatArray
    self_gap: FloatArray
    limit_margin: FloatArray
    exploring: BoolArray

    @property
    def times(self) -> FloatArray:
        """When each step ended, (n,), s."""
        return CONTROL_STEP * np.arange(1.0, len(self.distance) + 1.0, dtype=np.float64)


def record(
    policy: Predictor,
    robot: str,
    seed: int,
    horizon: int,
    *,
    stride: int = 2,
    balls: int = 0,
    progress: bool = False,
) -> ReachRecording:
    """Run an episode of a robot that reaches for a pose from its home.

    Args:
        policy: What moves it.
        robot: Name of the robot.
        seed: Seed of the episode.
        horizon: Steps after which it ends.
        stride: Steps from one picture to the next.
        balls: Number of balls about on its way.
        progress: Whether to show a progress bar, on a terminal only.

    Raises:
        RuntimeError: If nothing can be rendered.
    """
    size: dict[str, Any] = {"render_width": 480, "render_height": 480}
    env = ReachEnv(robot, balls=balls, render_mode="rgb_array", **size)
    observation, info = env.reset(seed=seed)
    frames, rows, state = [_picture(env)], [], None
    exploring: list[bool] = []

    for step in track(range(1, horizon + 1), robot, progress):
        batch = {name: values[None] for name, values in observation.items()}
        start = np.array([step == 1])
        action, state = policy.predict(batch, state=state, episode_start=start)
        observation, _, terminated, _, info = env.step(np.asarray(action)[0])

        exploring.append(_explores(policy, state))
        rows.append([info[name] for name in ("distance", "angle", "self_gap", "limit_margin")])
        if step % stride == 0 or terminated:
            frames.append(_picture(env))
        if terminated:
            break

    env.close()
    distance, angle, self_gap, limit_margin = np.array(rows).T
    return ReachRecording(
        robot=robot,
        seed=seed,
        success=bool(info["is_success"]),
        frames=frames,
        stride=stride,
        distance=distance,
        angle=angle,
        self_gap=self_gap,
        limit_margin=limit_margin,
        exploring=np.array(exploring),
    )


def _explores(policy: Predictor, state: Any) -> bool:
    """Whether the step that returned this state explored anywhere."""
    if not isinstance(policy, Policy):
        return False
    quantities = policy.trace(state).quantities.values()
    return any(bool(quantity.exploring[0]) for quantity in quantities)


def _picture(env: ReachEnv) -> Frame:
    picture = env.render()
    assert picture is not None
    return picture
