"""The episode of the pushing figure."""

import pytest
from _inputs import driven

from aicon_baselines.figures.pusht import PushRecording, record


@pytest.fixture(scope="session")
def episode() -> PushRecording:
    return record(driven("pusht"), 1043)
