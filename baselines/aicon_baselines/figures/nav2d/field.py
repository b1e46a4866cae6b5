"""What the agent would do elsewhere: its own backward pass at many positions at one moment."""

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
import shapely
import torch
from torch import Tensor

from aicon_baselines.evaluation.recording import BoolArray, FloatArray, to_array
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_envs.nav2d import NavigationMap
from aicon_envs.nav2d.world import union
from aicon_torch.inspection.trace import trace

_NEAREST_BELIEF = 0.1  # m; the agent keeps its target estimate at least this far away
_FAR = 1e3  # m; the clearance where there are no obstacles


class Field(NamedTuple):
    """What the agent would do at N positions.

    Attributes:
        descent: −∇ after the resolution at x_rob, (N, 2): where it would go, and how strongly.
        exploring: Whether it would explore there, (N,).
    """

    descent: FloatArray
    exploring: BoolArray


def sample(
    recording: NavigationRecording,
    step: int,
    points: FloatArray,
    obstacle: Literal["true", "remembered"] = "true",
) -> Field:
    """The resolved gradient that the agent would compute at other positions, there and then.

    All positions are one batch through the policy's own backward pass, from the memory before the
    step: covariances, ranks, motion average and the exploration that goes on are those of that
    moment. Two things depend on the position y: the target estimate becomes (where the agent
    believes the target) − y, and the obstacle estimate (d, ∇d) becomes the *true* clearance at y
    and its slope. The agent cannot know the latter away from where it is: only this figure looks it
    up in the map.

    Args:
        recording: The rollout.
        step: Which step, 1 or later.
        points: The positions, (N, 2), m, outside the obstacles.
        obstacle: With "remembered" the agent's own obstacle estimate is used everywhere; at the
            agent's position this is the gradient that it followed.

    Raises:
        ValueError: If there is no such step, or no memory before it.
    """
    if not 1 <= step < recording.steps:
        last = recording.steps - 1
        raise ValueError(f"step={step!r}: expected 1 to {last}; step 0 has no memory before it.")

    policy, count = recording.policy, len(points)
    model = policy.model
    values = _values_at(recording, step, points)
    if obstacle == "true":
        clearances = clearance(recording.world, recording.radius, points)
        values["x_obs"] = model.like.new_tensor(clearances)

    # The backward pass of the step, with all goals switched on.
    memory = _repeat(recording.memories[step - 1], count)
    goal_factors = model.like.new_ones(count, len(model.goals))
    with torch.enable_grad():
        graphs = model.record(values)
    values |= model.costs(values)
    gradients, resolved = policy.backward_pass(graphs, values, memory, goal_factors)

    (gradient,) = gradients.values()
    descent = -to_array(gradient) / model.dt  # x_rob = a dt
    found = trace(policy.backward_pass, {**values, **resolved})
    exploring = found.quantities[recording.resolved_at].exploring
    return Field(descent, exploring.numpy(force=True))


def _values_at(recording: NavigationRecording, step: int, points: FloatArray) -> dict[str, Tensor]:
    """The values of a step before it acts, with the target estimate as seen from each position."""
    model = recording.policy.model
    values: dict[str, Tensor] = {}
    for name in model.quantities:
        moment = step - 1 if name in model.actuators else step
        values[name] = recording.trace.values[name][moment]
    values = model.values(_repeat(values, len(points)))

    mean, _ = recording.belief(step)
    to_target = model.like.new_tensor(mean - points)
    values["p_tar"] = _at_least(to_target, _NEAREST_BELIEF)
    return values


def clearance(world: NavigationMap, radius: float, points: FloatArray) -> FloatArray:
    """The true (d, ∇d) at positions (N, 2), (N, 3), m; in an obstacle −radius and no slope."""
    solid = union(world.obstacles)
    if solid.is_empty:
        return np.tile([_FAR, 0.0, 0.0], (len(points), 1))

    lines = shapely.get_coordinates(shapely.shortest_line(solid, shapely.points(points)))
    start, end = lines.reshape(-1, 2, 2).swapaxes(0, 1)
    away: FloatArray = end - start

    distance = np.linalg.norm(away, axis=1, keepdims=True)
    return np.concatenate([distance - radius, away / np.maximum(distance, 1e-12)], axis=1)


def _repeat(values: Mapping[str, Tensor], count: int) -> dict[str, Tensor]:
    """The values of one agent as those of a batch of equal ones."""
    return {name: value.expand(count, *value.shape) for name, value in values.items()}


def _at_least(vectors: Tensor, length: float) -> Tensor:
    """Vectors, lengthened where they are shorter than a length."""
    norms = torch.linalg.vector_norm(vectors, dim=-1, keepdim=True)
    longer: Tensor = vectors * (norms.clamp(min=length) / norms.clamp(min=1e-9))
    return longer
