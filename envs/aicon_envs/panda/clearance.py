"""How far the robot's links are from each other."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from aicon_envs.panda.description import capsules

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
        pairs = [(i, j) for i in range(len(found)) for j in range(i) if abs(found[i][0] - found[j][0]) > APART]
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
        distances = _between(starts[self._first], along[self._first], starts[self._second], along[self._second])
        return float((distances - self._radii).min())


def _between(start: FloatArray, along: FloatArray, other: FloatArray, beside: FloatArray) -> FloatArray:
    """Distance of segments from a start along a vector ``(N, 3)``, ``(N,)``.

    Two segments that do not cross are nearest at an end of one of them; that of the lines counts where it lies in both.
    """
    points = np.concatenate((start, start + along, other, other + beside))
    origins = np.concatenate((other, other, start, start))
    axes = np.concatenate((beside, beside, along, along))
    share = ((points - origins) * axes).sum(-1) / np.maximum((axes * axes).sum(-1), 1e-12)
    gaps = points - origins - np.clip(share, 0.0, 1.0)[:, None] * axes
    ends = np.sqrt((gaps * gaps).sum(-1)).reshape(4, -1).min(0)
    offset = start - other
    a, b, c = (along * along).sum(-1), (along * beside).sum(-1), (beside * beside).sum(-1)
    d, e = (along * offset).sum(-1), (beside * offset).sum(-1)
    square = a * c - b * b
    crossing = square > 1e-9 * a * c
    s, t = (np.where(crossing, each, -1.0) / np.where(crossing, square, 1.0) for each in (b * e - c * d, a * e - b * d))
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    gap = offset + s[:, None] * along - t[:, None] * beside
    lines = np.sqrt((gap * gap).sum(-1))
    nearest: FloatArray = np.where(inside, lines, ends)
    return nearest
