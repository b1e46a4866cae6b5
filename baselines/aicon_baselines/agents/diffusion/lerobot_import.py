"""LeRobot, which is large and not always installed, imported on demand."""

import os
from importlib import import_module
from types import ModuleType

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import pip_command


def import_lerobot(module: str) -> ModuleType:
    """Import `lerobot.<module>`; without LeRobot an error says how to get it."""
    os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")

    try:
        return import_module(f"lerobot.{module}")
    except ModuleNotFoundError as error:
        raise ComparisonError(
            f"{error}; diffusion policies need LeRobot, several gigabytes: "
            f"{pip_command('lerobot')}, or all that was tested with it: make install"
        ) from error
