"""LeRobot, which lives in a virtual environment of its own, imported on demand."""

import os
from importlib import import_module
from types import ModuleType

from aicon_baselines.evaluation.errors import ComparisonError


def import_lerobot(module: str) -> ModuleType:
    """Import `lerobot.<module>`; without LeRobot an error says how to get it."""
    os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")

    try:
        return import_module(f"lerobot.{module}")
    except ModuleNotFoundError as error:
        raise ComparisonError(
            f"{error}; diffusion policies need LeRobot, in a virtual environment of its own: "
            "make lerobot-env, then . .venv-lerobot/bin/activate "
            "(or: pip install 'aicon-torch[lerobot]')"
        ) from error
