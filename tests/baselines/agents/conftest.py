"""The teacher of the demonstrations, which is compiled once."""

from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import pytest


@pytest.fixture(scope="session", autouse=True)
def one_teacher() -> Iterator[None]:
    """Chunks of demonstrations are recorded by one policy for each speed and smoothing."""
    if find_spec("pymunk") is None:
        yield
        return

    from aicon_baselines.agents.diffusion import demonstrations

    build, teachers = demonstrations._make_teacher, {}

    def make_teacher(config: Any) -> Any:
        kind = (config.max_speed, config.smoothing)
        if kind not in teachers:
            teachers[kind] = build(config)
        return teachers[kind]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demonstrations, "_make_teacher", make_teacher)
        yield
