"""Building a graph from its parts: a pure function, which checks everything that can be checked."""

from dataclasses import dataclass

from torch import Tensor

from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph.checks import check_mode, check_reach, check_rows, names_of
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.edges import find_edges
from aicon_torch.graph.order import in_order
from aicon_torch.graph.paths import Edge
from aicon_torch.graph.probe import check_at_random_point, probe
from aicon_torch.graph.separate_rows import check_rows_stand_alone
from aicon_torch.quantities import Quantity


@dataclass(frozen=True)
class Graph:
    """What runs in which order, and along which edges gradients travel.

    Attributes:
        estimators: The estimators, each after those it reads.
        owners: The estimator of each estimate.
        quantities: Sensors, actuators and estimates, with their shapes.
        edges: For each quantity and goal on a path, the quantities that its gradient goes on to.
        foreseen: Estimates that a look ahead needs: those on a path, and what they or goals read.
        first_readings: Sensors without which an episode cannot begin: those that are not optional,
            and those that a prior reads.
    """

    estimators: tuple[Estimator, ...]
    owners: dict[str, Estimator]
    quantities: dict[str, Quantity]
    edges: dict[str, tuple[Edge, ...]]
    foreseen: frozenset[str]
    first_readings: tuple[str, ...]


def build_graph(declaration: Declaration, like: Tensor) -> Graph:
    """Build and check a graph.

    Args:
        declaration: The parts; their names are checked already.
        like: A tensor of the parts' type and device.

    Raises:
        GraphError: If a shape does not fit, a function does not leave the leading dimensions free
            or mixes the rows of a batch, a network is in training mode or computes in another
            precision, estimators without memory define each other in a circle, a goal depends on no
            actuator, or no goal depends on an actuator.
    """
    check_modes(declaration)

    # Run it once: order and shapes.
    estimators = tuple(in_order(declaration.estimators))
    values = probe(declaration, estimators, like)
    quantities = _quantities(declaration, estimators, values)
    check_rows(estimators, quantities)
    check_at_random_point(declaration, estimators, values)
    check_rows_stand_alone(declaration, estimators, values)

    # Differentiate it once: edges.
    edges = find_edges(declaration, estimators, values)
    check_reach(declaration.goals, declaration.actuators, edges)

    # Without these readings no episode begins: what is not optional, and what a prior is read off.
    prior_inputs = {name for estimator in estimators for name in estimator.prior_inputs}
    first_readings: list[str] = []
    for name, sensor in declaration.sensors.items():
        if not sensor.optional or name in prior_inputs:
            first_readings.append(name)

    return Graph(
        estimators=estimators,
        owners={name: estimator for estimator in estimators for name in estimator.outputs},
        quantities=quantities,
        edges=edges,
        foreseen=_foreseen(declaration, estimators, edges),
        first_readings=tuple(first_readings),
    )


def check_modes(declaration: Declaration, *, trains: bool = False) -> None:
    """Check that no network of the graph is in training mode.

    Args:
        declaration: The parts.
        trains: Whether all of it is about to be.

    Raises:
        GraphError: As :func:`check_mode`.
    """
    nodes: tuple[Estimator | Goal, ...] = (*declaration.estimators, *declaration.goals.values())
    for node in nodes:
        check_mode(names_of(node)[0], node, trains=trains)
    for actuator in declaration.actuators:
        for function in declaration.functions_of(actuator):
            check_mode(actuator, function, trains=trains)


def _foreseen(
    declaration: Declaration, estimators: tuple[Estimator, ...], edges: dict[str, tuple[Edge, ...]]
) -> frozenset[str]:
    """The estimates that a look ahead needs, from the goals back to the first estimator."""
    read = {name for goal in declaration.goals.values() for name in goal.inputs}
    foreseen: set[str] = set()
    for estimator in reversed(estimators):
        needed = [name for name in estimator.outputs if name in edges or name in read]
        foreseen.update(needed)
        if needed:
            read.update(estimator.inputs)
    return frozenset(foreseen)


def _quantities(
    declaration: Declaration, estimators: tuple[Estimator, ...], values: dict[str, Tensor]
) -> dict[str, Quantity]:
    """Every quantity by name, with the shape that it has in the probe."""
    quantities: dict[str, Quantity] = {}
    for name, sensor in declaration.sensors.items():
        quantities[name] = Quantity(name, (sensor.size,))
    for name, actuator in declaration.actuators.items():
        quantities[name] = Quantity(name, (actuator.size,), is_motion=True)
    for estimator in estimators:
        for name in estimator.outputs:
            # The probe has two batch dimensions in front.
            shape = tuple(values[name].shape[2:])
            quantities[name] = Quantity(name, shape, estimator.is_motion)
    return quantities
