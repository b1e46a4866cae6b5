"""Validation of a graph when it is built: names, order, and errors that name the node."""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.quantities import PRESENT, Actuator, Sensor


def check_names(
    sensors: Mapping[str, Sensor],
    actuators: Mapping[str, Actuator],
    estimators: Sequence[Estimator],
    goals: Sequence[Goal],
) -> None:
    """Check that a graph has sensors, actuators and goals, names each thing once, and reads only what is there.

    Raises:
        GraphError: If not; it lists the names that are known.
    """
    outputs = [name for estimator in estimators for name in estimator.outputs]
    declared = [*sensors, *actuators, *outputs, *(goal.name for goal in goals)]
    for name in declared:
        if declared.count(name) > 1:
            raise GraphError(f"{name!r} is declared {declared.count(name)} times; each name stands for one thing.")
    for name in declared:
        if name == "dt" or "/" in name or name.endswith(PRESENT):
            raise GraphError(
                f"{name!r} is taken: 'dt' is the time step, and '/' and {PRESENT!r} mark what is remembered."
            )
    if not sensors:
        raise GraphError("sensors: a model needs at least one sensor.")
    if not goals:
        raise GraphError("goals: a model needs at least one goal.")
    if not actuators:
        raise GraphError("actuators: a model needs at least one actuator.")
    known = [*sensors, *actuators, *outputs, "dt"]
    nodes: tuple[Estimator | Goal, ...] = (*estimators, *goals)
    for node in nodes:
        reader = names(node)[0]
        for name in node.inputs:
            if name not in known:
                raise GraphError(f"{reader!r} reads {name!r}, which is not in the graph. Known: {choices(known)}.")


def ordered(estimators: Sequence[Estimator], owners: Mapping[str, Estimator]) -> list[Estimator]:
    """Each estimator after those it reads; in a cycle, after all but those it was reached from.

    Raises:
        GraphError: If functions define each other in a circle, where no value is there to begin with.
    """
    done: list[Estimator] = []

    def visit(estimator: Estimator, trail: tuple[Estimator, ...]) -> None:
        if estimator in trail:
            circle = trail[trail.index(estimator) :]
            if not any(member.recursive for member in circle):
                cycle = " → ".join(member.outputs[0] for member in (*circle, estimator))
                raise GraphError(f"Functions define each other in a circle: {cycle}. Make one an EKF or KalmanFilter.")
            return
        if estimator not in done:
            for name in estimator.inputs:
                if name in owners and owners[name] is not estimator:
                    visit(owners[name], (*trail, estimator))
            if estimator not in done:
                done.append(estimator)

    for estimator in estimators:
        visit(estimator, ())
    return done


def names(node: Estimator | Goal) -> tuple[str, ...]:
    """The quantities that an estimator owns, or the goal."""
    return node.outputs if isinstance(node, Estimator) else (node.name,)


T = TypeVar("T")


def attempt(node: Estimator | Goal, call: Callable[[], T]) -> T:
    """Run a user's function and name its node if the shapes do not fit or a value is not there yet."""
    try:
        return call()
    except (RuntimeError, IndexError, TypeError, ValueError, KeyError) as error:
        if isinstance(error, GraphError):
            raise
        raise GraphError(f"{names(node)[0]!r} cannot be evaluated on its inputs: {error!r}") from error
