"""Where an actuator was nearest to what the goals want, for one that gives up to go back to."""

import torch
from torch import Tensor

from aicon_torch.resolution import Memory


def initial_nearest(size: int) -> Memory:
    """It has been nowhere: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
    """
    return {
        "nearest": torch.tensor(torch.inf),
        "nearest_way": torch.zeros(size),
        "gave_up": torch.tensor(False),
    }


def nearest_so_far(
    cost: Tensor, is_other: Tensor, step: Tensor, gave_up: Tensor, memory: Memory
) -> Memory:
    """The least cost so far, and the way back to where it was.

    Args:
        cost: The cost here, ``(*B,)``.
        is_other: Whether it is that of other goals, so that what was before does not count.
        step: How far each component moves now, ``(*B, n)``.
        gave_up: Whether it has given up, ``(*B,)``.
        memory: What was remembered.
    """
    is_nearest = is_other | (cost < memory["nearest"])
    way = torch.where(is_nearest.unsqueeze(-1), 0.0, memory["nearest_way"])
    return {
        "nearest": torch.where(is_nearest, cost, memory["nearest"]),
        "nearest_way": way - step,
        "gave_up": gave_up,
    }
