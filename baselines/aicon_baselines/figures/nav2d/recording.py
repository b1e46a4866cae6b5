"""A rollout and all that the policy knew in it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.figures.pictures import OnStep, spans
from aicon_envs.nav2d import NavigationMap
from aicon_torch.control import Policy
from aicon_torch.resolution import Memory

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MEETING = "x_rob"
"""The quantity where all paths meet: the agent's position."""

PATHS = {"p1": ("reach", "p_tar"), "p2": ("reach", "P_tar"), "p3": ("avoid", "x_obs")}
"""The paper's paths: each gradient at x_rob by its trace."""


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
        traces = [arrival.trace for arrival in self.policy.backward_pass.arrivals[MEETING]]
        norms = self._series(f"{MEETING}/gradients", lambda gradients: torch.linalg.vector_norm(gradients, dim=-1))
        return {name: norms[:, traces.index(trace)] for name, trace in PATHS.items()}

    @cached_property
    def uncertainty(self) -> FloatArray:
        """Trace of the target's covariance, (n,), m²."""
        return self._series("P_tar", torch.trace)

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether each step explored, (n,)."""
        return np.array([bool(memory.get(f"{MEETING}/exploring", False)) for memory in self.memories])

    @cached_property
    def spans(self) -> list[tuple[int, int]]:
        """First step of each exploration and the first one after it."""
        return spans(self.exploring)

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
    observation, info = env.reset(seed=seed, options={"map_seed": seed})
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
