"""The world model: a graph of sensors, actuators, estimators and goals, run one step at a time."""

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple, Self

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import hop_from, undisturbed, values_only
from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph.build import build_graph, check_modes
from aicon_torch.graph.checks import check_kinds, check_precision
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.drawing import flowchart
from aicon_torch.graph.filtering import Filtered, LogFilter, check_effect
from aicon_torch.graph.information import Information, information
from aicon_torch.graph.paths import PathTable
from aicon_torch.graph.values import initial_values
from aicon_torch.interconnections import Values
from aicon_torch.learned import learned_in, make_learn, numbers_of
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.shaping import straight_through


class LocalGraph(NamedTuple):
    """The autograd graph of one quantity or goal, one hop long.

    Attributes:
        output: Its value.
        leaves: Fresh leaves of what it depends on, one for each edge.
    """

    output: Tensor
    leaves: tuple[Tensor, ...]


LocalGraphs = dict[str, LocalGraph]
"""A local graph for every quantity and goal that lies on a path."""


class WorldModel(nn.Module):
    """A graph of recursive estimators coupled by interconnections (Sect. "Encoding Regularities").

    It holds parameters and constants only. What lives from step to step is passed in and returned
    as named values. The parts become the model's own, which moves them to its dtype and device;
    build each for one model, and for those that are made of it (:meth:`with_goal`).

    Estimators run once a step, each after those it reads; where they read each other in a cycle,
    one of them reads the value of the last step, which is a constant of this step and carries no
    gradient.

    Args:
        sensors: Readings by name.
        actuators: Commands by name.
        estimators: The estimators, in any order.
        goals: The goals.
        dt: Time step in s, which every function may read under the name ``dt``.
        clock: A sensor that tells how long the last step took, s: estimators take that for ``dt``
            when they are updated, and :attr:`dt` where it does not tell. What is foreseen takes
            :attr:`dt`.
        dtype: Precision of all values; by default torch's default. They are on the CPU, whatever
            device is torch's default, until the model is moved.

    Attributes:
        declaration: The parts as they were declared.
        graph: What runs in which order, and along which edges gradients travel.
        estimators: The estimators in the order in which they run.
        owners: The estimator of each estimate.
        quantities: Sensors, actuators and estimates, with their shapes.
        edges: For each quantity and goal on a path, the quantities that its gradient goes on to.
        like: A scalar of the model's dtype on its device.

    Raises:
        GraphError: If a name is unknown or given twice, a shape does not fit, a function does not
            let the leading dimensions free or mixes the rows of a batch, functions define each
            other in a circle, a goal depends on no actuator, or no goal depends on an actuator; in
            :func:`torch.inference_mode`.
    """

    like: Tensor

    def __init__(
        self,
        *,
        sensors: Mapping[str, Sensor],
        actuators: Mapping[str, Actuator],
        estimators: Sequence[Estimator],
        goals: Sequence[Goal],
        dt: float = 1.0,
        clock: str | None = None,
        dtype: torch.dtype | None = None,
    ) -> None:
        super().__init__()
        dtype = torch.get_default_dtype() if dtype is None else dtype
        check_precision(dtype)
        if torch.is_inference_mode_enabled():
            raise GraphError(
                "A model is differentiated when it is built, which torch.inference_mode() does not "
                "allow: build it before."
            )
        declared = Declaration.of(sensors, actuators, estimators, goals, dt, clock)
        self.declaration, self.dt, self.clock = declared, declared.dt, declared.clock
        self.sensors, self.actuators = declared.sensors, declared.actuators
        self.goals = declared.goals

        # The parts become the model's own, with its precision.
        self._parts = nn.ModuleList([*estimators, *goals])
        for name in self.actuators:
            self._parts.extend(declared.functions_of(name))
        self.register_buffer("like", torch.zeros((), device="cpu"), persistent=False)
        self.to("cpu", dtype)

        # Its edges are found by differentiating it.
        with undisturbed(self.like), torch.enable_grad():
            self.graph = build_graph(declared, self.like)
        self.estimators, self.owners = self.graph.estimators, self.graph.owners
        self.quantities, self.edges = self.graph.quantities, self.graph.edges
        self._register_learned()

    def _apply(self, fn: Callable[[Tensor], Tensor], recurse: bool = True) -> "WorldModel":
        """Move it, or convert it to a precision that it can have, as ``half()`` cannot."""
        check_precision(fn(self.like).dtype)
        super()._apply(fn, recurse)  # type: ignore[no-untyped-call]  # torch's
        return self

    def train(self, mode: bool = True) -> Self:
        """Put it into training mode, which makes no difference to what can be part of a graph.

        Args:
            mode: Whether it is training mode.

        Raises:
            GraphError: If a network has a layer that would then act at random, or mix rows.
        """
        if mode:
            check_modes(self.declaration, trains=True)
        return super().train(mode)

    def with_estimator(self, estimator: Estimator, /, **sensors: Sensor) -> "WorldModel":
        """This model with an estimator more, and the sensors that it reads.

        The two share their parts.

        Args:
            estimator: The estimator.
            **sensors: Sensors by name that are new with it.

        Raises:
            GraphError: As for a model that is built.

        Example:
            >>> ball = moving_point("x_ball", "z_ball", dt=0.02)
            >>> model.with_estimator(ball, z_ball=Sensor(3, "m", key="ball"))
        """
        return self._with(estimators=[estimator], sensors=sensors)

    def with_goal(self, goal: Goal) -> "WorldModel":
        """This model with a goal more, which comes last. The two share their parts.

        Args:
            goal: The goal.

        Raises:
            GraphError: As for a model that is built.
        """
        return self._with(goals=[goal])

    def _with(
        self,
        estimators: Sequence[Estimator] = (),
        goals: Sequence[Goal] = (),
        sensors: Mapping[str, Sensor] | None = None,
    ) -> "WorldModel":
        """This model with more in it, on the same device."""
        check_kinds({}, {}, estimators, goals)
        device = self.like.device
        try:
            grown = WorldModel(
                sensors={**self.sensors, **(sensors or {})},
                actuators=self.actuators,
                estimators=[*self.declaration.estimators, *estimators],
                goals=[*self.goals.values(), *goals],
                dt=self.dt,
                clock=self.clock,
                dtype=self.like.dtype,
            )
        finally:
            self.to(device)  # a model is built on the CPU, and so were the parts of this one
        return grown.to(device)

    def learn(self, *names: str, start: Mapping[str, Any] | None = None) -> "WorldModel":
        """A copy of this model of which some numbers learn, and nothing else.

        Variances, lengths, masses and whatever else is positive stay so, by what they are computed
        from; weights of a network learn under the name of what it is in.

        Args:
            *names: The names of the numbers: see :attr:`numbers`.
            start: Where some of them start, if not where they are; a variance rather too large.

        Raises:
            GraphError: If there is no such number, or it has no effect on what is estimated or
                wanted.

        Example:
            >>> learner = model.learn("p_tar.noise", start={"p_tar.measurements.0.noise": 0.1})
            >>> optimizer = torch.optim.Adam(learner.parameters(), lr=0.05)
        """
        if start is not None and not isinstance(start, Mapping):
            raise GraphError(f"start={start!r}: expected numbers by name.")
        chosen = {**dict.fromkeys(names), **(start or {})}
        if not chosen:
            raise GraphError(f"learn: expected the name of a number: {choices(self.numbers)}.")

        model = copy.deepcopy(self)
        parameters = make_learn(model._named_parts(), chosen, self.like)
        model._register_learned()
        check_effect(model.declaration, model.graph, parameters, model.like)
        return model

    @property
    def numbers(self) -> dict[str, Tensor]:
        """What can learn, by name: the constants that the parts are made of, as they are now."""
        numbers = numbers_of(self._named_parts())
        return {name: torch.as_tensor(number.value) for name, number in numbers.items()}

    def named_parameters(self, *args: Any, **kwargs: Any) -> Iterator[tuple[str, nn.Parameter]]:
        """Those that are learned: see :meth:`learn`."""
        for name, parameter in super().named_parameters(*args, **kwargs):
            if parameter.requires_grad:
                yield name, parameter

    def _named_parts(self) -> dict[str, nn.Module]:
        """Estimators by their first output, goals, and the functions of actuators."""
        parts: dict[str, nn.Module] = {}
        for estimator in self.declaration.estimators:
            parts[estimator.outputs[0]] = estimator
        for name in self.actuators:
            for place, function in enumerate(self.declaration.functions_of(name)):
                parts[f"{name}.{place}"] = function
        return {**parts, **self.goals}

    def _register_learned(self) -> None:
        """Own what learns in the parts."""
        # torch takes no dots in the names of modules.
        learned = learned_in(self._named_parts())
        self.learned = nn.ModuleDict({name.replace(".", "/"): v for name, v in learned.items()})

    def values(self, memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The values that a memory holds: estimates, readings, actions, and the time step ``dt``.

        Args:
            memory: The memory of a policy, ``(*B, …)``.
        """
        values = {name: memory[name] for name in self.quantities}
        return {**values, "dt": self.like.new_tensor(self.dt)}

    def initial(self, readings: Mapping[str, Tensor], batch: tuple[int, ...]) -> dict[str, Tensor]:
        """Values before the first step: actions at rest, beliefs at their priors, and ``dt``.

        Args:
            readings: The first readings, ``(*B, size)`` each.
            batch: The leading dimensions B.
        """
        return initial_values(self.declaration, self.estimators, readings, batch, self.like)

    def update(self, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Run every estimator once: the new values alone, without gradients.

        Args:
            values: Readings of this step, last actions, and estimates of the last step.
        """
        # Estimators take the time that the step took, everything else the time of a step to come.
        dt = self.like.new_tensor(self.dt)
        new = {**values, "dt": dt if self.clock is None else values[self.clock]}
        for estimator in self.estimators:
            new.update(estimator.update(new))
        return {**new, "dt": dt}

    def filter(
        self,
        readings: Mapping[str, Tensor],
        actions: Mapping[str, Tensor],
        truncate: int | None = None,
    ) -> Filtered:
        """Filter a log of T steps; what comes out is differentiable by the model's parameters.

        Readings are believed, and episodes begin, as in a policy.

        Args:
            readings: Each sensor's by name, ``(*B, T, size)`` in the graph's unit, NaN where there
                is none; one that is optional may be missing. Ages under the name with ``.age``,
                ``(*B, T)``, s.
            actions: Each actuator's by name, ``(*B, T, size)``: what was done after the reading.
            truncate: After how many steps the gradient ends (truncated backpropagation through
                time); None for the whole log.

        Raises:
            ObservationError: If a name is unknown or missing, or a shape does not fit.

        Example:
            >>> loss = -model.filter({"z_tar": bearings}, {"a": velocities}).log_likelihood().mean()
        """
        with undisturbed(self.like):
            return LogFilter(self.declaration, self.graph, self.like)(readings, actions, truncate)

    def information(
        self, readings: Mapping[str, Tensor], actions: Mapping[str, Tensor]
    ) -> Information:
        """What a log tells of each number that learns, before it is trained: Fisher information.

        Args:
            readings: As for :meth:`filter`.
            actions: As for :meth:`filter`.

        Raises:
            ObservationError: As for :meth:`filter`.

        Example:
            >>> model.learn("p_tar.noise").information({"z_tar": bearings}, {"a": moves}).check()
        """
        # By the names under which they were asked for, which are not torch's.
        names = {learned.theta: name.replace("/", ".") for name, learned in self.learned.items()}
        parameters = {names.get(value, name): value for name, value in self.named_parameters()}
        with undisturbed(self.like):
            return information(self.filter(readings, actions), parameters)

    def record(self, values: Mapping[str, Tensor]) -> LocalGraphs:
        """The local graphs at given values: how each quantity and goal depends on what it reads.

        Args:
            values: Values after a step.
        """
        return {name: self._record(name, values) for name in self.edges}

    def foresee(
        self,
        values: Mapping[str, Tensor],
        actions: Mapping[str, Tensor],
        horizon: float | None = None,
    ) -> tuple[dict[str, Tensor], LocalGraphs]:
        """The values that these actions would bring within a while, and their local graphs.

        Every estimator anticipates once, from what those before it anticipate: means move as the
        model says, covariances as if the next measurements were made there.

        Args:
            values: Values after a step.
            actions: The action of each actuator, ``(*B, size)``.
            horizon: For how long they act, s, which functions then read as ``dt``; None for one
                step.

        Returns:
            The values foreseen, without the estimates that no path and no goal needs, and how
            they depend on each other.
        """
        foreseen = {**values, **actions}
        if horizon is not None:
            foreseen["dt"] = self.like.new_tensor(horizon)
        graphs: LocalGraphs = {}
        for estimator in self.estimators:
            anticipated: dict[str, Tensor] = {}

            # With a local graph where gradients come by, as a number where it is only read.
            for name in estimator.outputs:
                if name in self.edges:
                    graphs[name] = self._record(name, foreseen)
                    anticipated[name] = hop_from(graphs[name].output)  # one hop ends here
                elif name in self.graph.foreseen:
                    anticipated[name] = self._anticipate(name, foreseen)

            # Together: its outputs start from the same belief.
            for name in estimator.outputs:
                foreseen.pop(name)
            foreseen.update(anticipated)

        for name in self.goals:
            graphs[name] = self._record(name, foreseen)
        return foreseen, graphs

    def costs(self, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The cost of each goal, ``(*B,)``.

        Args:
            values: Values after a step.
        """
        return {name: goal(values) for name, goal in self.goals.items()}

    def followed_costs(self, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The cost of each goal that is no safety goal, ``(*B,)``: see :meth:`costs`."""
        return {name: goal(values) for name, goal in self.goals.items() if not goal.safety}

    def end_to_end_costs(
        self, values: Mapping[str, Tensor], actions: Mapping[str, Tensor]
    ) -> dict[str, Tensor]:
        """Each goal's cost as one differentiable function of the actions, nothing detached between.

        The same derivatives at the same values as :meth:`record` gives node by node: the oracle for
        the sum over paths, and what tells each goal's predicted change.

        Args:
            values: Values after a step.
            actions: A leaf that requires a gradient for each actuator, at the action's value.
        """
        connected: dict[str, Tensor] = {**values, **actions}
        for estimator in self.estimators:
            ahead: dict[str, Tensor] = {}
            for name in estimator.outputs:
                if name in self.edges:
                    # In value what was estimated, in derivative what the model foresees.
                    ahead[name] = straight_through(values[name], estimator(connected, name))
            connected.update(ahead)  # together: its outputs start from the same belief
        return self.costs(connected)

    def displaced_cost(
        self, goal: str, quantity: str, displacement: Tensor, values: Mapping[str, Tensor]
    ) -> Tensor:
        """What a goal would cost now had a quantity been displaced, ``(*B,)``; covariances stay.

        Args:
            goal: Name of the goal.
            quantity: Name of the displaced quantity.
            displacement: ``(*B, n)``; of a quantity that is a motion it is the motion itself.
            values: Values after a step.
        """
        # Displace the quantity, ...
        inputs = dict(values)
        if self.quantities[quantity].is_motion:
            inputs[quantity] = displacement
        else:
            inputs[quantity] = values[quantity] + displacement

        # ... and let follow what lies between it and the goal.
        for name in self._between(goal, quantity):
            inputs[name] = self.owners[name](inputs, name)
        cost: Tensor = self.goals[goal](inputs)
        return cost

    @values_only
    def constrain(
        self, actuator: str, values: Mapping[str, Tensor], on_detour: bool = False
    ) -> Tensor:
        """The action of an actuator within its constraints, ``(*B, size)``.

        Args:
            actuator: Its name.
            values: Values of the step, with the action.
            on_detour: Whether it goes elsewhere than to its targets, which do not slow it then.
        """
        # Each limits what those before it have left.
        for constraint in self.declaration.constraints[actuator]:
            if not (on_detour and getattr(constraint.function, "slows_for_targets", False)):
                values = {**values, actuator: constraint(values)}
        return values[actuator]

    @values_only
    def metric(self, actuator: str, values: Mapping[str, Tensor]) -> Tensor | None:
        """What a departure from it counts, ``(*B, size, size)``; None for all alike."""
        metric = self.declaration.metrics.get(actuator)
        return None if metric is None else metric(values)

    @values_only
    def dither(self, actuator: str, values: Mapping[str, Tensor]) -> Tensor | None:
        """The motions that a dither mixes, ``(*B, size, k)``; None for one of each component."""
        dither = self.declaration.dithers.get(actuator)
        return None if dither is None else dither(values)

    @values_only
    def commands(self, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """What to send for each actuator: its action, or the command that brings it about."""
        commands: dict[str, Tensor] = {}
        for name in self.actuators:
            command = self.declaration.commands.get(name)
            if command is None:
                commands[name] = values[name]
            else:
                commands[name] = self.actuators[name].clip_command(command(values))
        return commands

    def paths(self) -> PathTable:
        """The table of paths from goals to actuators (Eq. 1), lazily enumerated."""
        return PathTable(self.edges, tuple(self.goals), tuple(self.actuators))

    def to_mermaid(self) -> str:
        """The graph as a Mermaid flowchart, to be pasted into Markdown."""
        return flowchart(self.declaration, self.graph)

    def _record(self, name: str, values: Values) -> LocalGraph:
        """Evaluate a quantity or goal on fresh leaves: one factor of Eq. 1."""
        leaves: dict[str, Tensor] = {}
        for edge in self.edges[name]:
            value = hop_from(values[edge.source])
            if edge.rows:  # a copy for each row, whose gradients then come apart
                value = value.unsqueeze(-2).expand(*value.shape[:-1], edge.rows, -1)
            leaves[edge.source] = value.requires_grad_()

        # One hop: whatever else it reads is a constant of it.
        inputs = {**values, **leaves}
        if name in self.goals:
            output = self.goals[name](inputs)
        else:
            output = self.owners[name](inputs, name)
        return LocalGraph(output, tuple(leaves.values()))

    @values_only
    def _anticipate(self, name: str, values: Values) -> Tensor:
        """One step ahead, a quantity on no path: as a number."""
        anticipated: Tensor = self.owners[name](values, name)
        return anticipated

    @cache  # noqa: B019  # a model lives as long as its policy, and has few quantities
    def _between(self, goal: str, quantity: str) -> tuple[str, ...]:
        """The estimates by which a quantity acts on a goal, in the order of the step."""
        # Forward: what moves with the quantity, covariances excepted.
        moved = {quantity}
        for name in self._means():
            if any(edge.source in moved for edge in self.edges.get(name, ())):
                moved.add(name)

        # Backward: what the goal needs of it.
        needed = {edge.source for edge in self.edges[goal]}
        between: list[str] = []
        for name in reversed(list(self._means())):
            if name in needed and name in moved and name != quantity:
                needed.update(edge.source for edge in self.edges[name])
                between.append(name)
        return tuple(reversed(between))

    def _means(self) -> Iterator[str]:
        """The estimates that are no covariances, in the order of the step."""
        for estimator in self.estimators:
            for name in estimator.outputs:
                if name not in estimator.covariances:
                    yield name
