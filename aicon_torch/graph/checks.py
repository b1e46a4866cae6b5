"""Checks of a graph when it is built, and errors that name the node."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import Estimator, LateEKF
from aicon_torch.goals import Goal
from aicon_torch.graph.paths import Edge
from aicon_torch.interconnections import Values
from aicon_torch.quantities import PRESENT, Actuator, Quantity, Sensor
from aicon_torch.readings.sensor_validation import NEVER

Result = TypeVar("Result")

TAKEN = ("dt", "begins", "steps")
"""Names that a step gives to something else: see ``docs/memory.md``."""

UNREADY = (nn.modules.batchnorm._BatchNorm, nn.modules.dropout._DropoutNd)
"""Layers of networks that are something else in training."""

PRECISIONS = re.compile(r"\b(bfloat16|half|float|double)\b", re.IGNORECASE)
"""What torch calls precisions where two of them meet."""


def check_names(
    sensors: Mapping[str, Sensor],
    actuators: Mapping[str, Actuator],
    estimators: Sequence[Estimator],
    goals: Sequence[Goal],
) -> None:
    """Check that a graph has sensors, actuators and goals, and that each name stands for one thing.

    Raises:
        GraphError: If not, or if something is read that is not there; it lists the names known.
    """
    check_kinds(sensors, actuators, estimators, goals)
    outputs = [name for estimator in estimators for name in estimator.outputs]
    declared = [*sensors, *actuators, *outputs, *(goal.name for goal in goals)]

    # Each name stands for one thing, and some are taken.
    for name in declared:
        if declared.count(name) > 1:
            raise GraphError(
                f"{name!r} is declared {declared.count(name)} times; each name stands for one "
                "thing."
            )
        if name in TAKEN or "/" in name or "." in name:
            raise GraphError(
                f"{name!r} is taken: 'dt' is the time step, 'begins' and 'steps' are remembered of "
                "an episode, and '/' and '.' mark what is remembered besides."
            )
        if name == "":
            raise GraphError("A part of the graph is called '': expected a name.")

    # There is something to sense, to do and to want.
    for kind, parts in (("sensor", sensors), ("goal", goals), ("actuator", actuators)):
        if not parts:
            raise GraphError(f"{kind}s: a model needs at least one {kind}.")

    for name, sensor in sensors.items():
        if sensor.driven_by is not None and sensor.driven_by not in actuators:
            raise GraphError(
                f"Sensor {name!r}: driven_by={sensor.driven_by!r}; expected an actuator: "
                f"{choices(actuators)}."
            )

    # Everything that is read is there.
    known = [*sensors, *actuators, *outputs, "dt"]
    nodes: tuple[Estimator | Goal, ...] = (*estimators, *goals)
    for node in nodes:
        for name in node.inputs:
            if name not in known:
                hint = ""
                if name == "input":  # what most layers of torch call it
                    hint = " A layer of torch is wired by Interconnection(layer, inputs=[...])."
                raise GraphError(
                    f"{names_of(node)[0]!r} reads {name!r}, which is not in the graph. "
                    f"Known: {choices(known)}.{hint}"
                )


def check_kinds(sensors: Any, actuators: Any, estimators: Any, goals: Any) -> None:
    """Check that the parts are what they are given as.

    Raises:
        GraphError: If not.
    """
    for kind, parts, expected in (
        ("sensors", sensors, Sensor),
        ("actuators", actuators, Actuator),
    ):
        example = f"{{'name': {expected.__name__}(...)}}"
        if not isinstance(parts, Mapping):
            raise GraphError(
                f"{kind}: expected them by name, {example}, got {type(parts).__name__}."
            )
        for name, part in parts.items():
            if not isinstance(name, str) or not isinstance(part, expected):
                raise GraphError(f"{kind}: expected {example}, got in it {name!r}: {part!r}.")

    # Their order counts, so a set will not do.
    for kind, parts in (("estimators", estimators), ("goals", goals)):
        if not isinstance(parts, Iterable) or isinstance(
            parts, str | Mapping | Iterator | set | frozenset
        ):
            raise GraphError(f"{kind}: expected a list or a tuple, got {type(parts).__name__}.")

    for estimator in estimators:
        if not isinstance(estimator, Estimator):
            hint = "; call its .estimator()" if hasattr(estimator, "estimator") else ""
            raise GraphError(
                f"estimators: expected a sequence of estimators, got in it {estimator!r}{hint}."
            )
        _check_wiring(estimator)
    for goal in goals:
        if not isinstance(goal, Goal):
            raise GraphError(
                f"goals: expected a sequence of Goal('name', cost), got in it {goal!r}."
            )


def _check_wiring(estimator: Estimator) -> None:
    """Check that an estimator says what it owns, and what it reads."""
    for attribute in ("outputs", "inputs"):
        names = getattr(estimator, attribute, None)
        are_names = isinstance(names, tuple | list) and all(isinstance(name, str) for name in names)
        if not are_names or (attribute == "outputs" and not names):
            raise GraphError(
                f"estimators: {type(estimator).__name__} has {attribute}={names!r}; expected a "
                "tuple of names of quantities."
            )


def check_late(estimators: Sequence[Estimator], sensors: Mapping[str, Sensor]) -> None:
    """Check that what makes up for late readings is told how late they are, and which are missing.

    Raises:
        GraphError: If not.
    """
    for estimator in estimators:
        if not isinstance(estimator, LateEKF):
            continue
        for name in estimator.sensors:
            if name in sensors and not sensors[name].is_aged:
                raise GraphError(
                    f"{estimator.mean!r} makes up for late readings of {name!r}, which has no age: "
                    "expected Sensor(age=...) or Sensor(age_key=...)."
                )

        # A reading that is felt at once may have been missing at a step that is gone through again.
        for name in estimator.felt:
            for needed in (name, name + PRESENT):
                if name in sensors and needed not in estimator.moved_by:
                    raise GraphError(
                        f"prompt of {estimator.mean!r} reads the sensor {name!r}: moved_by has to "
                        f"remember {needed!r} of each step as well, got "
                        f"{choices(estimator.moved_by)}."
                    )


def check_clock(clock: str | None, sensors: Mapping[str, Sensor]) -> None:
    """Check that what tells how long a step took is a sensor of one number.

    Raises:
        GraphError: If it is not.
    """
    if clock is None:
        return
    if clock not in sensors:
        raise GraphError(f"clock={clock!r}: expected a sensor: {choices(sensors)}.")
    if sensors[clock].size != 1:
        raise GraphError(
            f"clock={clock!r}: the sensor has {sensors[clock].size} components; expected one, in s."
        )


def check_rows(estimators: Sequence[Estimator], quantities: Mapping[str, Quantity]) -> None:
    """Check that what is evaluated for each row reads as many rows everywhere, and vectors besides.

    Raises:
        GraphError: If not; it tells the shape that was expected.
    """
    for estimator in estimators:
        if not estimator.each:
            continue

        # What it reads: rows where `each` names it, and else a vector that all rows share.
        output = estimator.outputs[0]
        shapes = {name: quantities[name].shape for name in estimator.inputs if name != "dt"}
        count = shapes[estimator.each[0]][0]
        for name, shape in shapes.items():
            if name in estimator.each:
                fits = len(shape) == 2 and shape[0] == count
                expected = f"({count}, n), as each= names it"
            else:
                fits = len(shape) == 1
                expected = "(n,), as each= does not name it"
            if not fits:
                raise GraphError(
                    f"{output!r} reads {name!r} of shape {shape}; expected {expected}."
                )

        # What it gives: as many rows.
        own = quantities[output].shape
        if len(own) != 2 or own[0] != count:
            raise GraphError(
                f"{output!r} has shape {own}; expected ({count}, n), a value for each row."
            )


def check_reach(
    goals: Mapping[str, Goal],
    actuators: Mapping[str, Actuator],
    edges: Mapping[str, tuple[Edge, ...]],
) -> None:
    """Check that every goal depends on an actuator, and that a goal depends on every actuator.

    Raises:
        GraphError: If not.
    """
    for name, goal in goals.items():
        if name not in edges:
            raise GraphError(
                f"Goal {name!r} depends on no actuator. It reads {choices(goal.inputs)}."
            )

    reached = {edge.source for outgoing in edges.values() for edge in outgoing}
    for name in actuators:
        if name not in reached:
            raise GraphError(f"No goal depends on the actuator {name!r}. Goals: {choices(goals)}.")


def check_mode(name: str, node: nn.Module, *, trains: bool = False) -> None:
    """Check that no network is in training mode.

    Args:
        name: What the module stands for.
        node: An estimator, a goal, a function of an actuator, or a perception.
        trains: Whether all of it is about to be.

    Raises:
        GraphError: If one has a layer that mixes the rows of a batch, or acts at random.
    """
    for layer in node.modules():
        if isinstance(layer, UNREADY) and (layer.training or trains):
            raise GraphError(
                f"{name!r} has a layer {type(layer).__name__} in training mode, in which it mixes "
                "the rows of a batch or acts at random; call .eval() on the network, which learns "
                "in that mode, too."
            )


def names_of(node: Estimator | Goal) -> tuple[str, ...]:
    """The quantities that an estimator owns, or the goal."""
    return node.outputs if isinstance(node, Estimator) else (node.name,)


def attempt(node: Estimator | Goal, function: Callable[[Values], Result], values: Values) -> Result:
    """Run a user's function, and name its node where shapes do not fit or a value is not there yet.

    Raises:
        GraphError: If it fails, or returns something else than tensors.
    """
    with named_errors(node, values):
        result = function(values)

    # It ran; what it returned must be tensors.
    named = result if isinstance(result, dict) else {names_of(node)[0]: result}
    for name, value in named.items():
        if not isinstance(value, Tensor):
            raise GraphError(f"{name!r} is a {type(value).__name__}; expected a tensor of torch.")
    return result


@contextmanager
def named_errors(node: Estimator | Goal, values: Values) -> Iterator[None]:
    """Name the node, and the shapes of its inputs, in what its functions raise.

    Raises:
        GraphError: If one fails.
    """
    try:
        yield
    except GraphError:
        raise
    except (RuntimeError, IndexError, TypeError, ValueError, KeyError) as error:
        if isinstance(error, NotImplementedError) and not error.args:  # an Estimator's own
            raise GraphError(
                f"{type(node).__name__} of {names_of(node)[0]!r} lacks one of the methods initial, "
                "update and forward."
            ) from error

        # Where torch names two precisions, it is not the shapes that do not fit.
        precisions = {word.lower() for word in PRECISIONS.findall(str(error))}
        advice = f". {other_precision(_precision(values))}" if len(precisions) > 1 else ""
        raise GraphError(
            f"{names_of(node)[0]!r} cannot be evaluated on its inputs, of shapes "
            f"{_shapes(node, values)} with the batch in front: {error!r}{advice}"
        ) from error


def outputs_of(
    estimator: Estimator,
    method: str,
    values: Values,
    are_all: bool = True,
) -> dict[str, Tensor]:
    """Run a method of an estimator that returns its outputs by name.

    Args:
        estimator: The estimator.
        method: Its name.
        values: What it reads.
        are_all: Whether it has to return all of them.

    Raises:
        GraphError: If it fails, or returns something else.
    """
    result: Any = attempt(estimator, getattr(estimator, method), values)
    if isinstance(result, dict):
        unknown = [name for name in result if name not in estimator.outputs]
        missing = [name for name in estimator.outputs if name not in result]
        if not unknown and not (are_all and missing):
            return result

    got = f"those of {choices(result)}" if isinstance(result, dict) else type(result).__name__
    raise GraphError(
        f"{method} of {type(estimator).__name__} {estimator.outputs[0]!r}: expected a "
        f"dictionary with the values of {choices(estimator.outputs)}, got {got}."
    )


def check_precision(dtype: Any) -> None:
    """Reject a type that cannot hold what a step counts, such as how long there was no reading."""
    is_type = isinstance(dtype, torch.dtype) and dtype.is_floating_point
    if not (is_type and torch.finfo(dtype).max > NEVER):
        raise GraphError(
            f"dtype={dtype!r}: expected a floating-point type with numbers up to {NEVER:g}, such "
            "as torch.float32 or torch.float64."
        )


def other_precision(dtype: torch.dtype) -> str:
    """What to do about a network that computes in another precision than the graph does."""
    call, other = ".float()", torch.float64
    if dtype == torch.float64:
        call, other = ".double()", torch.float32
    return (
        f"The graph computes in {dtype}: call {call} on a network that a function uses, or give "
        f"the model dtype={other}. A network that is itself the function takes the graph's."
    )


def _precision(values: Values) -> torch.dtype:
    """The precision of the graph."""
    for value in values.values():
        if isinstance(value, Tensor) and value.is_floating_point():
            return value.dtype
    return torch.get_default_dtype()


def _shapes(node: Estimator | Goal, values: Values) -> str:
    """What a node reads and owns, with its shapes, as far as it is there."""
    shapes: list[str] = []
    for name in dict.fromkeys((*names_of(node), *node.inputs)):
        value = values.get(name)
        if isinstance(value, Tensor):
            shapes.append(f"{name} {tuple(value.shape)}")
    return ", ".join(shapes)
