"""The moments of the pushing figure are in order and show the story."""

import numpy as np
import pytest
from _inputs import driven, lean

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures.pusht import PushRecording, PushRollout, record
from aicon_baselines.figures.rollout import choose_panels, summarize
from aicon_envs.pusht.simulation import PUSHER_RADIUS


def test_the_default_episode_shows_every_phase_and_the_end(episode: PushRecording) -> None:
    rollout = PushRollout(episode)
    panels = choose_panels(rollout)
    phases = {rollout.phase(step) for step in range(1, episode.steps)}
    assert {panel.title for panel in panels[:-1]} == phases
    assert len(phases) == 5

    for panel in panels:
        assert panel.title == rollout.phase(panel.step)
    assert panels[-1].title == "Arrival in the goal pose"
    assert episode.costs[-1] < 0.05 * episode.costs[0]


def test_exploration_is_across_the_strongest_gradient(episode: PushRecording) -> None:
    """Where the first conflict is the strongest: its weaker side counts."""
    begin, end = episode.explorations[0]
    weaker = np.minimum(episode.strongest(useful=True), episode.strongest(useful=False))
    conflict = begin + int(weaker[begin:end].argmax())
    strongest = episode.descents[conflict, episode.strengths[conflict].argmax()]
    motion = episode.motions[conflict]

    cosine = motion @ strongest / (np.linalg.norm(motion) * np.linalg.norm(strongest))
    assert abs(cosine) < 0.2


SLOW = pytest.mark.slow


@pytest.mark.parametrize("limit", [6, 7, *(pytest.param(limit, marks=SLOW) for limit in (12, 30))])
def test_panels_are_in_order_in_any_episode(limit: int) -> None:
    policy = lean("pusht", **{"resolution.exploration": None})
    recording = record(policy, 1011, limit)
    rollout = PushRollout(recording)
    panels = choose_panels(rollout)

    assert recording.ending == "time limit"
    assert panels[-1].title == "Out of time"
    assert all(np.diff([panel.step for panel in panels]) > 0)
    assert summarize(rollout, panels)["explorations_s"] == []


def test_too_short_an_episode_is_an_error() -> None:
    with pytest.raises(ComparisonError, match="5 steps"):
        choose_panels(PushRollout(record(driven("pusht"), 1050, limit=5)))


def test_corners_are_near(episode: PushRecording) -> None:
    for moment in np.flatnonzero(episode.at_corners):
        offsets = episode.corners(int(moment)) - episode.pushers[moment]
        assert np.linalg.norm(offsets, axis=1).min() < PUSHER_RADIUS + 11.0


def test_every_moment_has_a_phase(episode: PushRecording) -> None:
    rollout = PushRollout(episode)
    for moment in range(episode.steps):
        assert ("exploring" in rollout.phase(moment)) == episode.exploring[moment]
