"""The controller of the pusher, sub-step by sub-step: the oracle of its closed form."""

from typing import Any

from torch import Tensor

GAINS: list[dict[str, Any]] = [
    {},
    {"stiffness": 40.0, "damping": 5.0},
    {"substep": 0.02, "substeps": 5},
]


def sub_steps(
    offset: Tensor,
    velocity: Tensor,
    stiffness: float = 100.0,
    damping: float = 20.0,
    substep: float = 0.01,
    substeps: int = 10,
) -> tuple[list[Tensor], Tensor]:
    """Displacements after each sub-step towards a target at an offset, and the final velocity."""
    moved, places = offset * 0.0, []
    for _ in range(substeps):
        force = stiffness * (offset - moved) - damping * velocity
        velocity = velocity + force * substep
        moved = moved + velocity * substep
        places.append(moved)
    return places, velocity
