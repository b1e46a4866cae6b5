"""The world model: a validated, ordered graph of sensors, actuators, estimators and goals."""

from collections.abc import Container, Mapping, Sequence
from functools import cache, partial
from typing import NamedTuple, cast

import torch
from torch import Tensor, nn

from aicon_torch.graph.drawing import flowchart
from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.interconnections import Interconnection, Values
from aicon_torch.graph.paths import Edge, PathTable
from aicon_torch.quantities import PRESENT, Actuator, Quantity, Sensor
from aicon_torch.shaping import straight_through
from aicon_torch.graph.checks import attempt, check_names, names, ordered


class LocalGraph(NamedTuple):
    """The autograd graph of one quantity or goal, one hop long: its value, from fresh leaves of what it depends on."""

    output: Tensor
    leaves: tuple[Tensor, ...]


LocalGraphs = dict[str, LocalGraph]
"""A tape for every quantity and goal that lies on a path."""


class WorldModel(nn.Module):
    """A graph of recursive estimators coupled by differentiable interconnections (Sect. "Encoding Regularities").

    It holds parameters and constants only. What lives from step to step is passed in and returned as named values.
    The parts become the model's own, which moves them to its dtype and device; build each for one model.

    Estimators run once a step, each after those it reads; where they read each other in a cycle, one of them reads the
    value of the last step, which is a constant of this step and carries no gradient.

    Args:
        sensors: Readings by name.
        actuators: Commands by name.
        estimators: The estimators, in any order.
        goals: The goals.
        dt: Time step in s, which every function may read under the name ``dt``.
        dtype: Precision of all values; by default torch's default.

    Raises:
        GraphError: If a name is unknown or given twice, a shape does not fit, a function does not let the leading
            dimensions free, functions define each other in a circle, a goal depends on no actuator, or no goal
            depends on an actuator.
    """

    def __init__(
        self,
        *,
        sensors: Mapping[str, Sensor],
        actuators: Mapping[str, Actuator],
        estimators: Sequence[Estimator],
        goals: Sequence[Goal],
        dt: float = 1.0,
        dtype: torch.dtype | None = None,
    ) -> None:
        super().__init__()
        self.sensors: dict[str, Sensor] = dict(sensors)
        self.actuators: dict[str, Actuator] = dict(actuators)
        self.dt = dt
        self.goals: dict[str, Goal] = {goal.name: goal for goal in goals}
        self.owners: dict[str, Estimator] = {name: estimator for estimator in estimators for name in estimator.outputs}
        check_names(self.sensors, self.actuators, estimators, goals)
        self.estimators = nn.ModuleList(ordered(estimators, self.owners))
        self._goal_modules = nn.ModuleList(goals)  # registers their parameters
        self._constraints, self._commands = self._wire_actuators()
        wired = (*self._commands.values(), *(one for several in self._constraints.values() for one in several))
        self._actuator_modules = nn.ModuleList(wired)
        self.register_buffer("_like", torch.zeros(()), persistent=False)  # tells dtype and device
        if dtype is not None and not dtype.is_floating_point:
            raise GraphError(f"dtype={dtype!r}: expected a floating-point type such as torch.float64.")
        self.to(dtype or torch.get_default_dtype())
        self.quantities = {name: Quantity(name, (sensor.size,)) for name, sensor in self.sensors.items()}
        self.quantities |= {name: Quantity(name, (actuator.size,), True) for name, actuator in self.actuators.items()}
        values = self._probe()
        for estimator in self.nodes:
            for name in estimator.outputs:
                self.quantities[name] = Quantity(name, tuple(values[name].shape[2:]), estimator.is_motion)
        self._check_rows()
        self._check_actuators(values)
        self._prepare(values)
        self.edges = self._find_edges(values)
        priors = {name for estimator in estimators for name in estimator.prior_inputs}
        self.first_readings = tuple(n for n, sensor in self.sensors.items() if sensor.optional and n in priors)
        self._final = self._find_final()
        self._check_reach()

    @property
    def nodes(self) -> Sequence[Estimator]:
        """The estimators in the order in which they run."""
        return cast(Sequence[Estimator], self.estimators)

    @property
    def like(self) -> Tensor:
        """A scalar of the model's dtype on its device."""
        return cast(Tensor, self._like)

    @torch.no_grad()
    def initial(self, readings: Mapping[str, Tensor], batch: tuple[int, ...]) -> dict[str, Tensor]:
        """Values before the first step: actions at rest, beliefs at their priors.

        Args:
            readings: The first readings, ``(*B, size)`` each.
            batch: The leading dimensions B.
        """
        values: dict[str, Tensor] = dict(readings)
        for name, actuator in self.actuators.items():
            values[name] = self.like.new_zeros(*batch, actuator.size)
        pending = [estimator for estimator in self.nodes if not estimator.recursive]
        for estimator in self.nodes:
            prior = attempt(estimator, partial(estimator.initial, self._with_dt(values)))
            for name, value in prior.items():
                values[name] = value.expand((*batch, *value.shape[-2 if name in estimator.covariances else -1 :]))
        for function in ordered(pending, {name: f for f in pending for name in f.outputs}):
            values |= attempt(function, partial(function.update, self._with_dt(values)))
        return values

    def step(self, values: Mapping[str, Tensor], differentiable: bool = True) -> tuple[dict[str, Tensor], LocalGraphs]:
        """Run every estimator once: update its values and, unless told otherwise, record how they depend on others.

        Args:
            values: Readings of this step, last actions, and estimates of the last step.
            differentiable: Whether to record the tapes; estimation alone needs none.

        Returns:
            The new values, and the tapes.
        """
        new = self._with_dt(values)
        tapes: LocalGraphs = {}
        for estimator in self.nodes:
            name = estimator.outputs[0]
            if differentiable and name in self._final:
                tapes[name] = self._record(name, new)
                new[name] = tapes[name].output.detach()  # its value; the tape is one hop long
            else:
                new.update(estimator.update(new))
        del new["dt"]
        result = cast(dict[str, Tensor], new)
        return result, tapes | self.record(result, known=tapes) if differentiable else {}

    def record(self, values: Mapping[str, Tensor], known: Container[str] = ()) -> LocalGraphs:
        """The tapes at given values: how each quantity and goal on a path depends on what it reads.

        Args:
            values: Values after a step.
            known: Names whose tapes are there already.
        """
        now = self._with_dt(values)
        return {name: self._record(name, now) for name in self.edges if name not in known}

    def uncut(self, values: Mapping[str, Tensor], actions: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Each goal's cost as one differentiable function of the actions, nothing detached in between.

        The same derivatives at the same values as :meth:`step` records node by node: the oracle for the sum over
        paths, and what tells each goal's predicted change.

        Args:
            values: Values after a step.
            actions: A leaf that requires a gradient for each actuator, at the action's value.
        """
        now = self._with_dt(values) | dict(actions)
        for estimator in self.nodes:
            ahead = {name: estimator(now, name) for name in estimator.outputs if name in self.edges}
            now.update((name, straight_through(values[name], output)) for name, output in ahead.items())
        return {name: goal(now) for name, goal in self.goals.items()}

    def displaced_cost(self, goal: str, quantity: str, shift: Tensor, values: Mapping[str, Tensor]) -> Tensor:
        """What a goal would cost now had a quantity been displaced, with every covariance as it is, ``(*B,)``.

        Args:
            goal: Name of the goal.
            quantity: Name of the displaced quantity.
            shift: Displacement ``(*B, n)``; of a quantity that is a motion it is the motion itself.
            values: Values after a step.
        """
        now = self._with_dt(values)
        now[quantity] = shift if self.quantities[quantity].is_motion else values[quantity] + shift
        with torch.no_grad():
            for name in self._between(goal, quantity):
                now[name] = self.owners[name](now, name)
            return cast(Tensor, self.goals[goal](now))

    @cache  # noqa: B019  # a model lives as long as its policy, and has few quantities
    def _between(self, goal: str, quantity: str) -> tuple[str, ...]:
        """The estimates, covariances excepted, by which a quantity acts on a goal, in the order of the step."""
        moved = {quantity}
        for node in self.nodes:
            for name in node.outputs:
                if name not in node.covariances and any(edge.source in moved for edge in self.edges.get(name, ())):
                    moved.add(name)
        needed = {edge.source for edge in self.edges[goal]}
        for node in reversed(self.nodes):
            for name in node.outputs:
                if name in needed & moved - {quantity}:
                    needed.update(edge.source for edge in self.edges[name])
        between = needed & moved - {quantity}
        return tuple(name for node in self.nodes for name in node.outputs if name in between)

    @torch.no_grad()
    def constrain(self, name: str, values: Mapping[str, Tensor]) -> Tensor:
        """The action of an actuator within its constraints, ``(*B, size)``."""
        now = self._with_dt(values)
        for constraint in self._constraints[name]:
            now[name] = constraint(now)
        return cast(Tensor, now[name])

    @torch.no_grad()
    def commands(self, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """What to send for each actuator: its action, or the command that brings it about."""
        now = self._with_dt(values)
        return {name: self._commands[name](now) if name in self._commands else values[name] for name in self.actuators}

    def paths(self, max_length: int | None = None) -> PathTable:
        """The table of paths from goals to actuators (Eq. 1), lazily enumerated.

        Args:
            max_length: Most quantities on a path, the actuator included; None for no bound.
        """
        return PathTable(self.edges, tuple(self.goals), tuple(self.actuators), max_length)

    def to_mermaid(self) -> str:
        """The graph as a Mermaid flowchart, to be pasted into Markdown."""
        return flowchart(self)

    def _with_dt(self, values: Mapping[str, Tensor]) -> dict[str, Tensor | float]:
        return {**values, "dt": self.dt}

    def _record(self, name: str, values: Values) -> LocalGraph:
        """Evaluate a quantity or goal on fresh leaves, detached so that its tape ends there: one factor of Eq. 1."""
        leaves = {}
        for edge in self.edges[name]:
            value = cast(Tensor, values[edge.source]).detach()
            if edge.rows:  # a copy for each row, whose gradients then come apart
                value = value.unsqueeze(-2).expand(*value.shape[:-1], edge.rows, -1)
            leaves[edge.source] = value.requires_grad_()
        inputs = {**values, **leaves}
        output = self.goals[name](inputs) if name in self.goals else self.owners[name](inputs, name)
        return LocalGraph(output, tuple(leaves.values()))

    def _wire_actuators(self) -> tuple[dict[str, list[Interconnection]], dict[str, Interconnection]]:
        """The constraints and the command of each actuator, with their names checked."""
        known = [*self.sensors, *self.actuators, *self.owners, "dt"]
        constraints: dict[str, list[Interconnection]] = {}
        commands: dict[str, Interconnection] = {}
        for name, actuator in self.actuators.items():
            functions = (*actuator.constraints, *(() if actuator.command is None else (actuator.command,)))
            if not all(callable(function) for function in functions):
                raise GraphError(
                    f"Actuator {name!r}: constraints are a sequence of functions, and command is a function."
                )
            constraints[name] = [Interconnection.of(constraint) for constraint in actuator.constraints]
            if actuator.command is not None:
                commands[name] = Interconnection.of(actuator.command)
            for function in (*constraints[name], *(commands[name] for _ in range(name in commands))):
                for source in function.inputs:
                    if source not in known:
                        raise GraphError(
                            f"{function.function!r} of actuator {name!r} reads {source!r}, which is not in the graph. "
                            f"Known: {choices(known)}."
                        )
        return constraints, commands

    @torch.no_grad()
    def _check_actuators(self, values: Mapping[str, Tensor]) -> None:
        """Constraints return an action, commands something with the batch in front."""
        now = self._with_dt(values)
        for name in self.actuators:
            shape = tuple(values[name].shape)
            functions = [*self._constraints[name], *(self._commands[name] for _ in range(name in self._commands))]
            for function in functions:
                try:
                    result = tuple(function(now).shape)
                except (RuntimeError, IndexError, TypeError, ValueError, AttributeError) as error:
                    raise GraphError(
                        f"{function.function!r} of actuator {name!r} cannot be evaluated: {error!r}"
                    ) from error
                if result[: len(shape) - 1] != shape[:-1] or (function in self._constraints[name] and result != shape):
                    raise GraphError(
                        f"{function.function!r} of actuator {name!r} returns shape {result}; expected {shape}."
                    )

    @torch.no_grad()
    def _probe(self) -> dict[str, Tensor]:
        """One step on zeros with batch (7, 5): shapes that do not follow the batch show here."""
        batch = (7, 5)
        readings = {name: self.like.new_zeros(*batch, sensor.size) for name, sensor in self.sensors.items()}
        flags = {n + PRESENT: torch.ones(batch, dtype=torch.bool) for n, s in self.sensors.items() if s.optional}
        values = self._with_dt(self.initial(readings | flags, batch))
        for estimator in self.nodes:
            updated = attempt(estimator, partial(estimator.update, values))
            for name, value in updated.items():
                before = values.get(name, value)
                if value.dim() < 3 or value.shape[:2] != batch or value.shape != cast(Tensor, before).shape:
                    own = tuple(cast(Tensor, before).shape[2:]) or "(n,), its components"
                    raise GraphError(
                        f"{name!r} has shape {tuple(value.shape)} for batch {batch}; expected the batch, then {own}. "
                        "Functions must leave leading dimensions free."
                    )
            values.update(updated)
        for name, goal in self.goals.items():
            cost = attempt(goal, partial(goal.forward, values))
            if cost.shape != batch:
                raise GraphError(
                    f"Goal {name!r}: expected a cost of the batch's shape {batch}, got {tuple(cost.shape)}."
                )
        del values["dt"]
        return cast(dict[str, Tensor], values)

    def _prepare(self, values: Mapping[str, Tensor]) -> None:
        """Let the estimators check themselves at a random point."""
        generator = torch.Generator().manual_seed(0)
        point = {
            name: torch.rand(value.shape, generator=generator, dtype=value.dtype) + 0.5
            for name, value in values.items()
            if value.is_floating_point()
        }
        optional = [name for name, sensor in self.sensors.items() if sensor.optional]
        for estimator in self.nodes:
            estimator.prepare(self._with_dt({**values, **point}), optional, PRESENT)

    def _find_edges(self, values: Mapping[str, Tensor]) -> dict[str, tuple[Edge, ...]]:
        """For each quantity and goal the quantities that its gradient goes on to, read off the autograd graph.

        Kept are the edges on a path from a goal to an actuator. An estimate that is read before it is updated in this
        step (its own last value, or that of a later estimator) is no edge.
        """
        now = self._with_dt(values)
        earlier = set(self.actuators)
        found: dict[str, list[Edge]] = {}
        nodes: tuple[Estimator | Goal, ...] = (*self.nodes, *self.goals.values())
        for node in nodes:
            sources = [name for name in node.inputs if name in earlier]
            leaves = {name: values[name].detach().clone().requires_grad_() for name in sources}
            inputs = {**now, **leaves}
            for name in names(node):
                output = node(inputs, name) if isinstance(node, Estimator) else node(inputs)
                gradients: Sequence[Tensor | None] = [None] * len(leaves)
                if leaves and output.requires_grad:
                    gradients = torch.autograd.grad(output.sum(), list(leaves.values()), allow_unused=True)
                each = node.each if isinstance(node, Estimator) else ()
                found[name] = [
                    Edge(name, source, output.shape[-2], self._rows_of(name))
                    if each and source not in each
                    else Edge(name, source)
                    for source, slope in zip(leaves, gradients, strict=True)
                    if slope is not None
                ]
            if isinstance(node, Estimator):
                earlier.update(output for output in node.outputs if found[output])
        wanted = set(self.goals)
        for name in reversed(found):
            if name in wanted:
                wanted.update(edge.source for edge in found[name])
        return {name: tuple(edges) for name, edges in found.items() if name in wanted and edges}

    def _rows_of(self, name: str) -> str:
        """The quantity that a quantity's rows go back to."""
        owner = self.owners.get(name)
        return self._rows_of(owner.each[0]) if owner is not None and owner.each else name

    def _check_rows(self) -> None:
        """What is evaluated for each row reads rows of one number, and vectors besides."""
        for node in self.nodes:
            if not node.each:
                continue
            shapes = {name: self.quantities[name].shape for name in node.inputs if name != "dt"}
            for name, shape in shapes.items():
                rows = name in node.each
                if len(shape) != 1 + rows or (rows and shape[0] != shapes[node.each[0]][0]):
                    expected = (
                        f"({shapes[node.each[0]][0]}, n), as each= names it"
                        if rows
                        else "(n,), as each= does not name it"
                    )
                    raise GraphError(f"{node.outputs[0]!r} reads {name!r} of shape {shape}; expected {expected}.")
            own, number = self.quantities[node.outputs[0]].shape, shapes[node.each[0]][0]
            if len(own) != 2 or own[0] != number:
                raise GraphError(f"{node.outputs[0]!r} has shape {own}; expected ({number}, n), a value for each row.")

    def _find_final(self) -> frozenset[str]:
        """Functions on a path whose inputs all have their new values when they run: evaluated once, not twice."""
        known = {*self.sensors, *self.actuators, "dt"}
        final = set()
        for node in self.nodes:
            if not node.recursive and node.outputs[0] in self.edges and known.issuperset(node.inputs):
                final.add(node.outputs[0])
            known.update(node.outputs)
        return frozenset(final)

    def _check_reach(self) -> None:
        for name in self.goals:
            if name not in self.edges:
                raise GraphError(f"Goal {name!r} depends on no actuator. It reads {choices(self.goals[name].inputs)}.")
        reached = {edge.source for edges in self.edges.values() for edge in edges}
        for name in self.actuators:
            if name not in reached:
                raise GraphError(f"No goal depends on the actuator {name!r}. Goals: {choices(self.goals)}.")
