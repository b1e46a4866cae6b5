"""An episode of the arm: what was seen from outside and from the hand, and what the policy knew."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.figures.recording import BoolArray, FloatArray, Recording, to_array, track
from aicon_baselines.figures.rendering import Frame
from aicon_envs.arm_push import ArmPushEnv
from aicon_torch.policy import Policy
from aicon_torch.resolution import Memory

STRIDE = 10
"""Control steps from frame to frame: ten frames a second, in real time."""


@dataclass(frozen=True, kw_only=True)
class ArmRecording(Recording):
    """An episode with m frames.

    The figure shows the gradients at the end effector, and those that arrive at the joints besides.

    Attributes:
        outside: The scene from outside, m pictures (H, W, 3).
        hand: The camera in the hand, as the policy sees it, m pictures (h, w, 3).
        height: Height of the tip, mm, (m,).
        distance: Distance to the target, mm, (m,).
        angle: Angle to the target, degrees, (m,).
    """

    resolved_at: ClassVar[str] = "x_ee"
    joints: ClassVar[str] = "x_joints"

    outside: list[Frame]
    hand: list[Frame]
    height: FloatArray
    distance: FloatArray
    angle: FloatArray

    @cached_property
    def strengths(self) -> dict[str, FloatArray]:
        """Strength of each gradient by the names that it came through, (m,) each."""
        strengths: dict[str, FloatArray] = {}
        for place in (self.resolved_at, self.joints):
            arrived = self.trace.quantities[place]
            columns = to_array(arrived.strengths).T

            for path, values in zip(arrived.paths, columns, strict=True):
                came_through = path[:-1]
                if self.resolved_at not in came_through:  # what came through it is shown already
                    strengths[" → ".join(came_through)] = values
        return strengths

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether gradients are explored anywhere, (m,)."""
        anywhere = [
            quantity.exploring.numpy(force=True) for quantity in self.trace.quantities.values()
        ]
        explored: BoolArray = np.logical_or.reduce(anywhere)
        return explored


def record(policy: Policy, seed: int, horizon: int, *, progress: bool = False) -> ArmRecording:
    """Run an episode with the camera and keep every tenth step.

    Args:
        policy: A policy of the arm that uses the camera.
        seed: Seed of the episode.
        horizon: Steps after which it ends.
        progress: Whether to show a progress bar, on a terminal only.
    """
    env = ArmPushEnv(render_mode="rgb_array", render_width=480, render_height=360)
    observation, info = env.reset(seed=seed)
    memory: Memory | None = None

    memories: list[Memory] = []
    infos: list[dict[str, Any]] = []
    outside: list[Frame] = []
    hand: list[Frame] = []

    # A picture of the scene is slow to render: every tenth step has one.
    for step in track(range(horizon), "episode", progress):
        action, memory = policy.predict(observation, memory)
        if step % STRIDE == 0:
            memories.append(memory)
            infos.append(info)
            outside.append(env.picture("outside"))
            hand.append(observation["rgb"])

        # The episode ends by success; the horizon is the film's own limit.
        observation, _, terminated, _, info = env.step(action)
        if terminated:
            break

    env.close()
    return ArmRecording(
        seed=seed,
        policy=policy,
        memories=memories,
        ending="success" if info["is_success"] else "no success",
        stride=STRIDE,
        outside=outside,
        hand=hand,
        height=np.array([1e3 * info["tip"][2] for info in infos]),
        distance=np.array([1e3 * info["distance"] for info in infos]),
        angle=np.array([np.degrees(info["angle"]) for info in infos]),
    )
