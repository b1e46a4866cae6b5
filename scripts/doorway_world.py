"""The world of `doorway.py`: discs that pass a door of a wall x = 0, and what drives them."""

from importlib.util import find_spec
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    Foresight,
    Goal,
    Interconnection,
    Policy,
    Resolution,
    Sensor,
    WorldModel,
)

Array = NDArray[np.float64]

DT = 0.05  # s
SPEED = 1.0  # m/s
RADIUS = 0.2  # m
DOOR = 0.9  # m, so that two discs do not pass beside each other
WALL = 5.0  # m, how far the wall goes to either side
MARGIN = 0.15  # m, how far from a wall or another one it begins to cost something
SLOPE = 2.0  # of these costs; a target's is 1


def make_policy(resolution: Resolution, count: int) -> Policy:
    """One disc among so many; where the others are is read relative to it."""

    def nearness(length: Tensor) -> Tensor:
        near: Tensor = SLOPE * torch.relu(MARGIN - length)
        return near

    def reach(x: Tensor, z_target: Tensor) -> Tensor:
        distance: Tensor = torch.linalg.vector_norm(z_target - x, dim=-1)
        return distance

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
    return Policy(model, resolution, Foresight()).compile()


def drive(resolution: Resolution, discs: Array, targets: Array, steps: int) -> Array:
    """Where the discs are, ``(steps + 1, tries, M, 2)``, m, as the rule drives them."""
    tries, count, _ = discs.shape
    policy, memory, path = make_policy(resolution, count), None, [discs]
    for _ in range(steps):
        here = path[-1]
        gaps = here[:, None] - here[:, :, None]  # (tries, disc, other, 2)
        observation: dict[str, Array] = {
            "z": here.reshape(-1, 2),
            "z_target": (targets - here).reshape(-1, 2),
        }
        others = gaps[:, ~np.eye(count, dtype=bool)].reshape(tries * count, count - 1, 2)
        observation |= {f"z_other_{index}": others[:, index] for index in range(count - 1)}
        velocity, memory = policy.predict(observation, memory)

        speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
        velocity = velocity / np.maximum(speed / SPEED, 1.0)
        path.append(here + DT * velocity.reshape(here.shape))
    return np.array(path)


def drive_by_orca(discs: Array, targets: Array, steps: int) -> Array:
    """The same by optimal reciprocal collision avoidance (van den Berg et al. 2011)."""
    import pyrvo  # type: ignore[import-not-found]  # optional

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


def has_orca() -> bool:
    """Whether its library is there; it says so where it is not."""
    is_there = find_spec("pyrvo") is not None
    if not is_there:
        print("without ORCA: pip install pyrvo")
    return is_there


def starts(count: int, tries: int, seed: int) -> tuple[Array, Array]:
    """Where the discs begin before the door, and their targets behind it, ``(tries, M, 2)``, m."""
    generator = np.random.default_rng([seed, count])
    discs = [_scattered(generator, count, (-4.0, -0.8)) for _ in range(tries)]
    targets = [_scattered(generator, count, (1.2, 4.4)) for _ in range(tries)]
    return np.array(discs), np.array(targets)


def _scattered(generator: np.random.Generator, count: int, along: tuple[float, float]) -> Array:
    """Places ``(count, 2)`` at least three radii apart, m."""
    places: Array = np.empty((0, 2))
    while len(places) < count:
        place = generator.uniform((along[0], -1.5), (along[1], 1.5))
        if (np.linalg.norm(places - place, axis=-1) > 3 * RADIUS).all():
            places = np.vstack((places, place))
    return places
