"""How far the robot's links are from each other."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda_push.description import capsules

FloatArray = NDArray[np.float64]

APART = 2
"""Links that follow each other within this number cannot meet."""


class Clearance:
    """The smallest gap between capsules of the robot that can meet.

    Args:
        model: The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        found = capsules()
        bodies = [model.body(f"panda_link{link}" if link < 8 else "tool").id for link, *_ in found]
        pairs = [
            (i, j)
            for i in range(len(found))
            for j in range(i)
            if abs(found[i][0] - found[j][0]) > APART
        ]
        first, second = np.array(pairs).T
        radii = np.array([radius for *_, radius in found])
        self._bodies, self._first, self._second = np.array(bodies), first, second
        self._starts = np.array([start for _, start, _, _ in found])
        self._along = np.array([end for _, _, end, _ in found]) - self._starts
        self._radii = radii[first] + radii[second]

    def __call__(self, data: mujoco.MjData) -> float:
        """The gap in a state, m; below 0 where they overlap."""
        turns = data.xmat[self._bodies].reshape(-1, 3, 3)
        starts = data.xpos[self._bodies] + np.einsum("nij,nj->ni", turns, self._starts)
        along = np.einsum("nij,nj->ni", turns, self._along)
        distances = _between(
            starts[self._first], along[self._first], starts[self._second], along[self._second]
        )
        return float((distances - self._radii).min())


def _between(
    start: FloatArray, along: FloatArray, other: FloatArray, beside: FloatArray
) -> FloatArray:
    """Distance of segments from a start along a vector ``(N, 3)``, ``(N,)``: each shares s and t of its way."""
    offset = start - other
    a, b, c = (along * along).sum(-1), (along * beside).sum(-1), (beside * beside).sum(-1)
    d, e = (along * offset).sum(-1), (beside * offset).sum(-1)
    s = np.clip((b * e - c * d) / np.maximum(a * c - b * b, 1e-12), 0.0, 1.0)
    t = np.clip((b * s + e) / np.maximum(c, 1e-12), 0.0, 1.0)
    s = np.clip((b * t - d) / np.maximum(a, 1e-12), 0.0, 1.0)
    gap = offset + s[:, None] * along - t[:, None] * beside
    distance: FloatArray = np.sqrt((gap * gap).sum(-1))
    return distance
