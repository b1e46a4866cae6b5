"""The edges of a graph, read off the autograd graph of each of its functions."""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph.checks import named_errors, names_of
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.paths import Edge


def find_edges(
    declaration: Declaration, estimators: Sequence[Estimator], values: Mapping[str, Tensor]
) -> dict[str, tuple[Edge, ...]]:
    """For each quantity and goal the quantities that its gradient goes on to.

    Kept are the edges on a path from a goal to an actuator. An estimate that is read before it is
    updated in this step (its own last value, or that of a later estimator) is no edge.

    Args:
        declaration: The parts.
        estimators: The estimators in the order in which they run.
        values: Values after a step.
    """
    owners = {name: estimator for estimator in estimators for name in estimator.outputs}
    depends_on_action = set(declaration.actuators)
    found: dict[str, tuple[Edge, ...]] = {}

    # Forward: who depends on an actuator, directly or by way of others?
    nodes: tuple[Estimator | Goal, ...] = (*estimators, *declaration.goals.values())
    for node in nodes:
        # Of those so far: what is updated later in the step is read as the last step's constant.
        sources = [name for name in node.inputs if name in depends_on_action]
        for name in names_of(node):
            read = _differentiable_sources(node, name, sources, values)
            found[name] = tuple(_edge(name, source, node, owners, values) for source in read)
        if isinstance(node, Estimator):
            depends_on_action.update(name for name in node.outputs if found[name])

    # Backward: on whom does a goal depend?
    wanted = set(declaration.goals)
    for name in reversed(found):
        if name in wanted:
            wanted.update(edge.source for edge in found[name])

    return {name: edges for name, edges in found.items() if name in wanted and edges}


def _differentiable_sources(
    node: Estimator | Goal, name: str, sources: Sequence[str], values: Mapping[str, Tensor]
) -> list[str]:
    """Those of the sources by which a quantity or goal can be differentiated."""
    # On fresh leaves autograd itself tells by which of them the output can be differentiated.
    leaves = {source: values[source].detach().clone().requires_grad_() for source in sources}
    inputs = {**values, **leaves}
    with named_errors(node, inputs):
        output = node(inputs, name) if isinstance(node, Estimator) else node(inputs)
    if not leaves or not output.requires_grad:
        return []

    gradients = torch.autograd.grad(output.sum(), list(leaves.values()), allow_unused=True)
    pairs = zip(leaves, gradients, strict=True)
    return [source for source, gradient in pairs if gradient is not None]


def _edge(
    name: str,
    source: str,
    node: Estimator | Goal,
    owners: Mapping[str, Estimator],
    values: Mapping[str, Tensor],
) -> Edge:
    """The edge to a source; from rows to a source without rows it brings a gradient each."""
    each = node.each if isinstance(node, Estimator) else ()
    if not each or source in each:
        return Edge(name, source)
    rows = values[each[0]].shape[-2]
    return Edge(name, source, rows, _origin_of_rows(name, owners))


def _origin_of_rows(name: str, owners: Mapping[str, Estimator]) -> str:
    """The quantity that a quantity's rows go back to."""
    owner = owners.get(name)
    if owner is None or not owner.each:
        return name
    return _origin_of_rows(owner.each[0], owners)
