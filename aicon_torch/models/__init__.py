"""The paper's world models, built from the library's parts and imported by name."""

import dataclasses
import importlib
from typing import Any

from aicon_torch.errors import OptionError, choices
from aicon_torch.control import Policy

MODELS = {
    "nav2d": "aicon_torch.models.nav2d",
    "pusht": "aicon_torch.models.pusht",
    "panda_push": "aicon_torch.models.panda_push",
}
"""The module of each model: its ``Options``, its ``PRESETS`` and ``build(options) -> Policy``."""


def presets(name: str) -> tuple[str, ...]:
    """The presets of a model, ``"aicon"`` first.

    Raises:
        OptionError: If there is no such model; it lists those there are.
    """
    return tuple(_module(name).PRESETS)


def make_policy(name: str, *, preset: str = "aicon", **options: Any) -> Policy:
    """Build one of the paper's policies.

    Args:
        name: Name of the model, such as ``"nav2d"``.
        preset: A named set of options: ``"aicon"``, ``"paper_literal"`` (the text and nothing else), a baseline or an
            ablation; the model's module lists them.
        **options: Fields of the model's ``Options``, which override the preset.

    Raises:
        OptionError: If a name is unknown; it lists the valid ones.

    Example:
        >>> policy = make_policy("nav2d", max_speed=0.3)
    """
    module = _module(name)
    if preset not in module.PRESETS:
        raise OptionError(f"{name!r} has no preset {preset!r}. Presets: {choices(module.PRESETS)}.")
    valid = [field.name for field in dataclasses.fields(module.Options)]
    for option in options:
        if option not in valid:
            raise OptionError(f"{name!r} has no option {option!r}. Options: {choices(valid)}.")
    policy: Policy = module.build(module.Options(**(module.PRESETS[preset] | options)))
    return policy


def _module(name: str) -> Any:
    if name not in MODELS:
        raise OptionError(f"No model is named {name!r}. Models: {choices(MODELS)}.")
    return importlib.import_module(MODELS[name])
