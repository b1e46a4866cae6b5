"""The pictures of the concepts show what their titles say, and are those of the documents."""

from pathlib import Path

import numpy as np
import pytest
from _documents import ROOT

from aicon_torch import DirectDescent, Sum
from concepts import conflict, foresight, meeting
from concepts.world import make_policy, meeting_at, run
from draw_concepts import PICTURES


def test_the_documents_show_each_of_them() -> None:
    page = (ROOT / "docs" / "concepts.md").read_text()
    for name in PICTURES:
        assert f"(images/concept_{name}.png)" in page
        assert (ROOT / "docs" / "images" / f"concept_{name}.png").exists()


@pytest.mark.parametrize("name", ["path", "meeting", "projection"])
def test_a_picture_is_drawn(name: str, tmp_path: Path) -> None:
    PICTURES[name](tmp_path / "picture.png")
    assert 5_000 < (tmp_path / "picture.png").stat().st_size < 100_000


def test_the_gradients_agree_are_at_right_angles_and_oppose_each_other() -> None:
    cosines = []
    for place in meeting.PLACES.values():
        met = meeting_at(np.array(place), meeting.TARGET, meeting.WALL)
        first, second = met.gradients / met.magnitudes.unsqueeze(-1)
        cosines.append(float(first @ second))

    agreeing, orthogonal, opposing = cosines
    assert agreeing > 0.9
    assert abs(orthogonal) < 0.1
    assert opposing < -0.9


def test_the_sum_stays_in_front_of_the_wall() -> None:
    policy = make_policy(Sum(), DirectDescent(gain=5.0, smoothing=0.0))
    way = run(policy, conflict.START, conflict.TARGET, conflict.WALL, steps=60)

    x, y = way.places[-1]
    assert x == pytest.approx(-0.3, abs=0.02)
    assert y == pytest.approx(0.0, abs=1e-6)


def test_exploration_leads_around_it() -> None:
    policy = make_policy(law=DirectDescent())
    way = run(policy, conflict.START, conflict.TARGET, conflict.WALL, steps=100)

    assert any(way.exploring)
    assert np.linalg.norm(way.places[-1] - conflict.TARGET) < 0.05


def test_twenty_gradients_end_nearer_to_the_target_than_one() -> None:
    one = 0.1 * foresight.action_of(DirectDescent(smoothing=0.0))
    twenty = 0.1 * foresight.action_of(foresight.law_after(20))

    assert np.linalg.norm(twenty - foresight.TARGET) < 0.01 < np.linalg.norm(one - foresight.TARGET)
