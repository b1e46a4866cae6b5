import math
import re
from typing import Any

import pytest

from aicon_baselines.agents.diffusion.configs import (
    RecordingConfig,
    TaskRecordingConfig,
    TrainingConfig,
)
from aicon_baselines.evaluation import ComparisonError


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"steps": 0}, "steps must be 1 or more, not 0"),
        (
            {"observation": "sound"},
            "unknown observation 'sound'; valid observations: keypoints, pixels",
        ),
        ({"action_steps": 16}, "action_steps must be at most 15, not 16"),
        ({"learning_rate": 0.0}, "learning_rate must be positive, not 0.0"),
        ({"learning_rate": math.nan}, "learning_rate must be positive, not nan"),
        ({"shift": math.inf}, "shift must be finite and seed 0 or more, not inf and 100000"),
        ({"seed": -1}, "shift must be finite and seed 0 or more, not 2.0 and -1"),
        ({"down_dims": (8, 12)}, "down_dims must be multiples of 8, not (8, 12)"),
        ({"down_dims": (0,)}, "down_dims must be multiples of 8, not (0,)"),
        ({"horizon": 12}, "horizon must be a multiple of 8, 2 for each of down_dims, not 12"),
    ],
)
def test_a_training_that_makes_no_sense_is_an_error(
    arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        TrainingConfig(**{"steps": 10} | arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"noises": (0.0, math.nan)}, "noises must be one or more numbers >= 0"),
        ({"noises": (math.inf,)}, "noises must be one or more numbers >= 0"),
        ({"max_speed": math.inf}, "max_speed must be positive, not inf"),
        ({"smoothing": math.nan}, "smoothing must be positive, not nan"),
    ],
)
def test_a_recording_that_makes_no_sense_is_an_error(
    arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        RecordingConfig(**arguments)


@pytest.mark.parametrize("seed", [-1, 0, 999, 19_900, 20_000, 20_999])
def test_no_demonstration_uses_the_seeds_of_the_results(seed: int) -> None:
    for record in (RecordingConfig, lambda **own: TaskRecordingConfig("pusht", "noise_2", **own)):
        with pytest.raises(ComparisonError, match=f"0 to 999 and 20000 to 20999.*not {seed}"):
            record(seed=seed)
