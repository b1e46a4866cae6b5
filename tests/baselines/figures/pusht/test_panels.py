"""The moments of the pushing figure are in order and show the story."""

import numpy as np
import pytest
from _inputs import driven

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.figures.pusht import PushRecording, PushRollout, record
from aicon_baselines.figures.pusht.moments import at_corners, phase
from aicon_baselines.figures.rollout import choose_panels, summarize
from aicon_envs.pusht.simulation import PUSHER_RADIUS


def test_default_episode_shows_the_story(episode: PushRecording) -> None:
    contact, harmful, conflict, around, corner, last = (
        panel.step for panel in choose_panels(PushRollout(episode))
    )
    assert contact < harmful < conflict < around < corner < last == episode.steps
    assert episode.touched[contact]
    assert not episode.touched[:contact].any()
    assert not episode.useful[harmful, episode.strengths[harmful].argmax()]
    assert episode.exploring[[conflict, corner]].all()
    assert not episode.exploring[[contact, harmful, around]].any()
    assert not episode.touched[[conflict, around]].any()
    assert at_corners(episode)[corner]
    assert episode.ending == "arrival"
    assert episode.costs[-1] < 0.05 * episode.costs[0]


def test_exploration_is_across_the_strongest_gradient(episode: PushRecording) -> None:
    conflict = choose_panels(PushRollout(episode))[2].step
    strongest = episode.descents[conflict, episode.strengths[conflict].argmax()]
    motion = episode.motions[conflict]

    cosine = motion @ strongest / (np.linalg.norm(motion) * np.linalg.norm(strongest))
    assert abs(cosine) < 0.2


@pytest.mark.parametrize("limit", [6, 7, 12, 30])
def test_panels_are_in_order_in_any_episode(limit: int) -> None:
    policy = driven("pusht", **{"resolution.exploration": None})
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
    for moment in np.flatnonzero(at_corners(episode)):
        offsets = episode.corners(int(moment)) - episode.pushers[moment]
        assert np.linalg.norm(offsets, axis=1).min() < PUSHER_RADIUS + 11.0


def test_every_moment_has_a_phase(episode: PushRecording) -> None:
    for moment in range(episode.steps):
        assert ("exploring" in phase(episode, moment)) == episode.exploring[moment]
    assert phase(episode, episode.steps) == "Arrival in the goal pose"
