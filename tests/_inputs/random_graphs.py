"""Random world models, cyclic ones and ones with rows included."""

from collections.abc import Sequence
from random import Random

from hypothesis import strategies as st

from _inputs.blueprints import Blueprint, Part

DERIVATIVES = ("model", "update", "detached_gain")
KINDS = {"ekf": 3, "function": 2, "linear": 1, "affine": 1}
"""How often each kind of estimator is drawn."""


def blueprints(derivatives: Sequence[str] = DERIVATIVES) -> st.SearchStrategy[Blueprint]:
    """Random world models."""
    return st.integers(0, 2**32).map(lambda seed: blueprint(seed, derivatives))


def graphs(derivatives: Sequence[str] = DERIVATIVES) -> st.SearchStrategy[Blueprint]:
    """Random world models, with rows and without."""

    def rowed(seed: int) -> Blueprint:
        return with_rows(blueprint(seed, derivatives, most=2), seed)

    return blueprints(derivatives) | st.integers(0, 2**32).map(rowed)


# --- layers of vectors


def blueprint(seed: int, derivatives: Sequence[str] = DERIVATIVES, most: int = 4) -> Blueprint:
    """Up to `most` layers of 1-2 estimators of every kind, with several actuators and goals.

    Some are cyclic.
    """
    random = Random(seed)
    actuators = {f"a{i}": random.randint(1, 3) for i in range(random.randint(1, 2))}

    layers = _layers(random, most)
    parts = _parts(random, list(actuators), layers, derivatives)
    goals = _goals(random, parts, top=next(iter(layers[-1])))

    return Blueprint(actuators, tuple(parts), goals)


def _layers(random: Random, most: int) -> list[dict[str, str]]:
    """For each layer the kind of each of its estimators, by name."""
    layers: list[dict[str, str]] = []

    for i in range(random.randint(1, most)):
        count = random.randint(1, 2)
        kinds = random.choices(list(KINDS), list(KINDS.values()), k=count)
        layers.append({f"x{i}{j}": kind for j, kind in enumerate(kinds)})

    return layers


def _parts(
    random: Random, actuators: list[str], layers: list[dict[str, str]], derivatives: Sequence[str]
) -> list[Part]:
    """The estimators.

    Each reads the first of the layer below, and some of what is there already.
    """
    parts: list[Part] = []
    below = actuators[:1]

    for i, layer in enumerate(layers):
        vectors = [*actuators, *(part.name for part in parts)]
        everything = [*actuators, *_states(parts, len(layers))]
        later = [name for layer_above in layers[i + 1 :] for name in layer_above]

        for name, kind in layer.items():
            readable = everything if kind in ("function", "ekf") else vectors
            lowest = actuators if name == "x00" else below
            parts.append(_part(random, kind, name, [*lowest], readable, later, derivatives))

        below = list(layer)[:1]

    return parts


def _part(
    random: Random,
    kind: str,
    name: str,
    below: Sequence[str],
    readable: Sequence[str],
    later: Sequence[str],
    derivatives: Sequence[str],
) -> Part:
    """One estimator.

    A filter may read a later one, as it was in the last step, which closes a cycle.
    """
    also = random.choices(readable, k=random.randint(0, 2))
    size = random.randint(1, 3)
    in_cycle = kind == "ekf" and later and random.random() < 0.4

    return Part(
        kind,
        name,
        size=size,
        reads=tuple(dict.fromkeys((*below, *also))),
        feedback=(random.choice(later),) if in_cycle else (),
        seed=random.randint(1, 10**6),
        derivative=random.choice(derivatives) if kind == "ekf" else "model",
    )


def _states(parts: Sequence[Part], layers: int) -> list[str]:
    """Means and covariances, layer by layer."""
    states: list[str] = []

    for i in range(layers):
        here = [part for part in parts if part.name.startswith(f"x{i}")]
        states += [part.name for part in here]
        states += [part.covariance for part in here if part.is_filter]

    return states


def _goals(random: Random, parts: Sequence[Part], top: str) -> dict[str, tuple[str, ...]]:
    """Two or three goals and what they read.

    The first reads the top of the graph, the others its bottom.
    """
    states = _states(parts, layers=len(parts))
    goals: dict[str, tuple[str, ...]] = {}

    for i in range(random.randint(2, 3)):
        also = random.sample(states, min(2, len(states)))
        goals[f"g{i}"] = tuple(dict.fromkeys((top if i == 0 else "x00", *also)))

    return goals


# --- rows


def with_rows(base: Blueprint, seed: int) -> Blueprint:
    """The same and a layer with rows.

    Anchors, functions of each of them, and another number of rows.
    """
    random = Random(seed)
    vectors = [*base.actuators, *(part.name for part in base.parts)]
    lowest = "x00" if random.random() < 0.5 else "a0"
    parts: list[Part] = []

    def add(
        kind: str, name: str, reads: Sequence[str] = (), rows: int = 0, each: Sequence[str] = ()
    ) -> None:
        wired = tuple(dict.fromkeys((*each, *reads)))
        size, part_seed = random.randint(1, 3), random.randint(1, 10**6)
        parts.append(Part(kind, name, size, wired, seed=part_seed, rows=rows, each=tuple(each)))

    rows = random.randint(1, 4)
    add("anchors", "r", rows=rows)
    add("rowed", "y", [lowest, random.choice(vectors)], rows, ["r"])
    ends = ["y"]

    if random.random() < 0.6:  # a second function of the same rows, which reads the first
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
