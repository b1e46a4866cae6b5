"""Seeds, options, masks and modes of the sub-environments of a vector environment."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from aicon_envs.arrays import BoolArray
from aicon_envs.checks import check_integer, copy_options, is_sequence

_AUTORESET_MODES = (AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED)


def check_autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Return the mode as a member of `AutoresetMode`.

    Raises:
        ValueError: If it is neither "NextStep" nor "Disabled".
    """
    for supported in _AUTORESET_MODES:
        if mode in (supported, supported.value):
            return supported

    valid = ", ".join(str(supported) for supported in _AUTORESET_MODES)
    raise ValueError(f"autoreset_mode must be one of {valid}, got {mode!r}")


def check_reset_mask(mask: Any, num_envs: int) -> BoolArray:
    """Return the mask of the sub-environments to reset, (N,); all of them without one.

    Raises:
        ValueError: If it is not a boolean array of that shape, or selects none.
    """
    if mask is None:
        return np.ones(num_envs, dtype=np.bool_)

    array = np.asarray(mask)
    if array.shape != (num_envs,) or array.dtype != np.bool_ or not array.any():
        raise ValueError(
            f"reset_mask must be a boolean array of shape ({num_envs},) with at least one True, "
            f"got {mask!r}"
        )

    return array


def split_seed(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    """Return the seed of each sub-environment: s + i for an integer s, or what a list says.

    Raises:
        ValueError: If it is neither, or a list has another length or other entries.
    """
    if seed is None:
        return [None] * num_envs

    if isinstance(seed, (int, np.integer)):
        return [int(seed) + index for index in range(num_envs)]

    if not is_sequence(seed) or len(seed) != num_envs:
        raise ValueError(f"seed must be one integer or {num_envs} of them, got {seed!r}")
    return [None if each is None else check_integer("seed", each, 0) for each in seed]


def split_options(
    options: Mapping[str, Any], num_envs: int, listable: Collection[str] = ()
) -> list[dict[str, Any]]:
    """Return the options of each sub-environment.

    Args:
        options: The options of one environment, for all. Alternatively `per_env`: a sequence of
            num_envs dictionaries, the options of each.
        num_envs: Number of sub-environments.
        listable: Names of the options whose value may be a sequence, one entry for each.

    Raises:
        ValueError: If a sequence has another length, or `per_env` comes with other options.
    """
    if "per_env" in options:
        if len(options) > 1:
            raise ValueError(f"per_env excludes other options, got {', '.join(map(str, options))}")
        entries = _one_entry_each("per_env", options["per_env"], num_envs)
        return [copy_options(entry) for entry in entries]

    # Deal the value of each option out to the sub-environments.
    split: list[dict[str, Any]] = [{} for _ in range(num_envs)]
    for name, value in options.items():
        values = [value] * num_envs
        if name in listable and is_sequence(value):
            values = _one_entry_each(name, value, num_envs)

        for own_options, own_value in zip(split, values, strict=True):
            own_options[name] = own_value

    return split


def _one_entry_each(name: str, values: Any, num_envs: int) -> list[Any]:
    if not is_sequence(values) or len(values) != num_envs:
        raise ValueError(
            f"{name} must have one entry for each of the {num_envs} sub-environments, "
            f"got {values!r}"
        )

    return list(values)
