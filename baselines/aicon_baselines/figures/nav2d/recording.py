"""A rollout in 2D navigation and all that the policy knew in it."""

from functools import cached_property
from typing import ClassVar

import gymnasium
import numpy as np
import torch

from aicon_baselines.evaluation import recording
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.recording import FloatArray, Recording, to_array
from aicon_envs.nav2d import NavigationMap
from aicon_torch.policy import Policy

PATHS = {
    "p1": ("reach", "p_tar", "x_rob"),
    "p2": ("reach", "P_tar", "x_rob"),
    "p3": ("avoid", "x_obs", "x_rob"),
}
"""The paper's paths p₁, p₂ and p₃ from a goal to the agent's displacement."""


class NavigationRecording(Recording):
    """A rollout of n steps with everything that the policy knew.

    The figure shows the gradients at the agent's displacement, where all paths end.
    """

    resolved_at: ClassVar[str] = "x_rob"

    @property
    def world(self) -> NavigationMap:
        """The map."""
        world: NavigationMap = self.env.map
        return world

    @property
    def radius(self) -> float:
        """Radius of the agent, m."""
        return float(self.env.physics.radius)

    @property
    def ending(self) -> str:
        """How it ended."""
        return "collision" if self.infos[-1]["collision"] else super().ending

    @cached_property
    def positions(self) -> FloatArray:
        """True positions, (n + 1, 2), m; `memories[k]` was computed at `positions[k]`."""
        return self.told("position")

    @cached_property
    def strengths(self) -> dict[str, FloatArray]:
        """Norm of the gradient of each path at x_rob, (n,) each."""
        strengths = to_array(self.resolution.magnitudes)
        columns = {name: self.resolution.paths.index(path) for name, path in PATHS.items()}
        return {name: strengths[:, column] for name, column in columns.items()}

    @cached_property
    def uncertainty(self) -> FloatArray:
        """Trace of the target's covariance, (n,), m²."""
        variances = torch.diagonal(self.trace.values["P_tar"], dim1=-2, dim2=-1)
        return to_array(variances.sum(dim=-1))

    @cached_property
    def travelled(self) -> FloatArray:
        """Distance travelled to each position, (n + 1,), m."""
        pieces = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(pieces)])

    def belief(self, step: int) -> tuple[FloatArray, FloatArray]:
        """Mean (2,), m, and covariance (2, 2), m², of the believed target in the world's frame.

        The agent believes it relative to itself; the figure adds the true position.
        """
        values = self.trace.values
        mean = self.positions[step] + to_array(values["p_tar"][step])
        return mean, to_array(values["P_tar"][step])


def record(
    policy: Policy, map_name: str, seed: int, limit: int | None = None
) -> NavigationRecording:
    """Run an episode of aicon/Nav2D-v0 and keep the memory of every step.

    Args:
        policy: A navigation policy.
        map_name: Class of the map.
        seed: Seed of the map and of the noise.
        limit: Limit of the episode, steps; by default the environment's.

    Raises:
        ComparisonError: If the class of maps is unknown; it lists the valid ones.
    """
    try:
        env = gymnasium.make("aicon/Nav2D-v0", map=map_name, max_episode_steps=limit)
    except ValueError as error:
        raise ComparisonError(str(error)) from error

    # The map and the noise have the same seed.
    reset = {"seed": seed, "options": {"map_seed": seed}}
    return recording.record(NavigationRecording, policy, env, reset)
