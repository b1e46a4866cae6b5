"""The trace of a step: what it decided, batched and typed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.plan import PartialPath
from aicon_torch.resolution import Memory
from aicon_torch.vectors import select, unit

UNUSED = -1
"""Rank of a gradient that was not used, and index of an opponent where there is none."""


@dataclass(frozen=True)
class QuantityTrace:
    """What happened at a quantity where gradients met, or at an actuator that one reached.

    Attributes:
        name: The quantity.
        paths: For each of n gradients the names that it came through, from its goal to this
            quantity. Where gradients were merged on the way, it begins with their goals, joined by
            "+".
        goals: For each gradient the goals that it comes from.
        gradients: The gradients that arrived, ``(*B, n, d)``.
        magnitudes: Theirs, ``(*B, n)``.
        weights: By how much each counted, ``(*B, n)``.
        ranks: The rank of each, 0 for the dominant one, ``(*B, n)``; −1 where it was not used.
        dominant: Index of the dominant gradient, ``(*B,)``.
        opponent: Index of the gradient that it was compared with, ``(*B,)``; −1 for none.
        cosine: Cosine between the two, ``(*B,)``; 1 where there is none.
        exploring: Whether the quantity moved in a nullspace instead of downhill, or an actuator
            along the force of its constraints, ``(*B,)``.
    """

    name: str
    paths: tuple[tuple[str, ...], ...]
    goals: tuple[tuple[str, ...], ...]
    gradients: Tensor
    magnitudes: Tensor
    weights: Tensor
    ranks: Tensor
    dominant: Tensor
    opponent: Tensor
    cosine: Tensor
    exploring: Tensor

    @property
    def labels(self) -> tuple[str, ...]:
        """The paths in words: ``"reach → p_tar → x_rob"``."""
        return tuple(" → ".join(path) for path in self.paths)

    def goals_in_conflict(self, row: int | tuple[int, ...] = ()) -> tuple[str, str] | None:
        """Goals of the dominant gradient and of the one that opposes it, while exploring.

        None where it does not explore, or where it only waits for progress and nothing opposes
        the dominant one any more.

        Args:
            row: Which row of the batch.
        """
        opponent = int(self.opponent[row])
        if not bool(self.exploring[row]) or opponent == UNUSED:
            return None
        dominant = int(self.dominant[row])
        return "+".join(self.goals[dominant]), "+".join(self.goals[opponent])


@dataclass(frozen=True)
class StepTrace:
    """What one control step knew and decided, for every row of the batch.

    Attributes:
        values: Estimates, covariances, readings and actions after the step, ``(*B, *shape)``.
        costs: Cost of each goal, ``(*B,)``.
        quantities: What happened where gradients met, and at the actuators.
    """

    values: dict[str, Tensor]
    costs: dict[str, Tensor]
    quantities: dict[str, QuantityTrace]

    def leading_path(self, name: str, row: int | tuple[int, ...] = ()) -> tuple[str, ...]:
        """The names from a goal to a quantity along which its dominant gradient came.

        Where gradients were merged on the way, it goes on along the dominant one of those.

        Args:
            name: An actuator, or a quantity where gradients met.
            row: Which row of the batch.
        """
        # First on a path stand its goals; if they were merged on the way, next stands where.
        met = self.quantities[name]
        path = met.paths[int(met.dominant[row])]
        merged_at = path[1]
        if merged_at == name or merged_at not in self.quantities:
            return path
        return self.leading_path(merged_at, row) + path[2:]


def trace(backward: BackwardPass, memory: Memory) -> StepTrace:
    """Read off a memory what the step that returned it decided.

    Args:
        backward: The backward pass of the policy.
        memory: The memory, ``(*B, …)``.
    """
    model = backward.model
    values = model.values(memory)

    # A memory keeps no costs, and they follow from its values.
    with torch.no_grad():
        costs = model.costs(values)

    quantities: dict[str, QuantityTrace] = {}
    for name, paths in backward.paths.items():
        if backward.resolves_at(name):
            own = backward.recall(name, memory)
            quantities[name] = _where_gradients_met(backward, name, paths, own)
        elif name in model.actuators:
            gradient = memory[f"{name}/gradient"]
            quantities[name] = _where_one_arrived(backward, name, paths[0], gradient)

        # An actuator explores as well while it escapes from where constraints hold it up.
        escaping = memory.get(f"{name}/escape/escaping")
        if escaping is not None and name in quantities:
            exploring = quantities[name].exploring | escaping
            quantities[name] = replace(quantities[name], exploring=exploring)
    known = {name: values[name] for name in model.quantities}
    return StepTrace(known, costs, quantities)


def _where_gradients_met(
    backward: BackwardPass, name: str, paths: list[PartialPath], memory: Mapping[str, Tensor]
) -> QuantityTrace:
    gradients = memory["gradients"]
    magnitudes = torch.linalg.vector_norm(gradients, dim=-1)
    dominant = _dominant(magnitudes, memory)
    opponent, cosine = _opponent(gradients, magnitudes, dominant, memory)
    nowhere = torch.zeros_like(dominant, dtype=torch.bool)

    # Weights and ranks follow from the gradients; whether it explores is remembered.
    return QuantityTrace(
        name=name,
        paths=tuple((*path.names, name) for path in paths),
        goals=tuple(_in_order(path.goals, backward) for path in paths),
        gradients=gradients,
        magnitudes=magnitudes,
        weights=backward.resolution.weigh(magnitudes),
        ranks=_ranks(magnitudes, memory),
        dominant=dominant,
        opponent=opponent,
        cosine=cosine,
        exploring=memory.get("exploring", nowhere),
    )


def _where_one_arrived(
    backward: BackwardPass, name: str, path: PartialPath, gradient: Tensor
) -> QuantityTrace:
    magnitudes = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)

    # Alone it leads, counts in full, and has no opponent.
    first = torch.zeros_like(magnitudes[..., 0], dtype=torch.long)
    return QuantityTrace(
        name=name,
        paths=((*path.names, name),),
        goals=(_in_order(path.goals, backward),),
        gradients=gradient.unsqueeze(-2),
        magnitudes=magnitudes,
        weights=torch.ones_like(magnitudes),
        ranks=torch.zeros_like(magnitudes, dtype=torch.long),
        dominant=first,
        opponent=torch.full_like(first, UNUSED),
        cosine=torch.ones_like(magnitudes[..., 0]),
        exploring=torch.zeros_like(first, dtype=torch.bool),
    )


def _in_order(goals: frozenset[str], backward: BackwardPass) -> tuple[str, ...]:
    """Goals in the order of the model."""
    return tuple(goal for goal in backward.model.goals if goal in goals)


def _dominant(magnitudes: Tensor, memory: Mapping[str, Tensor]) -> Tensor:
    """Index of the gradient of rank 0; without ranks, of the strongest."""
    if "rank" in memory:
        return memory["rank"][..., 0].clamp(min=0)
    return magnitudes.argmax(-1)


def _ranks(magnitudes: Tensor, memory: Mapping[str, Tensor]) -> Tensor:
    """The rank of each gradient, from the gradient of each rank."""
    ranks = torch.full_like(magnitudes, UNUSED, dtype=torch.long)
    if "rank" not in memory:
        return ranks

    indices = torch.arange(magnitudes.shape[-1], device=magnitudes.device)
    for rank, index in enumerate(memory["rank"].unbind(-1)):
        ranks = torch.where(indices == index.unsqueeze(-1), rank, ranks)
    return ranks


def _opponent(
    gradients: Tensor, magnitudes: Tensor, dominant: Tensor, memory: Mapping[str, Tensor]
) -> tuple[Tensor, Tensor]:
    """What the dominant one was compared with, or else the second strongest; the cosine."""
    if "opponent" in memory:
        return memory["opponent"][..., 0], memory["cosine"]

    # A rule that compares nothing has no opponent of its own: take the second strongest.
    others = magnitudes.scatter(-1, dominant.unsqueeze(-1), -1.0)
    opponent = others.argmax(-1)
    first, second = (unit(select(gradients, i.unsqueeze(-1))) for i in (dominant, opponent))
    return opponent, (first * second).sum(-1)
