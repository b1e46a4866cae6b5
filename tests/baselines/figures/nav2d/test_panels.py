"""The moments of the navigation figure are in order and show the story."""

import numpy as np
import pytest
from _inputs import driven, lean

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures.nav2d import NavigationRecording, NavigationRollout, record
from aicon_baselines.figures.rollout import choose_panels, summarize

WITHOUT_EXPLORATION = {"resolution.exploration": None}


def test_panels_are_in_order(recording: NavigationRecording) -> None:
    rollout = NavigationRollout(recording)
    panels = choose_panels(rollout)
    steps = [panel.step for panel in panels]
    assert [panel.label for panel in panels] == list("abcdef")
    assert steps[0] >= 1
    assert steps[-1] == recording.steps - 1
    assert all(np.diff(steps) > 0)

    times = [panel["time_s"] for panel in summarize(rollout, panels)["panels"]]
    assert all(np.diff(times) > 0)


def test_panels_are_in_order_without_exploration() -> None:
    recording = record(lean("nav2d", **WITHOUT_EXPLORATION), "u_trap_05", 1000, limit=60)
    steps = [panel.step for panel in choose_panels(NavigationRollout(recording))]
    assert recording.explorations == []
    assert all(np.diff(steps) > 0)


def test_too_short_a_rollout_is_an_error() -> None:
    recording = record(driven("nav2d"), "u_trap_05", 1000, limit=6)
    with pytest.raises(ComparisonError, match="6 steps"):
        choose_panels(NavigationRollout(recording))


def test_the_default_rollout_shows_the_story() -> None:
    recording = record(driven("nav2d"), "u_trap_2", 1006)
    titles = [panel.title for panel in choose_panels(NavigationRollout(recording))]

    assert recording.ending == "arrival"
    assert titles[0] == "Triangulating"
    assert titles.count("Conflict: exploring along the wall") >= 2
    assert titles[-1] == "Arrival at the target"
    assert recording.uncertainty[100] < 0.1 * recording.uncertainty[0]
