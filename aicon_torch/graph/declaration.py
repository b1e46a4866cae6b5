"""What a user declares: the parts of a graph, with every name checked and every function wired."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from torch import Tensor

from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph.checks import check_clock, check_late, check_names
from aicon_torch.interconnections import Interconnection
from aicon_torch.quantities import Actuator, Sensor, as_number


@dataclass(frozen=True)
class Declaration:
    """The parts of a graph, by name.

    Attributes:
        sensors: Readings.
        actuators: Commands.
        estimators: The estimators, in the user's order.
        goals: The goals.
        constraints: What limits each actuator, one after the other.
        commands: For an actuator that takes another command than its action: what it is sent.
        metrics: For an actuator that has one: what a departure from the nominal action counts.
        dithers: For an actuator that has them: the motions of which a dither is a mixture.
        dt: Time step, s.
        clock: The sensor that tells how long the last step took, if one does.
    """

    sensors: dict[str, Sensor]
    actuators: dict[str, Actuator]
    estimators: tuple[Estimator, ...]
    goals: dict[str, Goal]
    constraints: dict[str, tuple[Interconnection, ...]]
    commands: dict[str, Interconnection]
    metrics: dict[str, Interconnection]
    dithers: dict[str, Interconnection]
    dt: float
    clock: str | None

    @classmethod
    def of(
        cls,
        sensors: Mapping[str, Sensor],
        actuators: Mapping[str, Actuator],
        estimators: Sequence[Estimator],
        goals: Sequence[Goal],
        dt: float,
        clock: str | None = None,
    ) -> "Declaration":
        """Check the names, and wire the actuators' functions.

        Raises:
            GraphError: If a name is unknown, taken or given twice, or something is no function.
        """
        # What may be read by name, and dt.
        check_names(sensors, actuators, estimators, goals)
        check_clock(clock, sensors)
        check_late(estimators, sensors)
        step = as_number(dt)
        if not 0 < step < math.inf:
            raise GraphError(f"dt={dt!r}: expected the time of a step, a number > 0, in s.")
        estimates = [name for estimator in estimators for name in estimator.outputs]
        known = [*sensors, *actuators, *estimates, "dt"]

        # Functions of an actuator read what their parameters name, as estimators do.
        constraints: dict[str, tuple[Interconnection, ...]] = {}
        commands: dict[str, Interconnection] = {}
        metrics: dict[str, Interconnection] = {}
        dithers: dict[str, Interconnection] = {}
        for name, actuator in actuators.items():
            wired = [_wired(name, function, known) for function in actuator.constraints]
            constraints[name] = tuple(wired)
            if actuator.command is not None:
                commands[name] = _wired(name, actuator.command, known)
            if actuator.metric is not None:
                metrics[name] = _wired(name, actuator.metric, known)
            if actuator.dither is not None:
                dithers[name] = _wired(name, actuator.dither, known)

        return cls(
            sensors=dict(sensors),
            actuators=dict(actuators),
            estimators=tuple(estimators),
            goals={goal.name: goal for goal in goals},
            constraints=constraints,
            commands=commands,
            metrics=metrics,
            dithers=dithers,
            dt=step,
            clock=clock,
        )

    def functions_of(self, actuator: str) -> tuple[Interconnection, ...]:
        """The constraints of an actuator, and its command, metric and dither if it has them."""
        functions = [*self.constraints[actuator]]
        for single in (self.commands, self.metrics, self.dithers):
            if actuator in single:
                functions.append(single[actuator])
        return tuple(functions)


def _wired(actuator: str, function: Callable[..., Tensor], known: Sequence[str]) -> Interconnection:
    """A function of an actuator as an interconnection whose inputs are in the graph."""
    called = f"Actuator {actuator!r}: constraints, command, metric or dither"
    relation = Interconnection.of(function, called)
    for source in relation.inputs:
        if source not in known:
            raise GraphError(
                f"{relation.function!r} of actuator {actuator!r} reads {source!r}, which is not in "
                f"the graph. Known: {choices(known)}."
            )
    return relation
