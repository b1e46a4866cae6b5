"""Demonstrations in memory, and the windows that a policy is trained on."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Frames:
    """A dataset of N frames in memory.

    Attributes:
        columns: Arrays (N, ...) by the dataset's names; pictures as uint8 (N, 3, height, width).
        first: (N,), index of the first frame of each frame's episode.
        last: (N,), index of its last frame.
        statistics: Those of the dataset, for the normalisation.
        features: The features of the dataset, as LeRobot describes them.
    """

    columns: dict[str, NDArray[Any]]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    statistics: dict[str, Any]
    features: dict[str, dict[str, Any]]

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.first)

    def windows(
        self, index: NDArray[np.int64], offsets: dict[str, list[int]]
    ) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
        """Return the values around frames, and which of them are padding.

        As in LeRobot, an episode's first frame stands for what would lie before it, and its last
        for what lies after.

        Args:
            index: (B,), the frames.
            offsets: For each column the T offsets to take, in frames.

        Returns:
            The values (B, T, ...) and the paddings (B, T), by column.
        """
        first, last = self.first[index], self.last[index]
        values, paddings = {}, {}

        for name, steps in offsets.items():
            wanted = index[:, None] + np.array(steps)
            available = np.clip(wanted, first[:, None], last[:, None])

            values[name] = self.columns[name][available]
            paddings[name] = wanted != available

        return values, paddings


def shuffled_batches(count: int, batch_size: int, seed: int) -> Iterator[NDArray[np.int64]]:
    """Yield indices (B,) of frames without end; each epoch is a new permutation of all of them.

    Args:
        count: Number of frames.
        batch_size: B; a batch may go over the end of an epoch.
        seed: Seed of the permutations.
    """
    rng = np.random.default_rng(seed)
    remaining: NDArray[np.int64] = np.empty(0, np.int64)

    while True:
        while len(remaining) < batch_size:
            remaining = np.concatenate([remaining, rng.permutation(count)])

        yield remaining[:batch_size]
        remaining = remaining[batch_size:]
