"""Properties that the tests check, and independent second implementations to check against."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np
import torch
from torch import Tensor

from aicon_torch import Policy, WorldModel
from aicon_torch.graph import LocalGraphs
from aicon_torch.graph import Path

# --- resolutions


def selection(gradients: Tensor, held: Tensor, margin: float) -> tuple[Tensor, list[int]]:
    """Eq. 7-8 for one stack ``(n, d)``, in plain loops: the projected gradient of each rank, and its candidate.

    Each candidate is projected onto the complement of the span of all original gradients before it, by least squares.
    """
    stack = gradients.double().numpy()
    chosen: list[int] = []
    selected: list[np.ndarray] = []
    for rank in range(min(stack.shape)):
        remaining = stack.copy()
        if chosen:
            basis = stack[chosen].T
            remaining -= (basis @ np.linalg.lstsq(basis, stack.T, rcond=1e-12)[0]).T
            remaining[chosen] = 0.0
        strengths = np.linalg.norm(remaining, axis=-1)
        strengths[int(held[rank])] *= 1.0 + margin if held[rank] >= 0 else 1.0
        chosen.append(int(strengths.argmax()))
        selected.append(remaining[chosen[-1]])
    return torch.as_tensor(np.array(selected)), chosen


def assert_orthogonal(vectors: Tensor, scale: Tensor) -> None:
    """The products of different rows ``(*B, k, d)`` are nothing but rounding, on some scale ``(*B, k, k)``."""
    products = vectors @ vectors.mT
    off_diagonal = products - torch.diag_embed(products.diagonal(dim1=-2, dim2=-1))
    assert (off_diagonal.abs() <= 1e-10 * scale).all()


# --- gradients


def named(label: str) -> tuple[str, int | None]:
    """A quantity and its row: ``x_contact[3]`` is ``("x_contact", 3)``, and ``x_pusher`` is ``("x_pusher", None)``."""
    name, _, row = label.rstrip("]").partition("[")
    return name, int(row) if row else None


def factors(path: Path, model: WorldModel, tapes: LocalGraphs) -> Iterator[tuple[Tensor, Tensor, int | None]]:
    """For each edge of a path the output of its tape, the leaf, and the row of the leaf's copies that it stands for."""
    for label, further in pairwise((path.goal, *path.quantities, path.actuator)):
        (target, row), (source, _) = named(label), named(further)
        sources = [edge.source for edge in model.edges[target]]
        yield tapes[target].output, tapes[target].leaves[sources.index(source)], row


def along(path: Path, model: WorldModel, tapes: LocalGraphs) -> Tensor:
    """The gradient along one complete path (Eq. 1): one factor after the other, each a product with a Jacobian."""
    gradient = torch.ones_like(tapes[path.goal].output)
    for output, leaf, row in factors(path, model, tapes):
        (gradient,) = torch.autograd.grad(output, leaf, gradient, retain_graph=True)
        gradient = gradient if row is None else gradient[..., row, :]
    return gradient


def through_jacobians(path: Path, model: WorldModel, tapes: LocalGraphs) -> Tensor:
    """The same without batch dimensions, with every factor of the chain rule as a full matrix."""
    gradient = torch.ones(1, 1, dtype=torch.float64)
    for output, leaf, row in factors(path, model, tapes):
        slopes = [
            torch.autograd.grad(component, leaf, retain_graph=True, allow_unused=True)[0]
            for component in output.flatten()
        ]
        whole = [torch.zeros_like(leaf) if slope is None else slope for slope in slopes]
        gradient = gradient @ torch.stack([(slope if row is None else slope[row]).flatten() for slope in whole])
    return gradient.squeeze(0)


def sums_over_paths(model: WorldModel, tapes: LocalGraphs) -> dict[str, Tensor]:
    """For each actuator the sum of the gradients along all paths that end there."""
    totals: dict[str, Tensor] = {}
    for path in model.paths():
        gradient = along(path, model, tapes)
        totals[path.actuator] = totals[path.actuator] + gradient if path.actuator in totals else gradient
    return totals


def totals(model: WorldModel, values: Mapping[str, Tensor], actions: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The derivative of the sum of all costs by the actions, of the model as one function."""
    leaves = {name: action.detach().clone().requires_grad_() for name, action in actions.items()}
    cost = torch.stack([cost.sum() for cost in model.uncut(values, leaves).values()]).sum()
    return dict(zip(leaves, torch.autograd.grad(cost, list(leaves.values())), strict=True))


def numeric_totals(
    model: WorldModel,
    values: Mapping[str, Tensor],
    actions: Mapping[str, Tensor],
    goals: Sequence[str] | None = None,
    step: float = 1e-5,
) -> dict[str, Tensor]:
    """The same by central differences, without batch dimensions, for some goals; nothing is differentiated.

    Around the values after a step, each quantity moves by what the model anticipates to change with the actions.
    """

    def anticipate(moved: Mapping[str, Tensor], offsets: Mapping[str, Tensor]) -> dict[str, Tensor]:
        now = {**values, **moved, "dt": model.dt}
        ahead: dict[str, Tensor] = {}
        for node in model.nodes:
            outputs = {name: node(now, name).detach() for name in node.outputs if name in model.edges}
            now.update({name: output + offsets.get(name, 0.0) for name, output in outputs.items()})
            ahead |= outputs
        return ahead | {name: goal(now).detach() for name, goal in model.goals.items()}

    offsets: dict[str, Tensor] = {}
    for node in model.nodes:  # one after the other: the offset of each leaves the next at the value after the step
        for name in node.outputs:
            if name in model.edges:
                offsets[name] = values[name] - anticipate(actions, offsets)[name]

    def cost(moved: Mapping[str, Tensor]) -> Tensor:
        ahead = anticipate(moved, offsets)
        return torch.stack([ahead[name] for name in goals or model.goals]).sum()

    slopes: dict[str, Tensor] = {}
    for name, action in actions.items():
        shifts = step * torch.eye(action.shape[-1], dtype=action.dtype)
        pairs = [(cost({**actions, name: action + s}), cost({**actions, name: action - s})) for s in shifts]
        slopes[name] = torch.stack([(up - down) / (2 * step) for up, down in pairs])
    return slopes


def assert_equal_gradients(first: Mapping[str, Tensor], second: Mapping[str, Tensor], rtol: float = 1e-10) -> None:
    """Gradients agree at every actuator, relative to the largest."""
    assert first.keys() == second.keys()
    scale = max(float(gradient.abs().max()) for gradient in second.values())
    for name in second:
        torch.testing.assert_close(first[name], second[name], rtol=rtol, atol=rtol * max(scale, 1e-6))


# --- policies


def rollout(policy: Policy, observations: list[dict[str, Tensor]]) -> list[dict[str, Tensor]]:
    """The memory after each of some recorded readings."""
    memories: list[dict[str, Tensor]] = []
    for observation in observations:
        _, memory = policy.predict(observation, memories[-1] if memories else None)
        memories.append(memory)
    return memories


def assert_same_memory(first: Mapping[str, Tensor], second: Mapping[str, Tensor], tolerance: float) -> None:
    """Two memories hold the same, to a tolerance."""
    assert first.keys() == second.keys()
    for name in first:
        torch.testing.assert_close(
            first[name], second[name], rtol=tolerance, atol=tolerance, msg=lambda text, name=name: f"{name}: {text}"
        )


def stacked(memories: Sequence[Mapping[str, Tensor]]) -> dict[str, Tensor]:
    """Memories of several steps as one, along a new leading dimension: they are faster to compare."""
    return {name: torch.stack([memory[name] for memory in memories]) for name in memories[0]}


def assert_rows_stand_alone(policy: Policy, observations: list[dict[str, Tensor]], rows: Sequence[int]) -> None:
    """The rows of a batch ``(N,)`` of recorded readings are what each gives alone."""
    together = stacked(rollout(policy, observations))
    for row in rows:
        alone = rollout(policy, [{name: value[row] for name, value in reading.items()} for reading in observations])
        assert_same_memory(stacked(alone), {name: value[:, row] for name, value in together.items()}, 1e-12)
