"""Packages that only some parts need: loaded where they are used, named where they are missing."""

from importlib import import_module
from typing import Any


def import_extra(module: str, extra: str) -> Any:
    """Import a module that an extra of the wheel brings.

    Args:
        module: Its name, such as ``"trimesh"``.
        extra: The extra, such as ``"robots"``.

    Returns:
        The module.

    Raises:
        ModuleNotFoundError: If it is missing, or something that it needs; with the command that
            installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"{error.name} is missing; it comes with: pip install 'aicon-torch[{extra}]'",
            name=error.name,
        ) from error
