"""The watchdog: nothing moves on readings that are too old, and what is sent is finite."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.differentiation import is_nowhere
from aicon_torch.graph import WorldModel
from aicon_torch.quantities import AGE, SILENCE, Sensor
from aicon_torch.readings.validation import BEGINS
from aicon_torch.resolution import Memory

SENT = ".sent"
"""Suffix of the command that an actuator was sent last, if that is another than its action."""


def sent_memory(model: WorldModel) -> Memory:
    """What is remembered of commands before the first step, without batch dimensions."""
    nowhere: Memory = {}
    for name, quantity in model.quantities.items():
        nowhere[name] = model.like.new_zeros(quantity.shape)
    commands = model.commands(model.values(nowhere))
    return {name + SENT: torch.zeros_like(commands[name]) for name in model.declaration.commands}


def stay(
    model: WorldModel, commands: Mapping[str, Tensor], share: Tensor, memory: Memory
) -> tuple[dict[str, Tensor], Memory]:
    """The commands; rows at rest are sent their last one again, whatever is read meanwhile.

    A command that depends on estimates, such as a place to go to, would follow readings that are
    wrong.

    Args:
        model: The world model.
        commands: What is to be sent to each actuator, ``(*B, size)``.
        share: The share of its action that each row executes, ``(*B, 1)``.
        memory: The memory before the step.

    Returns:
        The commands, and what is remembered of them.
    """
    sent, remembered = dict(commands), dict[str, Tensor]()
    for name in model.declaration.commands:
        rested = (memory[name] == 0).all(-1) & ~memory[BEGINS]
        rests = rested & (share.squeeze(-1) == 0)
        last = model.actuators[name].clip_command(memory[name + SENT])
        sent[name] = torch.where(_like(rests, last), last, commands[name])
        remembered[name + SENT] = sent[name]
    return sent, remembered


def confidence(sensors: Mapping[str, Sensor], values: Mapping[str, Tensor]) -> Tensor:
    """The share of its action that a row may execute, ``(*B, 1)``: min over sensors of 2 − t/t_max.

    t is the age of a sensor's last reading, and t_max its ``max_age``, or t is for how long none
    came, and t_max its ``max_gap``: 1 up to that time, 0 from twice that time on, and 0 before an
    episode's first readings.

    Args:
        sensors: The sensors by name.
        values: The values of the step, with ages.
    """
    share = (~values[BEGINS]).to(next(iter(values.values())).dtype)
    for name, sensor in sensors.items():
        for longest, what in ((sensor.max_age, AGE), (sensor.max_gap, SILENCE)):
            if longest is not None:
                left = 2.0 - values[name + what] / longest
                share = torch.minimum(share, left.clamp(0.0, 1.0))
    return share.unsqueeze(-1)


def keep_finite(
    model: WorldModel, commands: Mapping[str, Tensor], new: Memory, old: Memory
) -> tuple[dict[str, Tensor], Memory]:
    """Commands and memory, in which rows that are not finite rest and begin anew.

    Args:
        model: The world model.
        commands: What is to be sent to each actuator, ``(*B, size)``.
        new: The memory after the step.
        old: The memory before it.

    Returns:
        The commands and the memory; a broken row keeps its old memory until its next reading.
    """
    are_finite: list[Tensor] = []
    for value in (*commands.values(), *new.values()):
        if value.is_floating_point():
            are_finite.append(_per_row(value, new[BEGINS]).isfinite().all(-1))
    broken = ~torch.stack(are_finite, dim=-1).all(-1)

    # Nothing to heal; what is done with a command does not change the memory, which has it too.
    if is_nowhere(broken):
        return {name: command.clone() for name, command in commands.items()}, new

    # Such a row stays where it was, at rest.
    healed: Memory = {}
    for key, value in new.items():
        kept = torch.where(_like(broken, value), old[key], value)
        healed[key] = kept.nan_to_num(0.0) if kept.is_floating_point() else kept
    healed[BEGINS] = new[BEGINS] | broken
    for name in model.actuators:
        healed[name] = torch.where(broken.unsqueeze(-1), 0.0, healed[name])

    at_rest = model.commands(model.values(healed))
    sent: dict[str, Tensor] = {}
    for name, command in commands.items():
        rest = at_rest[name].nan_to_num(0.0)
        sent[name] = torch.where(_like(broken, command), rest, command)
    return sent, healed


def _per_row(value: Tensor, rows: Tensor) -> Tensor:
    """The numbers of each row, ``(*B, n)``."""
    return value.flatten(rows.dim()) if value.dim() > rows.dim() else value.unsqueeze(-1)


def _like(rows: Tensor, value: Tensor) -> Tensor:
    """Flags ``(*B,)`` that broadcast with a value ``(*B, …)``."""
    return rows.reshape((*rows.shape, *[1] * (value.dim() - rows.dim())))
