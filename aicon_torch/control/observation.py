"""Observations: checked where numpy becomes torch, and held where a reading is missing."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from aicon_torch.errors import ObservationError, choices
from aicon_torch.quantities import PRESENT, Sensor


def read(
    observation: Mapping[str, Any], sensors: Mapping[str, Sensor], like: Tensor
) -> dict[str, Tensor]:
    """The readings by sensor, ``(*B, size)``, in the graph's units; NaN where one is absent.

    Args:
        observation: Arrays or tensors by the sensors' keys.
        sensors: The sensors by name.
        like: A tensor of the wanted type and device.

    Raises:
        ObservationError: If a reading is missing, wrongly shaped, not real, NaN or infinite, unless
            the sensor is optional. Tensors are not checked for NaN and infinity, so that nothing
            waits for the device.
    """
    if not isinstance(observation, Mapping):
        keys = [sensor.key or name for name, sensor in sensors.items()]
        raise ObservationError(
            f"expected an observation by sensor ({choices(keys)}), got {type(observation)}."
        )

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

    for name, sensor in sensors.items():
        if name not in readings:
            readings[name] = like.new_full((*(batch or ()), sensor.size), torch.nan)
    return readings


def hold(
    readings: Mapping[str, Tensor],
    sensors: Mapping[str, Sensor],
    memory: Mapping[str, Tensor] | None = None,
    starts: Tensor | None = None,
) -> dict[str, Tensor]:
    """For optional sensors the last reading where there is none, and a flag ``(*B,)`` that says so.

    Args:
        readings: The readings by sensor.
        sensors: The sensors by name.
        memory: The memory with the last readings; None before the first step, where zero stands for
            none.
        starts: Rows ``(*B,)`` that begin an episode, where zero stands for none as well.
    """
    held = dict(readings)
    for name, sensor in sensors.items():
        if not sensor.optional:
            continue

        # Zero stands for a reading that never came.
        last = torch.zeros_like(readings[name]) if memory is None else memory[name]
        if starts is not None:
            last = torch.where(starts.unsqueeze(-1), 0.0, last)

        is_present = readings[name].isfinite().all(-1)
        held[name] = torch.where(is_present.unsqueeze(-1), readings[name], last)
        held[name + PRESENT] = is_present
    return held


def check_first_readings(
    observation: Mapping[str, Any],
    readings: Mapping[str, Tensor],
    sensors: Mapping[str, Sensor],
    needed: tuple[str, ...],
    starts: Tensor | None = None,
) -> None:
    """Check that an episode's first observation has what an estimate starts at.

    Args:
        observation: The observation; tensors in it are not checked.
        readings: The readings by sensor.
        sensors: The sensors by name.
        needed: Optional sensors that a prior reads.
        starts: Rows ``(*B,)`` that begin an episode; None for all.

    Raises:
        ObservationError: If such a reading is absent.
    """
    for name in needed:
        key = sensors[name].key or name
        if isinstance(observation.get(key), Tensor):
            continue

        is_absent = ~readings[name].isfinite().all(-1)
        if starts is not None:
            is_absent = is_absent & starts
        if is_absent.any():
            raise ObservationError(
                f"Sensor {name!r}: an episode's first observation must have a reading under "
                f"{key!r}, where an estimate starts; it has {choices(observation)}."
            )


def _reading(
    name: str, sensor: Sensor, value: Any, batch: tuple[int, ...] | None, like: Tensor
) -> Tensor:
    """One reading, checked, within the sensor's range and in the graph's unit."""
    if isinstance(value, Tensor):
        _check_shape(name, sensor, tuple(value.shape), batch)
        reading = _from_tensor(name, sensor, value, like)
    else:
        array = _as_array(name, sensor, value)
        _check_shape(name, sensor, array.shape, batch)
        reading = _from_array(name, sensor, array, like)

    if sensor.scale == 1:
        return reading
    if isinstance(sensor.scale, int | float):
        return reading * sensor.scale
    return reading * reading.new_tensor(sensor.scale)


def _from_tensor(name: str, sensor: Sensor, value: Tensor, like: Tensor) -> Tensor:
    """A tensor as a reading; nothing here waits for its device."""
    if value.is_complex():
        raise ObservationError(
            f"Sensor {name!r}: expected real numbers in {sensor.unit}, got {value.dtype}."
        )

    reading = value.detach().to(like)  # a reading is a constant of the step
    if reading.is_inference():
        reading = reading.clone()  # what comes of it must be differentiable
    return reading if sensor.range is None else reading.clamp(*sensor.range)


def _from_array(name: str, sensor: Sensor, array: NDArray[Any], like: Tensor) -> Tensor:
    """An array as a reading."""
    reading = torch.as_tensor(array, dtype=like.dtype)
    if sensor.range is not None:
        reading = reading.clamp(*sensor.range)

    is_finite = np.isfinite(array).all() and reading.isfinite().all()
    if not sensor.optional and not is_finite:
        raise ObservationError(
            f"Sensor {name!r}: expected finite values in {sensor.unit}, got NaN or infinity. "
            "Sensor(..., optional=True) declares that NaN means no reading."
        )
    return reading.to(like.device)


def _as_array(name: str, sensor: Sensor, value: ArrayLike) -> NDArray[Any]:
    """A reading as an array of real numbers."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ObservationError(
            f"Sensor {name!r}: expected an array in {sensor.unit}; {error}."
        ) from error

    if array.dtype.kind not in "fiub":
        raise ObservationError(
            f"Sensor {name!r}: expected real numbers in {sensor.unit}, got {array.dtype}."
        )
    return array


def _check_shape(
    name: str, sensor: Sensor, shape: tuple[int, ...], batch: tuple[int, ...] | None
) -> None:
    """A reading has as many components as its sensor, and the batch of those before it."""
    has_size = len(shape) > 0 and shape[-1] == sensor.size
    if has_size and batch in (None, shape[:-1]):
        return

    leading = "*batch" if batch is None else ", ".join(map(str, batch))
    raise ObservationError(
        f"Sensor {name!r}: expected shape ({leading}, {sensor.size}), got {shape}."
    )
