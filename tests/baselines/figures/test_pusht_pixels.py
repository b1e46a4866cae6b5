"""The figure of pushing by pictures shows what is seen and what is believed of it."""

import json
from pathlib import Path

import numpy as np
import pytest

from aicon_baselines.figures import pusht_pixels

pytest.importorskip("pygame")


@pytest.mark.slow
def test_the_filter_is_nearer_than_the_network_where_pictures_are_covered(tmp_path: Path) -> None:
    summary = pusht_pixels.make_figure(tmp_path, video="none")
    off = json.loads((tmp_path / "pusht_pixels.json").read_text())["median_off_px"]
    assert summary.headline.startswith("arrival")
    assert off["filter"] < 5 and 3 * off["filter"] < off["network"]
    assert (tmp_path / "pusht_pixels.png").stat().st_size < 6e5


def test_the_true_pose_is_that_of_the_centre_of_mass() -> None:
    told = {"block_pose": np.array([200.0, 300.0, 0.5 * np.pi])}
    recording = pusht_pixels.SeenRecording(None, [], infos=[told])  # type: ignore[arg-type]
    np.testing.assert_allclose(recording.truth, [[155.0, 300.0, 0.5 * np.pi]], atol=1e-9)
    outline = recording.outline_at(recording.truth[0])
    np.testing.assert_allclose(outline.min(0), [80.0, 240.0], atol=1e-9)
