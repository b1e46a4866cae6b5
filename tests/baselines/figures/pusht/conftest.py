"""The episode of the pushing figure."""

import pytest

from aicon_baselines.figures.pusht import PushRecording, record
from aicon_torch import make_policy


@pytest.fixture(scope="session")
def episode() -> PushRecording:
    return record(make_policy("pusht"), 1043)
