"""What random world models are stepped with."""

from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import DirectDescent, Policy, Resolution, WorldModel


def readings(batch: tuple[int, ...], seed: int) -> dict[str, Tensor]:
    """What the sensor of a random world model reads."""
    return {"z": normal(*batch, 2, seed=seed)}


def actions(model: WorldModel, batch: tuple[int, ...], seed: int) -> dict[str, Tensor]:
    """Random actions for every actuator of a model."""
    return {
        name: 0.5 * normal(*batch, actuator.size, seed=50 * seed + i)
        for i, (name, actuator) in enumerate(model.actuators.items())
    }


def in_motion(model: WorldModel, batch: tuple[int, ...] = (), steps: int = 2) -> dict[str, Tensor]:
    """Named values of a model after some steps with random readings and actions."""
    values = model.initial(readings(batch, 1), batch)

    for step in range(steps):
        values = model.update(values | actions(model, batch, step) | readings(batch, step + 2))

    return values


def unlimited(model: WorldModel, rule: Resolution) -> Policy:
    """A policy whose action is minus the gradient, nothing else."""
    return Policy(model, rule, DirectDescent(gain=1.0, smoothing=0.0))


def moved(
    policy: Policy, batch: tuple[int, ...] = ()
) -> tuple[dict[str, Tensor], dict[str, Tensor]]:
    """The memory after a step away from rest, and the memory before it, with the actions that were
    taken.
    """
    _, start = policy.predict(readings(batch, 1))
    start |= actions(policy.model, batch, 3)

    _, memory = policy.predict(readings(batch, 2), start)
    return memory, start


def quantities(model: WorldModel, memory: dict[str, Tensor], action: Tensor) -> dict[str, Tensor]:
    """The values of a model's quantities after a step, with the action ``a`` that led there."""
    return model.values(memory) | {"a": action}


def remembered(model: WorldModel, values: dict[str, Tensor]) -> dict[str, Tensor]:
    """What a memory keeps of the values of a model."""
    return {name: values[name] for name in model.quantities}
