"""Observations, checked where numpy becomes torch; whatever is not a reading becomes NaN."""

import difflib
import logging
import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor
from torch.masked import is_masked_tensor

from aicon_torch.errors import ObservationError, choices
from aicon_torch.quantities import AGE, Actuator, Sensor

_LOGGER = logging.getLogger(__name__)
_ma: Any = np.ma  # numpy leaves it untyped

ROUNDING = 1e-6
"""Share of a range by which a reading may exceed it: the instrument may have rounded."""

ALIKE = 0.8
"""Likeness, 0 to 1, from which on a key that nobody reads may be a misspelt one that is missing."""


def read(
    observation: Mapping[str, Any],
    sensors: Mapping[str, Sensor],
    actuators: Mapping[str, Actuator],
    like: Tensor,
) -> dict[str, Tensor]:
    """The readings by sensor, ``(*B, size)``, in the graph's units; ages and executed actions.

    A component that is masked, not finite or beyond the sensor's range is NaN, tensor or array, and
    so is what is absent; nothing waits for the device. A key that nobody reads is logged once where
    it is much like one that may be missing, and is.

    Args:
        observation: Arrays or tensors by the sensors' keys.
        sensors: The sensors by name.
        actuators: The actuators by name.
        like: A tensor of the wanted type and device.

    Raises:
        ObservationError: If a reading is wrongly shaped, not real or not dense, or if one that is
            not optional has no key.
    """
    if not isinstance(observation, Mapping):
        keys = [sensor.key_of(name) for name, sensor in sensors.items()]
        raise ObservationError(
            f"expected an observation by sensor ({choices(keys)}), got {type(observation)}."
        )

    # What is there.
    readings: dict[str, Tensor] = {}
    batch: tuple[int, ...] | None = None
    for name, sensor in sensors.items():
        key = sensor.key_of(name)
        if key in observation:
            readings[name] = _reading(_called(name, sensor), sensor, observation[key], batch, like)
            batch = tuple(readings[name].shape[:-1])
        elif not sensor.optional:
            raise ObservationError(
                f"{_called(name, sensor)}: the observation has no {key!r}; it has "
                f"{choices(observation)}. Expected shape (*batch, {sensor.size}) in {sensor.unit}."
            )

    # What is not, and how old it is.
    for name, sensor in sensors.items():
        if name not in readings:
            readings[name] = like.new_full((*(batch or ()), sensor.size), torch.nan)
        if sensor.is_aged:
            own_batch = tuple(readings[name].shape[:-1])
            readings[name + AGE] = _age(sensor, observation, own_batch, like)

    # What was executed.
    for name, actuator in actuators.items():
        if actuator.key is not None:
            shape = (*(batch or ()), actuator.size)
            readings[name] = _executed(actuator.key, observation, shape, like)

    # What may be missing may be misspelt.
    known = _keys(sensors, actuators)
    if not all(key in observation for key in known):
        _warn_of_misspelt(known, frozenset(filter(_is_word, observation.keys())))
    return readings


def _keys(sensors: Mapping[str, Sensor], actuators: Mapping[str, Actuator]) -> frozenset[str]:
    """All keys of an observation that are read."""
    keys = {sensor.key_of(name) for name, sensor in sensors.items()}
    keys |= {sensor.age_key for sensor in sensors.values() if sensor.age_key is not None}
    keys |= {actuator.key for actuator in actuators.values() if actuator.key is not None}
    return frozenset(keys)


def _is_word(key: Any) -> bool:
    return isinstance(key, str)


@lru_cache  # so that each is told once
def _warn_of_misspelt(known: frozenset[str], given: frozenset[str]) -> None:
    """Log keys that nobody reads and that are much like one that is missing."""
    for key in sorted(filter(_is_word, known - given)):
        for other in difflib.get_close_matches(key, given - known, cutoff=ALIKE):
            _LOGGER.warning(
                "The observation has no %r, which may be missing, but it has %r, which nobody "
                "reads: is it misspelt?",
                key,
                other,
            )


def _executed(
    key: str, observation: Mapping[str, Any], shape: tuple[int, ...], like: Tensor
) -> Tensor:
    """The action ``(*B, size)`` that was executed; NaN where that is not reported."""
    if key not in observation:
        return like.new_full(shape, torch.nan)

    action = as_tensor(repr(key), "the action's unit", observation[key], like)
    if tuple(action.shape) != shape:
        raise ObservationError(
            f"{key!r}: expected an action for each row, shape {shape}, got {tuple(action.shape)}."
        )
    return action


def _called(name: str, sensor: Sensor) -> str:
    """What an error calls a sensor: the user's own key first."""
    key = sensor.key_of(name)
    return f"{key!r}" if key == name else f"{key!r} (sensor {name!r})"


def _reading(
    called: str, sensor: Sensor, value: Any, batch: tuple[int, ...] | None, like: Tensor
) -> Tensor:
    """One reading, checked, NaN where there is none, in the graph's unit."""
    reading = as_tensor(called, sensor.unit, value, like)
    _check_shape(called, sensor, tuple(reading.shape), batch)
    return in_unit(reading, sensor)


def in_unit(reading: Tensor, sensor: Sensor) -> Tensor:
    """A reading ``(*B, size)`` in the graph's unit, NaN where it is none."""
    # Beyond the range, or infinite, there is no reading.
    within = reading.isfinite()
    if sensor.range is not None:
        low, high = sensor.range
        slack = ROUNDING * (high - low) if math.isfinite(high - low) else 0.0
        within = within & (reading >= low - slack) & (reading <= high + slack)
    reading = torch.where(within, reading, torch.nan)

    if sensor.scale == 1:
        return reading
    if isinstance(sensor.scale, int | float):
        return reading * sensor.scale
    return reading * reading.new_tensor(sensor.scale)


def _age(
    sensor: Sensor, observation: Mapping[str, Any], batch: tuple[int, ...], like: Tensor
) -> Tensor:
    """The age of readings ``(*B,)``, s."""
    key = sensor.age_key
    if key is None or key not in observation:
        return like.new_full(batch, sensor.age)

    age = as_tensor(repr(key), "s", observation[key], like)

    # An age may come with a dimension of its own, as readings do.
    if tuple(age.shape) == (*batch, 1):
        age = age.squeeze(-1)
    if tuple(age.shape) != batch:
        raise ObservationError(
            f"{key!r}: expected an age in s for each row of the readings, shape {batch} or "
            f"{(*batch, 1)}, got {tuple(age.shape)}."
        )
    return age


def as_tensor(called: str, unit: str, value: Any, like: Tensor) -> Tensor:
    """Numbers as a tensor of the wanted type and device, as they are; NaN where a mask is."""
    if is_masked_tensor(value):
        masked: Any = value  # torch leaves it untyped
        data = as_tensor(called, unit, masked.get_data(), like)
        return torch.where(masked.get_mask().to(like.device), data, torch.nan)

    if isinstance(value, Tensor):
        if value.is_complex() or not is_dense(value):
            raise ObservationError(
                f"{called}: expected real numbers in {unit}, got {tensor_kind(value)}."
            )
        reading: Tensor = value.detach().to(like)  # a reading is a constant of the step
        return reading.clone() if reading.is_inference() else reading  # to be differentiated by

    if value is None:
        raise ObservationError(
            f"{called}: None; where there is no reading, give NaN, or leave out the key of an "
            "optional sensor."
        )

    return torch.from_numpy(as_array(called, unit, value)).to(like)


def as_it_is(called: str, value: Any) -> Tensor | None:
    """Numbers as a tensor of their own type, NaN where a mask is; None for whatever else it is."""
    if is_masked_tensor(value):
        masked: Any = value  # torch leaves it untyped
        return torch.where(masked.get_mask(), masked.get_data(), torch.nan)
    if isinstance(value, Tensor):
        return value if is_dense(value) else None

    try:
        array = _ma.asarray(value)
    except (ValueError, TypeError, RuntimeError):  # a ragged list
        return None
    if array.dtype.kind not in "fiub":
        return None

    # torch knows one order of bytes, strides above 0, no masks, and no longer numbers.
    if _ma.is_masked(array) or array.dtype.itemsize > 8:
        return torch.from_numpy(as_array(called, "its unit", value))
    return torch.from_numpy(np.array(array, array.dtype.newbyteorder("="), order="C"))


def is_dense(tensor: Tensor) -> bool:
    """Whether a tensor holds its numbers one beside the other: not sparse, nested, or meta."""
    is_plain = tensor.layout == torch.strided and not tensor.is_nested
    return is_plain and not tensor.is_quantized and not tensor.is_meta


def tensor_kind(tensor: Tensor) -> str:
    """What an error calls a tensor that is none of dense real numbers."""
    nested = "nested, " * tensor.is_nested
    return f"a tensor of {tensor.dtype}, {nested}{tensor.layout} on {tensor.device}"


def as_array(called: str, unit: str, value: ArrayLike) -> NDArray[np.float64]:
    """Numbers as an array, as they are; NaN where a mask is."""
    try:
        array = value if type(value) is np.ndarray else _ma.asarray(value)
    except (ValueError, TypeError, RuntimeError) as error:  # a ragged list
        raise ObservationError(f"{called}: expected an array in {unit}; {error}.") from error

    if array.dtype.kind not in "fiub":
        raise ObservationError(f"{called}: expected real numbers in {unit}, got {array.dtype}.")

    # Whatever numpy has: other byte orders, other widths, reversed.
    with np.errstate(over="ignore", invalid="ignore"):  # too large a number is infinite
        numbers = array.astype(np.float64, order="C")
    filled: NDArray[np.float64] = _ma.filled(numbers, np.nan)
    return filled


def _check_shape(
    called: str, sensor: Sensor, shape: tuple[int, ...], batch: tuple[int, ...] | None
) -> None:
    """A reading has as many components as its sensor, and the batch of those before it."""
    has_size = len(shape) > 0 and shape[-1] == sensor.size
    if has_size and batch in (None, shape[:-1]):
        return

    expected = f"(*batch, {sensor.size})" if batch is None else str((*batch, sensor.size))
    raise ObservationError(f"{called}: expected shape {expected}, got {shape}.")
