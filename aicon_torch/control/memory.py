"""The memory: all that lives from step to step, as a flat dictionary of tensors."""

from collections.abc import Mapping

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.safety import safety_memory
from aicon_torch.errors import ObservationError, choices
from aicon_torch.quantities import PRESENT
from aicon_torch.resolution import Memory

GOAL_FACTORS = "goals/active"
"""Key of the factor of each goal, ``(*B, goals)``."""


def memory_keys(backward: BackwardPass) -> frozenset[str]:
    """The keys of a memory: every quantity, what is remembered of the gradients, and the goals."""
    model = backward.model
    present = [name + PRESENT for name in model.declaration.optional_sensors]
    constants = constant_memory(backward)
    return frozenset([GOAL_FACTORS, *present, *model.quantities, *constants])


def constant_memory(backward: BackwardPass) -> Memory:
    """What is remembered before the first step whatever is read, without batch dimensions."""
    return backward.initial() | safety_memory(backward.model)


def initial_memory(
    backward: BackwardPass, readings: Mapping[str, Tensor], batch: tuple[int, ...]
) -> Memory:
    """The memory before the first step.

    Args:
        backward: The backward pass, with its model.
        readings: The first readings, ``(*B, size)``.
        batch: The leading dimensions B.
    """
    model = backward.model
    memory = model.initial(readings, batch)

    constants = constant_memory(backward) | {GOAL_FACTORS: torch.ones(len(model.goals))}
    for key, value in constants.items():
        dtype = model.like.dtype if value.is_floating_point() else value.dtype
        value = value.to(model.like.device, dtype)
        memory[key] = value.expand((*batch, *value.shape))
    return memory


def restart_rows(memory: Memory, fresh: Memory, starts: Tensor) -> Memory:
    """The memory, begun anew in the rows ``(*B,)`` that start an episode.

    Which goals are switched on is a setting, not an estimate: it stays.
    """
    restarted: Memory = {}
    for key, value in memory.items():
        own_dimensions = (None,) * (value.dim() - starts.dim())
        restarted[key] = torch.where(starts[(..., *own_dimensions)], fresh[key], value)
    restarted[GOAL_FACTORS] = memory[GOAL_FACTORS]
    return restarted


def check_memory(
    memory: Mapping[str, Tensor],
    keys: frozenset[str],
    actuator: str,
    batch: tuple[int, ...],
) -> None:
    """Check that a memory is one of this policy, and as large as the observation.

    Args:
        memory: The memory.
        keys: Keys that it must have.
        actuator: Name of an actuator, whose action tells the batch.
        batch: Leading dimensions of the observation.

    Raises:
        ObservationError: If not.
    """
    if memory.keys() != keys:
        missing, unknown = keys - memory.keys(), memory.keys() - keys
        raise ObservationError(
            f"state: not a memory of this policy; it lacks {choices(missing)} and has "
            f"{choices(unknown)} besides."
        )

    own_batch = tuple(memory[actuator].shape[:-1])
    if own_batch != batch:
        raise ObservationError(
            f"state: its batch is {own_batch}, that of the observation {batch}; expected the same."
        )


def starting_rows(
    episode_start: ArrayLike | Tensor | None, batch: tuple[int, ...], device: torch.device
) -> Tensor | None:
    """The rows that start an episode, ``(*B,)``; None if there are none.

    Raises:
        ObservationError: If there is neither one flag nor one for each row.
    """
    if episode_start is None or isinstance(episode_start, Tensor):
        return episode_start

    flags: NDArray[np.bool_] = np.asarray(episode_start, dtype=bool)
    if flags.shape != batch and flags.size != 1:
        raise ObservationError(
            f"episode_start: expected shape {batch}, the batch, got {flags.shape}."
        )
    if not flags.any():
        return None

    if flags.size == 1:
        flags = flags.reshape(-1)[0]
    return torch.as_tensor(np.broadcast_to(flags, batch).copy(), device=device)
