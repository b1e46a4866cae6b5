"""Observations: checked where numpy becomes torch, and held where a reading is missing."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from aicon_torch.errors import ObservationError, choices
from aicon_torch.quantities import PRESENT, Sensor


def read(observation: Mapping[str, Any], sensors: Mapping[str, Sensor], like: Tensor) -> dict[str, Tensor]:
    """The readings by sensor, ``(*B, size)``, in the type and on the device of ``like``; NaN where one is absent.

    Args:
        observation: Arrays or tensors by the sensors' keys.
        sensors: The sensors by name.
        like: A tensor of the wanted type and device.

    Raises:
        ObservationError: If a reading is missing, wrongly shaped, not real, NaN or infinite, unless the sensor is
            optional. Tensors are not checked for NaN and infinity, so that nothing waits for the device.
    """
    if not isinstance(observation, Mapping):
        keys = [sensor.key or name for name, sensor in sensors.items()]
        raise ObservationError(f"expected an observation by sensor ({choices(keys)}), got {type(observation)}.")
    readings: dict[str, Tensor] = {}
    batch: tuple[int, ...] | None = None
    for name, sensor in sensors.items():
        key = sensor.key or name
        if key in observation:
            readings[name] = _reading(name, sensor, observation[key], batch, like)
            batch = tuple(readings[name].shape[:-1])
        elif not sensor.optional:
            raise ObservationError(
                f"Sensor {name!r}: the observation has no {key!r}; it has {choices(observation)}. "
                f"Expected shape (*batch, {sensor.size}) in {sensor.unit}."
            )
    absent = {name: sensor.size for name, sensor in sensors.items() if name not in readings}
    return readings | {name: like.new_full((*(batch or ()), size), torch.nan) for name, size in absent.items()}


def hold(
    readings: Mapping[str, Tensor],
    sensors: Mapping[str, Sensor],
    state: Mapping[str, Tensor] | None = None,
    start: Tensor | None = None,
) -> dict[str, Tensor]:
    """For optional sensors the last reading where there is none, and a flag ``(*B,)`` that says so.

    Args:
        readings: The readings by sensor.
        sensors: The sensors by name.
        state: The memory with the last readings; None before the first step, where zero stands for none.
        start: Rows ``(*B,)`` that begin an episode, where zero stands for none as well.
    """
    held = dict(readings)
    for name, sensor in sensors.items():
        if sensor.optional:
            present = readings[name].isfinite().all(-1)
            last = torch.zeros_like(readings[name]) if state is None else state[name]
            if start is not None:
                last = torch.where(start.unsqueeze(-1), 0.0, last)
            held[name] = torch.where(present.unsqueeze(-1), readings[name], last)
            held[name + PRESENT] = present
    return held


def _reading(name: str, sensor: Sensor, value: Any, batch: tuple[int, ...] | None, like: Tensor) -> Tensor:
    array = value if isinstance(value, Tensor) else _array(name, sensor, value)
    if isinstance(array, Tensor) and array.is_complex():
        raise ObservationError(f"Sensor {name!r}: expected real numbers in {sensor.unit}, got {array.dtype}.")
    shape = tuple(array.shape)
    if not shape or shape[-1] != sensor.size or (batch is not None and shape[:-1] != batch):
        leading = "*batch" if batch is None else ", ".join(map(str, batch))
        raise ObservationError(f"Sensor {name!r}: expected shape ({leading}, {sensor.size}), got {shape}.")
    if isinstance(array, Tensor):
        reading = array.detach().to(like)
        reading = reading.clone() if reading.is_inference() else reading  # what comes of it must be differentiable
    else:
        reading = torch.as_tensor(array, dtype=like.dtype)
    if sensor.range is not None:
        reading = reading.clamp(*sensor.range)
    if not isinstance(array, Tensor):
        if not sensor.optional and not (np.isfinite(array).all() and reading.isfinite().all()):
            raise ObservationError(
                f"Sensor {name!r}: expected finite values in {sensor.unit}, got NaN or infinity. "
                "Sensor(..., optional=True) declares that NaN means no reading."
            )
        reading = reading.to(like.device)
    return reading if sensor.scale == 1 else reading * reading.new_tensor(sensor.scale)


def _array(name: str, sensor: Sensor, value: ArrayLike) -> NDArray[Any]:
    """The reading as an array of real numbers."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ObservationError(f"Sensor {name!r}: expected an array in {sensor.unit}; {error}.") from error
    if array.dtype.kind not in "fiub":
        raise ObservationError(f"Sensor {name!r}: expected real numbers in {sensor.unit}, got {array.dtype}.")
    return array
