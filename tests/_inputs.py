"""What the tests are run on: stacks of gradients, random world models, small graphs and recorded readings."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

import torch
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import (
    EKF,
    ActionLaw,
    Actuator,
    Affine,
    Estimator,
    Deterministic,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Resolution,
    Sensor,
    WorldModel,
    make_policy,
)
from aicon_torch.resolution import GradientStack
from aicon_torch.models import nav2d as navigation

Memory = dict[str, Tensor]

DTYPES = (torch.float32, torch.float64)
DERIVATIVES = ("model", "update", "detached_gain")
BATCHES: tuple[tuple[int, ...], ...] = ((), (1,), (3,), (2, 3))


def normal(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    """The same standard normal numbers in every run."""
    return torch.randn(shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64).to(dtype)


# --- stacks of gradients


def _random_stacks() -> dict[str, Tensor]:
    """A stack of n gradients in d dimensions for each n and d; the batch shapes take turns."""
    sizes = [(n, d) for n in range(1, 6) for d in range(1, 5)]
    return {
        f"{n} in {d}D, batch {BATCHES[i % 4]}": normal(*BATCHES[i % 4], n, d, seed=i) for i, (n, d) in enumerate(sizes)
    }


_PLAIN = normal(3, 4, 3, seed=99)
DEGENERATE: dict[str, Tensor] = {
    "all zero": torch.zeros(2, 3, 2, dtype=torch.float64),
    "one zero": torch.tensor([[0.0, 0.0], [1.0, 2.0], [-1.0, 0.5]], dtype=torch.float64),
    "all but one zero": torch.tensor([[0.0, 0.0], [0.0, 0.0], [0.3, -1.0]], dtype=torch.float64),
    "duplicates": torch.tensor([[1.0, 2.0, 0.0], [1.0, 2.0, 0.0], [0.0, 1.0, 1.0]], dtype=torch.float64),
    "nearly duplicates": torch.tensor([[1.0, 2.0, 0.0], [1.0, 2.0, 1e-9], [0.0, 1.0, 1.0]], dtype=torch.float64),
    "opposed": torch.tensor([[1.0, -1.0], [-1.0, 1.0], [0.2, 0.1]], dtype=torch.float64),
    "parallel to an axis": torch.tensor([[0.0, 1.0], [0.0, -0.7]], dtype=torch.float64),
    "equally long": torch.tensor([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]], dtype=torch.float64),
    "small": 1e-6 * _PLAIN,
    "tiny": 1e-30 * _PLAIN,
    "one tiny": torch.tensor([[1e-30, 3e-30], [1.0, 2.0], [-1.0, 0.5]], dtype=torch.float64),
    "large": 1e6 * _PLAIN,
    "huge": 1e15 * _PLAIN,
    "one huge": torch.tensor([[1e15, 3e15], [1.0, 2.0], [-1.0, 0.5]], dtype=torch.float64),
}
RANDOM = _random_stacks()
STACKS = RANDOM | DEGENERATE


def meeting(
    gradients: Tensor,
    *,
    motion: Tensor | None = None,
    goals: Sequence[str] | None = None,
    costs: Mapping[str, Tensor] | None = None,
    displaced: Callable[[str, Tensor], Tensor] | None = None,
    dt: float = 0.05,
    final: bool = True,
) -> GradientStack:
    """A meeting of gradients ``(*B, n, d)`` of goals ``g0``, ``g1``, … at a quantity at rest; ``g0+g1`` is merged."""
    count = gradients.shape[-2]
    names = goals or [f"g{i}" for i in range(count)]
    at_rest = gradients.new_zeros(gradients.shape[:-2] + gradients.shape[-1:])
    zero = gradients.new_zeros(gradients.shape[:-2])
    return GradientStack(
        gradients=gradients,
        goals=tuple(frozenset(name.split("+")) for name in names),
        motion=at_rest if motion is None else motion,
        costs=dict(costs) if costs is not None else dict.fromkeys(names, zero),
        displaced=displaced or (lambda goal, shift: zero),
        dt=dt,
        final=final,
    )


def fresh(rule: Resolution, gradients: Tensor) -> Memory:
    """What a resolution remembers before its first step, for a stack ``(*B, n, d)``."""
    batch = gradients.shape[:-2]
    state = rule.initial(gradients.shape[-2], gradients.shape[-1])
    return {
        key: value.to(gradients.dtype if value.is_floating_point() else value.dtype).expand((*batch, *value.shape))
        for key, value in state.items()
    }


# --- random world models


class Smooth:
    """tanh(b + Σ W x) + Σ V x over named quantities: smooth, nonlinear, and different for every seed.

    Around a quantity it is that quantity plus a fifth of this, so that a filter that predicts with it stays stable.
    """

    def __init__(self, reads: Mapping[str, tuple[int, ...]], rows: int, seed: int, around: str | None = None) -> None:
        self.shapes = tuple(reads.values())
        self.position = None if around is None else list(reads).index(around)
        sizes = [torch.Size(shape).numel() for shape in self.shapes]
        self.bias = normal(rows, seed=seed)
        self.inner = [normal(rows, size, seed=7 * seed + i) / size for i, size in enumerate(sizes)]
        self.outer = [normal(rows, size, seed=11 * seed + i + 1) / size for i, size in enumerate(sizes)]
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        self.__signature__ = inspect.Signature([inspect.Parameter(name, kind) for name in reads])

    def __call__(self, *inputs: Tensor) -> Tensor:
        flat = [x.flatten(-len(shape)) for x, shape in zip(inputs, self.shapes, strict=True)]
        bent = sum(((w * x.unsqueeze(-2)).sum(-1) for w, x in zip(self.inner, flat, strict=True)), self.bias)
        straight = sum((v * x.unsqueeze(-2)).sum(-1) for v, x in zip(self.outer, flat, strict=True))
        value: Tensor = torch.tanh(bent) + 0.3 * straight
        return value if self.position is None else inputs[self.position] + 0.2 * value


class Anchors(Smooth):
    """Rows ``(*B, N, n)`` that the reading places."""

    def __init__(self, rows: int, size: int, seed: int) -> None:
        super().__init__({"z": (2,)}, rows * size, seed)
        self.rows = rows

    def __call__(self, *inputs: Tensor) -> Tensor:
        rows: Tensor = super().__call__(*inputs).unflatten(-1, (self.rows, -1))  # type: ignore[no-untyped-call]
        return rows


class Cost(Smooth):
    """Half the squared length of a smooth function: a scalar cost."""

    def __call__(self, *inputs: Tensor) -> Tensor:
        return 0.5 * (super().__call__(*inputs) ** 2).sum(-1)


@dataclass(frozen=True)
class Part:
    """What a random estimator is like."""

    kind: str
    name: str
    size: int
    reads: tuple[str, ...]
    feedback: tuple[str, ...] = ()
    seed: int = 0
    derivative: Any = "model"
    rows: int = 0
    each: tuple[str, ...] = ()


@dataclass(frozen=True)
class Blueprint:
    """What a random world model is like; the same blueprint builds the same model."""

    actuators: dict[str, int]
    parts: tuple[Part, ...]
    goals: dict[str, tuple[str, ...]]

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        shapes: dict[str, tuple[int, ...]] = {name: (size,) for name, size in self.actuators.items()}
        for part in self.parts:
            shapes[part.name] = (part.rows, part.size) if part.rows else (part.size,)
            if part.kind in ("ekf", "linear"):
                shapes[f"P_{part.name}"] = (part.size, part.size)
        return shapes | {"z": (2,)}

    def build(self, goals: Sequence[str] | None = None) -> WorldModel:
        """The model in float64, with its goals in an order of choice."""
        costs = {
            name: Goal(name, Cost({read: self.shapes[read] for read in reads}, 3, 500 + i))
            for i, (name, reads) in enumerate(self.goals.items())
        }
        return WorldModel(
            sensors={"z": Sensor(2, "m")},
            actuators={name: Actuator(size, "m") for name, size in self.actuators.items()},
            estimators=[self._estimator(part) for part in self.parts],
            goals=[costs[name] for name in goals or costs],
            dt=0.1,
            dtype=torch.float64,
        )

    def _estimator(self, part: Part) -> Estimator:
        reads = {name: self.shapes[name] for name in (*part.reads, *part.feedback)}
        own = {part.name: (part.size,)}
        if part.kind == "function":
            return Deterministic(part.name, Smooth(reads, part.size, part.seed))
        if part.kind == "anchors":
            return Deterministic(part.name, Anchors(part.rows, part.size, part.seed))
        if part.kind == "rowed":  # written for one row
            each_row = {name: shape[-1:] if name in part.each else shape for name, shape in reads.items()}
            return Deterministic(part.name, Smooth(each_row, part.size, part.seed), each=part.each)
        matrices = {
            name: 0.5 * normal(part.size, *shape, seed=part.seed + i) for i, (name, shape) in enumerate(reads.items())
        }
        if part.kind == "affine":
            return Deterministic(part.name, Affine(**matrices))
        prior: Any = (normal(part.size, seed=part.seed).tolist(), 0.5)
        if part.kind == "linear":
            reading = Affine(**{part.name: normal(2, part.size, seed=part.seed), "z": -1.0})
            return KalmanFilter(
                part.name,
                f"P_{part.name}",
                predict=Affine(**{part.name: 0.9}, **matrices),
                noise=0.05,
                initial=prior,
                correct=[Measurement(reading, 0.4, size=2)],
            )
        residual = Smooth(own | {"z": (2,)}, 1, part.seed + 1)
        return EKF(
            part.name,
            f"P_{part.name}",
            predict=Smooth(own | reads, part.size, part.seed, around=part.name),
            noise=0.05,
            initial=prior,
            correct=[Measurement(residual, 0.3)],
            derivative=part.derivative,
        )


def blueprint(seed: int, derivatives: Sequence[str] = DERIVATIVES, most: int = 4) -> Blueprint:
    """Some layers of 1-2 estimators of every kind, with several actuators and goals; some of them are cyclic."""
    random = Random(seed)
    actuators = {f"a{i}": random.randint(1, 3) for i in range(random.randint(1, 2))}
    kinds = [
        random.choices(("ekf", "function", "linear", "affine"), (3, 2, 1, 1), k=random.randint(1, 2))
        for _ in range(random.randint(1, most))
    ]
    names = [[f"x{i}{j}" for j in range(len(layer))] for i, layer in enumerate(kinds)]
    vectors, everything = list(actuators), list(actuators)
    parts: list[Part] = []
    for i, layer in enumerate(kinds):
        for name, kind in zip(names[i], layer, strict=True):
            below = list(actuators) if name == "x00" else [names[i - 1][0] if i else "a0"]
            also = random.choices(everything if kind in ("function", "ekf") else vectors, k=random.randint(0, 2))
            later = [other for layer_above in names[i + 1 :] for other in layer_above]
            parts.append(
                Part(
                    kind,
                    name,
                    size=random.randint(1, 3),
                    reads=tuple(dict.fromkeys((*below, *also))),
                    feedback=(random.choice(later),) if kind == "ekf" and later and random.random() < 0.4 else (),
                    seed=random.randint(1, 10**6),
                    derivative=random.choice(derivatives) if kind == "ekf" else "model",
                )
            )
        vectors += names[i]
        everything += names[i]
        everything += [f"P_{part.name}" for part in parts if part.name in names[i] and part.kind in ("ekf", "linear")]
    states = everything[len(actuators) :]
    goals = {
        f"g{i}": tuple(dict.fromkeys((names[-1][0] if i == 0 else "x00", *random.sample(states, min(2, len(states))))))
        for i in range(random.randint(2, 3))
    }
    return Blueprint(actuators, tuple(parts), goals)


def blueprints(derivatives: Sequence[str] = DERIVATIVES) -> st.SearchStrategy[Blueprint]:
    """Random world models."""
    return st.integers(0, 2**32).map(lambda seed: blueprint(seed, derivatives))


def with_rows(base: Blueprint, seed: int) -> Blueprint:
    """The same and a layer with rows: anchors, one or two functions for each of them, and another number of rows."""
    random = Random(seed)
    vectors = [*base.actuators, *(part.name for part in base.parts)]
    lowest = "x00" if random.random() < 0.5 else "a0"
    parts: list[Part] = []

    def add(kind: str, name: str, reads: Sequence[str] = (), rows: int = 0, each: Sequence[str] = ()) -> None:
        wired = tuple(dict.fromkeys((*each, *reads)))
        size, seed = random.randint(1, 3), random.randint(1, 10**6)
        parts.append(Part(kind, name, size, wired, seed=seed, rows=rows, each=tuple(each)))

    rows = random.randint(1, 4)
    add("anchors", "r", rows=rows)
    add("rowed", "y", [lowest, random.choice(vectors)], rows, ["r"])
    ends = ["y"]
    if random.random() < 0.6:
        add("rowed", "w", [random.choice(vectors)], rows, ["r", "y"])
        ends.append("w")
    if random.random() < 0.4:
        add("anchors", "q", rows=rows + 1)
        add("rowed", "v", [lowest], rows + 1, ["q"])
        ends.append("v")
    add("function", "s", [*ends, random.choice(vectors)])
    first = next(iter(base.goals))
    goals = {**base.goals, first: (*base.goals[first], "s"), "gr": (random.choice(ends), "s")}
    return Blueprint(base.actuators, (*base.parts, *parts), goals)


def graphs(derivatives: Sequence[str] = DERIVATIVES) -> st.SearchStrategy[Blueprint]:
    """Random world models, with rows and without."""
    seeds = st.integers(0, 2**32)
    return blueprints(derivatives) | seeds.map(lambda seed: with_rows(blueprint(seed, derivatives, most=2), seed))


def readings(batch: tuple[int, ...], seed: int) -> dict[str, Tensor]:
    """What the sensor of a random world model reads."""
    return {"z": normal(*batch, 2, seed=seed)}


def actions(model: WorldModel, batch: tuple[int, ...], seed: int) -> dict[str, Tensor]:
    """Random actions for every actuator of a model."""
    sizes = [actuator.size for actuator in model.actuators.values()]
    return {
        name: 0.5 * normal(*batch, size, seed=50 * seed + i)
        for i, (name, size) in enumerate(zip(model.actuators, sizes, strict=True))
    }


def unlimited(model: WorldModel, rule: Resolution) -> Policy:
    """A policy whose action is minus the gradient, nothing else."""
    return Policy(model, rule, ActionLaw(gain=1.0, smoothing=0.0))


def in_motion(model: WorldModel, batch: tuple[int, ...] = (), steps: int = 2) -> dict[str, Tensor]:
    """Named values of a model after some steps with random readings and actions."""
    values = model.initial(readings(batch, 1), batch)
    for step in range(steps):
        values, _ = model.step(values | actions(model, batch, step) | readings(batch, step + 2))
    return values


# --- recorded readings of the navigation


def drifting(steps: int, batch: tuple[int, ...] = (), seed: int = 0) -> list[dict[str, Tensor]]:
    """Readings of an agent that comes near an obstacle again and again: the clearance swings, the bearing wanders."""
    time = 0.05 * torch.arange(steps, dtype=torch.float64)
    phase = normal(*batch, seed=seed).unsqueeze(-1)
    clearance = 0.35 + 0.3 * torch.cos(1.3 * time.reshape(-1, *(1,) * (len(batch) + 1)) + phase)
    bearing = (0.05 * normal(steps, *batch, 1, seed=seed + 1)).cumsum(0) + phase
    clearance = clearance + 0.01 * normal(steps, *batch, 1, seed=seed + 2)
    return [{"bearing": bearing[i], "range": clearance[i]} for i in range(steps)]


def with_goal(goal: Goal) -> Policy:
    """The navigation policy with a goal more, its modules untouched."""
    options = navigation.Options()
    base = navigation.world_model(options)
    model = WorldModel(
        sensors=base.sensors,
        actuators=base.actuators,
        estimators=base.nodes,
        goals=[*base.goals.values(), goal],
        dt=base.dt,
        dtype=options.dtype,
    )
    return Policy(model, navigation.resolution(options), make_policy("nav2d").law)
