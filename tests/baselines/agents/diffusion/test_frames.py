from dataclasses import replace

import numpy as np
import pytest

from aicon_baselines.agents.diffusion.dataset import Frames, shuffled_batches, together
from aicon_baselines.evaluation import ComparisonError


def test_windows_stay_in_their_episode() -> None:
    frames = Frames(
        columns={"action": np.arange(7.0), "observation.state": 10.0 * np.arange(7.0)},
        first=np.array([0, 0, 0, 3, 3, 3, 3]),
        last=np.array([2, 2, 2, 6, 6, 6, 6]),
        statistics={},
        features={},
        fps=10,
    )
    offsets = {"action": [-1, 0, 1, 2], "observation.state": [-1, 0]}

    values, paddings = frames.windows(np.array([0, 1, 5]), offsets)

    assert np.array_equal(values["action"], [[0, 0, 1, 2], [0, 1, 2, 2], [4, 5, 6, 6]])
    assert np.array_equal(paddings["action"], [[1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1]])
    assert np.array_equal(values["observation.state"], [[0, 0], [0, 10], [40, 50]])


def test_episodes_of_several_datasets_stay_apart() -> None:
    def frames(*lengths: int) -> Frames:
        ends = np.cumsum(lengths)
        return Frames(
            columns={"action": np.arange(float(ends[-1]))},
            first=np.repeat(ends - lengths, lengths),
            last=np.repeat(ends - 1, lengths),
            statistics={},
            features={},
            fps=10,
        )

    both = together([frames(3, 4), frames(2)])
    alone = frames(3, 4, 2)
    assert np.array_equal(both.first, alone.first) and np.array_equal(both.last, alone.last)
    assert np.array_equal(both.columns["action"], [*range(7), *range(2)])

    for other in (
        replace(frames(2), fps=20),
        replace(frames(2), columns={"action": np.zeros((2, 1))}),
    ):
        with pytest.raises(ComparisonError, match=r"must be alike: .*'fps': 10.* and one with"):
            together([frames(3), frames(1), other])


def test_every_epoch_has_each_frame_once() -> None:
    batches = shuffled_batches(count=6, batch_size=4, seed=0)
    indices = np.concatenate([next(batches) for _ in range(6)])
    for epoch in indices.reshape(4, 6):
        assert np.array_equal(np.sort(epoch), np.arange(6))
