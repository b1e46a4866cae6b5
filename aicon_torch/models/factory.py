"""Policies by name: a model, a preset, and options that override it."""

import importlib
from types import ModuleType
from typing import Any

import torch

from aicon_torch.errors import OptionError, choices
from aicon_torch.models.options import replace_options
from aicon_torch.policy import Policy

MODELS = {
    "nav2d": "aicon_torch.models.nav2d",
    "pusht": "aicon_torch.models.pusht",
    "arm_push": "aicon_torch.models.arm_push",
    "reach": "aicon_torch.models.reach",
}
"""The package of each model: its ``Options``, its ``PRESETS`` and ``build(options) -> Policy``."""

ALIASES = {"panda_push": "arm_push"}
"""Names that a model had before."""


def presets(name: str | ModuleType) -> tuple[str, ...]:
    """The presets of a model, ``"aicon"`` first.

    Raises:
        OptionError: If there is no such model; it lists those there are.
    """
    return tuple(_package(name).PRESETS)


def make_policy(name: str | ModuleType, *, preset: str = "aicon", **options: Any) -> Policy:
    """Build one of the paper's policies.

    Args:
        name: Name of the model, such as ``"nav2d"``, or a module of your own that is like one: with
            ``Options``, ``PRESETS`` and ``build(options)``.
        preset: A named set of options: ``"aicon"``, ``"paper_literal"`` (nearest to the text; the
            model's presets say what is left of ours) or a baseline; :func:`presets` lists them.
        **options: Fields of the model's ``Options``, which override the preset. A field of a field
            is named by its path, such as ``"resolution.temperature"``.

    Raises:
        OptionError: If a name is unknown; it lists the valid ones.

    Example:
        >>> policy = make_policy("nav2d", max_speed=0.3, **{"resolution.exploration": None})
    """
    package = _package(name)
    owner = repr(name if isinstance(name, str) else name.__name__)
    if preset not in package.PRESETS:
        valid = choices(package.PRESETS)
        raise OptionError(f"{owner} has no preset {preset!r}. Presets: {valid}.")

    # The preset changes the defaults, and the options change the preset.
    chosen = replace_options(package.Options(), package.PRESETS[preset], owner)
    chosen = replace_options(chosen, options, owner)
    with torch.device("cpu"):  # whatever device is torch's default
        policy: Policy = package.build(chosen)
    return policy


def _package(name: str | ModuleType) -> Any:
    if isinstance(name, ModuleType):
        return name

    known = ALIASES.get(name, name)
    if known not in MODELS:
        raise OptionError(f"No model is named {name!r}. Models: {choices(MODELS)}.")
    return importlib.import_module(MODELS[known])
