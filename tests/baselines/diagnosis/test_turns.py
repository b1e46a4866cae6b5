"""The turns of an episode: what led, and what stood against what."""

import numpy as np
import pytest

from aicon_baselines.diagnosis.history import ActuatorCurve, History, MeetingCurve
from aicon_baselines.diagnosis.turns import find_turns

TOWARD, AWAY = "reach → x → a", "avoid → x → a"


def history(leads: list[str], exploring: list[bool]) -> History:
    """An episode in which `avoid` stands against `reach` at x, and these paths led."""
    count = len(leads)
    zeros = np.zeros(count)
    meeting = MeetingCurve(
        labels=("reach → x", "avoid → x"),
        goals=("reach", "avoid"),
        magnitudes=np.ones((count, 2)),
        dominant=np.zeros(count, np.int64),
        opponent=np.ones(count, np.int64),
        cosine=-np.ones(count),
        exploring=np.array(exploring),
    )
    curve = ActuatorCurve(zeros[:, np.newaxis], zeros, zeros.astype(bool), leads=tuple(leads))
    return History(0.1, zeros[:, np.newaxis], meetings={"x": meeting}, actuators={"a": curve})


def test_a_turn_lasts_as_long_as_the_same_path_leads() -> None:
    first, second = find_turns(history([TOWARD] * 30 + [AWAY] * 20, [False] * 50))
    assert (first.begin, first.leads, first.conflicts) == (0.0, (TOWARD,), ())
    assert first.end == second.begin == pytest.approx(3.0)
    assert (second.leads, second.end) == ((AWAY,), pytest.approx(5.0))


def test_it_says_what_stands_against_what_while_it_explores() -> None:
    _, turn, _ = find_turns(history([TOWARD] * 9, [False] * 3 + [True] * 3 + [False] * 3))
    assert turn.conflicts == ("at x: reach → x against avoid → x",)
    assert str(turn) == (
        "0.3 to 0.6 s:\n  reach → x → a\n  exploring at x: reach → x against avoid → x"
    )


def test_what_is_interrupted_for_a_moment_is_one_turn() -> None:
    leads = [TOWARD] * 120 + [AWAY] + [TOWARD] * 120
    (turn,) = find_turns(history(leads, [False] * len(leads)))
    assert turn.end == pytest.approx(24.1)
