"""What the agent would do elsewhere: the library's own sweep at many positions, on the memory of one moment."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
import shapely
import torch
from torch import Tensor

from aicon_baselines.figures.nav2d.recording import MEETING, BoolArray, FloatArray, Recording
from aicon_envs.nav2d import NavigationMap
from aicon_envs.nav2d.world import union
from aicon_torch.control import ACTIVE
from aicon_torch.resolution import Memory

_NEAREST_BELIEF = 0.1  # m; the agent keeps its target estimate at least this far away


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

    Raises:
        ValueError: If there is no such step, or no memory before it.
    """
    policy, model = recording.policy, recording.policy.model
    if not 1 <= step < recording.steps:
        raise ValueError(f"step={step!r}: expected 1 to {recording.steps - 1}; step 0 has no memory before it.")
    before = _spread(recording.memories[step - 1], len(points))
    now = _spread(recording.memories[step], len(points))
    values = {name: now[name] for name in model.quantities} | {name: before[name] for name in model.actuators}
    values["p_tar"] = _at_least(model.like.new_tensor(recording.belief(step)[0] - points), _NEAREST_BELIEF)
    if obstacle == "true":
        values["x_obs"] = model.like.new_tensor(clearance(recording.world, recording.radius, points))
    with torch.enable_grad():
        tapes = model.record(values)
    gradients, meetings = policy.backward_pass(tapes, values, before, before[ACTIVE])
    (gradient,) = gradients.values()
    nowhere = torch.zeros(len(points), dtype=torch.bool)
    exploring = meetings.get(f"{MEETING}/exploring", nowhere).numpy(force=True)
    return Field(-gradient.numpy(force=True).astype(np.float64) / model.dt, exploring)  # x_rob = a dt


def clearance(world: NavigationMap, radius: float, points: FloatArray) -> FloatArray:
    """The true (d, ∇d) at positions (N, 2), (N, 3), m; in an obstacle −radius and no slope."""
    solid = union(world.obstacles)
    if solid.is_empty:
        return np.tile([1e3, 0.0, 0.0], (len(points), 1))
    lines = shapely.get_coordinates(shapely.shortest_line(solid, shapely.points(points))).reshape(-1, 2, 2)
    away: FloatArray = lines[:, 1] - lines[:, 0]
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    return np.concatenate([distance - radius, away / np.maximum(distance, 1e-12)], axis=1)


def _spread(memory: Mapping[str, Tensor], count: int) -> Memory:
    """The memory of one agent as that of a batch of equal ones."""
    return {key: value.expand(count, *value.shape) for key, value in memory.items()}


def _at_least(vector: Tensor, length: float) -> Tensor:
    """Vectors, lengthened where they are shorter than a length."""
    norm = torch.linalg.vector_norm(vector, dim=-1, keepdim=True)
    longer: Tensor = vector * (norm.clamp(min=length) / norm.clamp(min=1e-9))
    return longer
