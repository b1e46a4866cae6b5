"""When projection matters in a crowd: M discs pass a doorway, each with a goal behind it.

Every disc is a robot that knows where it is, and sees where the others are, but not where they
drive. Its goals are to be at its target, not to touch a wall, and not to touch each of the others:
M + 2 in all, of bounded slopes. Rule, exploration and M are varied, and nothing else. Beside them
drives ORCA, which knows the others' velocities and that they give way as well, if pyrvo is there
(pip install pyrvo). Nothing holds discs that touch; how many do is counted.

Example: python scripts/doorway.py --out runs/doorway
"""

import argparse
import csv
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, run_command

Array = NDArray[np.float64]

DT = 0.05  # s
SPEED = 1.0  # m/s
RADIUS = 0.2  # m
DOOR = 0.9  # m, so that two discs do not pass beside each other
WALL = 5.0  # m, how far the wall goes to either side
MARGIN = 0.15  # m, how far from a wall or another one it begins to cost something
SLOPE = 2.0  # of these costs; a target's is 1
TOUCH = 0.01  # m, how far discs overlap before they count as touching
DISCS = (2, 4, 8, 12)


class Cell(NamedTuple):
    """What came of one rule with so many discs.

    Attributes:
        cleared: In how many tries all discs came through.
        seconds: Median time until the last one was through, of these tries.
        untouched: In how many tries nobody touched anything.
        overlap: How far two discs overlapped at most, m.
    """

    rule: str
    discs: int
    tries: int
    cleared: int
    seconds: float
    untouched: int
    overlap: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much is tried, and where it is saved."""
    default = Path("runs/doorway")
    parser.add_argument("--out", type=Path, default=default, help="default: runs/doorway")
    parser.add_argument("--tries", type=int, default=20, help="for each cell (default: 20)")
    parser.add_argument("--seconds", type=float, default=40.0, help="of a try (default: 40)")
    parser.add_argument("--seed", type=int, default=300_000, help="of the tries (default: 300000)")


def run(arguments: argparse.Namespace) -> None:
    """Try every rule, save a row for each cell as it comes, and draw them."""
    from tqdm import tqdm

    arguments.out.mkdir(parents=True, exist_ok=True)
    names = [*rules(), *(["ORCA"] if _has_orca() else [])]
    cells: list[Cell] = []
    with (arguments.out / "cells.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(Cell._fields)
        for name, count in tqdm([(n, c) for n in names for c in DISCS], unit="cell"):
            cells.append(measure(name, count, arguments))
            table.writerow(cells[-1])
            file.flush()

    print(f"\nof {arguments.tries} tries: all through (median, s), nobody touched; largest overlap")
    print(f"{'discs':24}" + "".join(f"{count:>26}" for count in DISCS))
    for name in names:
        own = [cell for cell in cells if cell.rule == name]
        told = [
            f"{c.cleared} ({c.seconds:.0f}), {c.untouched}; {1e3 * c.overlap:.0f} mm" for c in own
        ]
        print(f"{name:24}" + "".join(f"{text:>26}" for text in told))
    draw(cells, names, arguments.out / "doorway.png")
    print(f"\nsaved in {arguments.out}: cells.csv, doorway.png")


def rules() -> dict[str, Any]:
    """What happens to gradients that meet, without and with exploration."""
    from aicon_torch import NullspaceProjection, SteepestPath, Sum

    return {
        "sum": Sum(),
        "sum, explores": NullspaceProjection(projector="none", temperature=None),
        "projection": NullspaceProjection(temperature=None, exploration=None),
        "projection, explores": NullspaceProjection(temperature=None),
        "as shipped": NullspaceProjection(),
        "steepest path": SteepestPath(),
    }


def make_policy(rule: str, count: int) -> Any:
    """One disc among so many; where the others are is read relative to it."""
    import torch
    from torch import Tensor

    from aicon_torch import (
        Actuator,
        Deterministic,
        Foresight,
        Goal,
        Interconnection,
        Policy,
        Sensor,
        WorldModel,
    )

    def nearness(length: Tensor) -> Tensor:
        return SLOPE * torch.relu(MARGIN - length)

    def reach(x: Tensor, z_target: Tensor) -> Tensor:
        return torch.linalg.vector_norm(z_target - x, dim=-1)

    def wall(side: float) -> Any:
        def cost(x: Tensor, z: Tensor) -> Tensor:
            position = z + x
            beside = torch.relu(DOOR / 2 - side * position[..., 1])
            distance = (position[..., 0].square() + beside.square() + 1e-12).sqrt()
            return nearness(distance - RADIUS)

        return cost

    def other(index: int) -> Any:
        def cost(x: Tensor, z_other: Tensor) -> Tensor:
            return nearness(torch.linalg.vector_norm(z_other - x, dim=-1) - 2 * RADIUS)

        return Interconnection(cost, ["x", f"z_other_{index}"])

    model = WorldModel(
        sensors={
            "z": Sensor(2, "m"),
            "z_target": Sensor(2, "m"),
            **{f"z_other_{index}": Sensor(2, "m") for index in range(count - 1)},
        },
        actuators={"v": Actuator(2, "m/s", limit=SPEED)},
        estimators=[
            Deterministic("x", Interconnection(lambda v, dt: v * dt, ["v", "dt"]), is_motion=True)
        ],
        goals=[
            Goal("reach", reach),
            Goal("left post", wall(1.0)),
            Goal("right post", wall(-1.0)),
            *(Goal(f"other {index}", other(index)) for index in range(count - 1)),
        ],
        dt=DT,
    )
    return Policy(model, rules()[rule], Foresight()).compile()


def drive(rule: str, discs: Array, targets: Array, steps: int) -> Array:
    """Where the discs are, ``(steps + 1, tries, M, 2)``, m, as the rule drives them."""
    tries, count, _ = discs.shape
    policy, memory, path = make_policy(rule, count), None, [discs]
    for _ in range(steps):
        here = path[-1]
        gaps = here[:, None] - here[:, :, None]  # (tries, disc, other, 2)
        observation = {"z": here.reshape(-1, 2), "z_target": (targets - here).reshape(-1, 2)}
        others = gaps[:, ~np.eye(count, dtype=bool)].reshape(tries * count, count - 1, 2)
        observation |= {f"z_other_{index}": others[:, index] for index in range(count - 1)}
        velocity, memory = policy.predict(observation, memory)

        speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
        velocity = velocity / np.maximum(speed / SPEED, 1.0)
        path.append(here + DT * velocity.reshape(here.shape))
    return np.array(path)


def drive_by_orca(discs: Array, targets: Array, steps: int) -> Array:
    """The same by optimal reciprocal collision avoidance (van den Berg et al. 2011)."""
    import pyrvo

    paths = []
    for begins, ends in zip(discs, targets, strict=True):
        simulator = pyrvo.RVOSimulator(DT, 3.0, 20, 2.0, 1.0, RADIUS + 0.02, SPEED)
        agents = [simulator.add_agent(tuple(place)) for place in begins.tolist()]
        for side in (-1.0, 1.0):
            low, high = sorted((side * DOOR / 2, side * WALL))
            simulator.add_obstacle([(0.01, low), (0.01, high), (-0.01, high), (-0.01, low)])
        simulator.process_obstacles()

        path = [begins]
        for _ in range(steps):
            for agent, end, place in zip(agents, ends, path[-1], strict=True):
                gap = end - place
                speed = min(SPEED, float(np.linalg.norm(gap)) / DT)
                wanted = gap / max(float(np.linalg.norm(gap)), 1e-9) * speed
                simulator.set_agent_pref_velocity(agent, tuple(wanted.tolist()))
            simulator.do_step()
            places = [simulator.get_agent_position(agent) for agent in agents]
            path.append(np.array([[place.x, place.y] for place in places]))
        paths.append(np.array(path))
    return np.stack(paths, axis=1)


def measure(rule: str, count: int, arguments: argparse.Namespace) -> Cell:
    """Let so many discs pass in every try."""
    discs, targets = starts(count, arguments.tries, arguments.seed)
    steps = round(arguments.seconds / DT)
    if rule == "ORCA":
        path = drive_by_orca(discs, targets, steps)
    else:
        path = drive(rule, discs, targets, steps)

    through = (path[..., 0] > RADIUS).all(-1)  # (steps + 1, tries)
    cleared = through[-1]
    times = DT * through.argmax(0)[cleared]
    overlaps = (2 * RADIUS - _distances(path)).clip(min=0.0).max((0, 2))
    beside = (DOOR / 2 - np.abs(path[..., 1])).clip(min=0.0)
    in_walls = (RADIUS - np.hypot(path[..., 0], beside)).clip(min=0.0).max((0, 2))
    untouched = int((np.maximum(overlaps, in_walls) <= TOUCH).sum())
    median = float(np.median(times)) if cleared.any() else float("nan")
    largest = round(float(overlaps.max()), 4)
    return Cell(rule, count, arguments.tries, int(cleared.sum()), median, untouched, largest)


def starts(count: int, tries: int, seed: int) -> tuple[Array, Array]:
    """Where the discs begin before the door, and their targets behind it, ``(tries, M, 2)``, m."""
    generator = np.random.default_rng([seed, count])
    discs = [_scattered(generator, count, (-4.0, -0.8)) for _ in range(tries)]
    targets = [_scattered(generator, count, (1.2, 4.4)) for _ in range(tries)]
    return np.array(discs), np.array(targets)


def _scattered(generator: np.random.Generator, count: int, along: tuple[float, float]) -> Array:
    """Places ``(count, 2)`` at least three radii apart, m."""
    places = np.empty((0, 2))
    while len(places) < count:
        place = generator.uniform((along[0], -1.5), (along[1], 1.5))
        if (np.linalg.norm(places - place, axis=-1) > 3 * RADIUS).all():
            places = np.vstack((places, place))
    return places


def _distances(path: Array) -> Array:
    """Distances of all pairs, ``(steps, tries, pairs)``, m."""
    first, second = np.triu_indices(path.shape[2], 1)
    return np.asarray(np.linalg.norm(path[:, :, first] - path[:, :, second], axis=-1))


def _has_orca() -> bool:
    try:
        import pyrvo  # noqa: F401
    except ModuleNotFoundError:
        print("without ORCA: pip install pyrvo")
        return False
    return True


def draw(cells: list[Cell], names: list[str], path: Path) -> None:
    """How many tries are cleared, how many untouched, and how long they take, over M."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    for number, name in enumerate(names):
        own = [cell for cell in cells if cell.rule == name]
        counts = [cell.discs for cell in own]
        style: dict[str, Any] = {"marker": "osD^v<>"[number], "label": name, "alpha": 0.8}
        panels[0].plot(counts, [100 * cell.cleared / cell.tries for cell in own], **style)
        panels[1].plot(counts, [100 * cell.untouched / cell.tries for cell in own], **style)
        panels[2].plot(counts, [cell.seconds for cell in own], **style)

    for panel, title in zip(
        panels,
        ("all discs through, % of the tries", "nobody touched, %", "median time of these, s"),
        strict=True,
    ):
        panel.set_title(title, fontsize=10)
        panel.set_xticks(DISCS)
        panel.set_xlabel("discs")
        panel.set_ylim(bottom=0.0)
    panels[0].legend(fontsize=8)
    figure.savefig(path, dpi=150)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
