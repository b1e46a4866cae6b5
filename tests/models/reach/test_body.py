"""The body of an arm behind a shield: its watchdog, and what it refuses."""

import math
from typing import Any

import numpy as np
import pytest
from _inputs.reaching import planar_arm

from aicon_torch import OptionError, Shield
from aicon_torch.models.reach import Options, body_model
from aicon_torch.models.reach.graph import world_model

Q, BALL = np.array([0.3, 0.4, 0.5]), np.array([5.0, 5.0, 5.0])
STEPS = 6


def drive(model: Any, joints: Any, ball: Any, moves: bool) -> Any:
    """The action after some steps that go on, and some more with other readings."""
    shield = Shield(lambda _: np.array([0.5, 0.0, 0.0]), model)
    q, state = Q.copy(), None
    for step in range(2 * STEPS):
        if step < STEPS:
            seen = {"q": q, "ball_1": BALL}
        else:
            seen = {"q": q if joints is None else joints, "ball_1": ball}
        action, state = shield.predict(seen, state)
        q = q + model.dt * action * (moves or step < STEPS)
    return action


@pytest.mark.parametrize(
    ("joints", "ball", "moves", "rests"),
    [
        (None, BALL, True, False),
        (np.full(3, np.nan), BALL, True, True),
        (None, np.full(3, np.nan), True, True),
        (None, BALL, False, True),
    ],
    ids=["all is read", "no joints", "no ball", "frozen joints"],
)
def test_a_shielded_arm_rests_on_what_is_too_old_or_frozen_unless_it_has_no_watchdog(
    joints: Any, ball: Any, moves: bool, rests: bool
) -> None:
    options: dict[str, Any] = {"robot": planar_arm(), "balls": 1}
    action = drive(body_model(Options(**options)), joints, ball, moves)
    assert bool(action.any()) == (not rests)

    action = drive(body_model(Options(**options, watchdog=False)), joints, ball, moves)
    np.testing.assert_allclose(action, (0.5, 0.0, 0.0), atol=1e-6)


@pytest.mark.parametrize("watchdog", [True, False])
def test_a_shielded_arm_reads_its_body_as_an_arm_that_reaches_does(watchdog: bool) -> None:
    options = Options(robot=planar_arm(), balls=2, obstacles=3, watchdog=watchdog)
    reaches = world_model(options).sensors
    for name, sensor in body_model(options).sensors.items():
        assert sensor == reaches[name]


@pytest.mark.parametrize("table", [math.nan, math.inf, -math.inf, True, "low", (0.0, 0.1)])
def test_a_table_that_is_no_number_is_refused(table: Any) -> None:
    with pytest.raises(OptionError, match="table=.*: expected 1 finite number"):
        body_model(Options(robot=planar_arm()), table)


def test_what_are_no_options_is_refused() -> None:
    with pytest.raises(OptionError, match=r"options='ur5.urdf': expected Options, such as"):
        body_model("ur5.urdf")  # type: ignore[arg-type]  # wrong on purpose
