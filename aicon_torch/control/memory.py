"""The memory: all that lives from step to step, as a flat dictionary of tensors."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from aicon_torch.control.backward import BackwardPass
from aicon_torch.errors import ObservationError, choices
from aicon_torch.graph import WorldModel
from aicon_torch.readings.observation import is_dense, tensor_kind
from aicon_torch.readings.validation import BEGINS, MeasurementValidation
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import safety_memory
from aicon_torch.safety.watchdog import sent_memory

GOAL_FACTORS = "goals/active"
"""Key of the factor of each goal, ``(*B, goals)``."""

OUTLASTS_EPISODES = (GOAL_FACTORS,)
"""Keys of factors, one by default, that stay where an episode begins anew."""

STEPS = "steps"
"""Key of the number of steps since the episode began, ``(*B,)``, up to STEPS_AT_MOST."""

STEPS_AT_MOST = 4096 * 4093
"""So many steps single precision can count; at a multiple of its period a dither goes on."""


def memory_shapes(
    backward: BackwardPass, validation: MeasurementValidation
) -> dict[str, tuple[int, ...]]:
    """The shapes of a memory without the batch: quantities, gradients, goals and sensors."""
    model = backward.model
    shapes = {name: quantity.shape for name, quantity in model.quantities.items()}
    for key, value in constant_memory(backward, validation).items():
        shapes[key] = tuple(value.shape)
    return shapes


def constant_memory(backward: BackwardPass, validation: MeasurementValidation) -> Memory:
    """What is remembered before the first step whatever is read, without batch dimensions."""
    model = backward.model
    with torch.device("cpu"):  # whatever device is torch's default
        constants = backward.initial() | validation.initial() | safety_memory(model)
        constants[GOAL_FACTORS] = torch.ones(len(model.goals))
        constants[STEPS] = torch.zeros(())
    return constants | sent_memory(model)


def integer_types(
    backward: BackwardPass, validation: MeasurementValidation
) -> dict[str, torch.dtype]:
    """The types of what a memory has besides real numbers, by key: indices and flags."""
    types: dict[str, torch.dtype] = {}
    for key, value in constant_memory(backward, validation).items():
        if not value.is_floating_point():
            types[key] = value.dtype
    return types


def initial_memory(
    backward: BackwardPass,
    validation: MeasurementValidation,
    readings: Mapping[str, Tensor],
    batch: tuple[int, ...],
) -> Memory:
    """The memory before the first step.

    Args:
        backward: The backward pass, with its model.
        validation: Says what is remembered of the sensors.
        readings: The first readings, ``(*B, size)``, zero where there is none.
        batch: The leading dimensions B.
    """
    model = backward.model
    memory = lasting(model, model.initial(readings, batch))

    for key, value in constant_memory(backward, validation).items():
        dtype = model.like.dtype if value.is_floating_point() else value.dtype
        value = value.to(model.like.device, dtype)
        memory[key] = value.expand((*batch, *value.shape))
    return memory


def lasting(model: WorldModel, values: Mapping[str, Tensor]) -> Memory:
    """Those of a step's values that live on: all but ``dt`` and the costs of the goals."""
    passing = ("dt", *model.goals)
    return {name: value for name, value in values.items() if name not in passing}


def restart_rows(memory: Memory, fresh: Memory, starts: Tensor) -> Memory:
    """The memory, begun anew in the rows ``(*B,)`` that start an episode.

    What outlasts an episode stays.
    """
    restarted: Memory = {}
    for key, value in memory.items():
        # A row's flag holds for all that the row remembers under this key.
        own_dimensions = (None,) * (value.dim() - starts.dim())
        restarted[key] = torch.where(starts[(..., *own_dimensions)], fresh[key], value)
    return restarted | {key: memory[key] for key in OUTLASTS_EPISODES}


def grown(memory: Memory, fresh: Memory, lacks: Tensor) -> Memory:
    """The memory of a policy, as a policy with more estimators or goals goes on with it.

    Estimates, actions and the factors of goals are those of the memory, and so is what was
    remembered of gradients where as many meet as did; what is new begins.

    Args:
        memory: The memory.
        fresh: One of the policy that has more, before its first step.
        lacks: Rows ``(*B,)`` that lack a reading with which something new begins: their episode
            begins anew once they have it.
    """
    known: Memory = {}
    for key, value in fresh.items():
        has_it = key in memory and memory[key].shape == value.shape
        known[key] = memory[key] if has_it else value

    # New goals come last, so the factors that are known stay the first ones.
    factors = memory[GOAL_FACTORS]
    added = fresh[GOAL_FACTORS][..., factors.shape[-1] :]
    known[GOAL_FACTORS] = torch.cat((factors, added), dim=-1)
    known[BEGINS] = memory[BEGINS] | lacks
    return known


def checked_memory(
    memory: Mapping[str, Tensor],
    shapes: Mapping[str, tuple[int, ...]],
    integers: Mapping[str, torch.dtype],
    like: Tensor,
    batch: tuple[int, ...] | None = None,
) -> Memory:
    """A memory of this policy, as large as the observation, with real numbers in its precision.

    Args:
        memory: The memory, whose real numbers may be of another precision.
        shapes: What it must have, by key, without the batch.
        integers: The types of what is no real number in it.
        like: A tensor of the policy's precision.
        batch: Leading dimensions of the observation; None for those that the memory has.

    Raises:
        ObservationError: If it is another one.
    """
    # What is remembered, by its names ...
    if not isinstance(memory, Mapping):
        raise ObservationError(
            f"state: expected the memory that the last step returned, got {type(memory)}."
        )
    if memory.keys() != shapes.keys():
        missing = [key for key in shapes if key not in memory]
        unknown = [key for key in memory if key not in shapes]
        raise ObservationError(
            f"state: not a memory of this policy; it lacks {choices(missing)} and has "
            f"{choices(unknown)} besides."
        )

    # ... and, for each name, a tensor as large as the observation's batch.
    checked: Memory = {}
    told_by = "the observation" if batch else "an observation of one robot, or of no reading,"
    for key, shape in shapes.items():
        value = _checked_type(key, memory[key], integers.get(key))
        own = tuple(value.shape[: value.dim() - len(shape)])
        if batch is None:
            batch, told_by = own, repr(key)

        if tuple(value.shape) != (*batch, *shape):
            reason = ""
            if tuple(value.shape) == (*own, *shape):
                reason = f"the batch of {key!r} is {own}, that of {told_by} {batch}; "
            raise ObservationError(
                f"state: {reason}expected shape {(*batch, *shape)} of {key!r}, got "
                f"{tuple(value.shape)}."
            )
        checked[key] = value if key in integers else value.to(like.dtype)
    return checked


def _checked_type(key: str, value: Any, integer: torch.dtype | None) -> Tensor:
    """An entry of a memory, which is a tensor of real numbers, or of the type that is given."""
    if not isinstance(value, Tensor):
        raise ObservationError(f"state[{key!r}]: expected a tensor, got {type(value)}.")
    if not is_dense(value):
        raise ObservationError(
            f"state[{key!r}]: expected a dense tensor, got {tensor_kind(value)}."
        )

    if integer is None and not value.is_floating_point():
        raise ObservationError(f"state[{key!r}]: expected real numbers, got {value.dtype}.")
    if integer is not None and value.dtype != integer:
        raise ObservationError(f"state[{key!r}]: expected {integer}, got {value.dtype}.")
    return value


def starting_rows(
    episode_start: ArrayLike | Tensor | None, batch: tuple[int, ...], device: torch.device
) -> Tensor | None:
    """The rows that start an episode, ``(*B,)``; None if there are none.

    Raises:
        ObservationError: If there is neither one flag nor one for each row.
    """
    if episode_start is None:
        return None
    if isinstance(episode_start, Tensor):
        flags = episode_start.to(device, torch.bool)
    else:
        try:
            flags = torch.as_tensor(np.array(episode_start, dtype=bool), device=device)
        except (ValueError, TypeError) as error:
            raise ObservationError(f"episode_start: expected flags; {error}.") from error

    # One flag is for all rows, as of a vectorised environment that is reset as a whole.
    if tuple(flags.shape) != batch and flags.numel() != 1:
        raise ObservationError(
            f"episode_start: expected shape {batch}, the batch, got {tuple(flags.shape)}."
        )
    return flags.reshape(()).expand(batch) if flags.numel() == 1 else flags
