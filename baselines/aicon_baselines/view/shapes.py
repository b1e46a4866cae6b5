"""Arrows, ellipsoids and capsules in space."""

import mujoco
import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.palette import rgb
from aicon_baselines.view.marks import FloatArray, Marks

_UNIT_BALL = trimesh.creation.icosphere(2)


class Shapes(Marks):
    """What is drawn besides the bodies of a world in space."""

    def arrow(
        self, name: str, tail: FloatArray, along: FloatArray, color: str, width: float
    ) -> None:
        """Draw an arrow from a point (3,) along a vector (3,), m."""
        points = np.stack([tail, tail + along])[np.newaxis].astype(np.float32)
        handle = self._shown(name)
        if handle is not None:
            handle.points, handle.colors = points, _linear(color)
            handle.shaft_radius, handle.head_radius = width / 2.0, 1.4 * width
            return

        self._handles[name] = self._scene.add_arrows(
            f"/{name}",
            points,
            _linear(color),
            shaft_radius=width / 2.0,
            head_radius=1.4 * width,
            head_length=0.03,
        )

    def ball(
        self,
        name: str,
        center: ArrayLike,
        radius: float,
        color: str,
        opacity: float | None = None,
    ) -> None:
        """Draw a ball."""
        self.ellipsoid(name, center, radius * np.eye(3), color, opacity)

    def ellipsoid(
        self,
        name: str,
        center: ArrayLike,
        axes: FloatArray,
        color: str,
        opacity: float | None = None,
    ) -> None:
        """Draw an ellipsoid with its half axes as columns (3, 3), m."""
        vertices = np.asarray(center, np.float64) + _UNIT_BALL.vertices @ axes.T
        self.mesh(name, vertices, _UNIT_BALL.faces, color, opacity)

    def capsule(
        self,
        name: str,
        start: FloatArray,
        end: FloatArray,
        radius: float,
        color: str,
        opacity: float,
    ) -> None:
        """Draw a capsule around a segment whose length does not change."""
        length = float(np.linalg.norm(end - start))
        if name not in self._handles:
            shape = trimesh.creation.capsule(length, radius, count=[12, 12])
            self.mesh(name, shape.vertices, shape.faces, color, opacity)

        # Along z at first, from the origin on.
        handle, rotation = self._shown(name), np.array([1.0, 0.0, 0.0, 0.0])
        if length > 0.0:
            mujoco.mju_quatZ2Vec(rotation, (end - start) / length)
        handle.position, handle.wxyz = (start + end) / 2.0, rotation


def _linear(color: str) -> NDArray[np.uint8]:
    """A colour as arrows take it: proportional to light, not to what the eye sees."""
    shares = np.array(rgb(color)) / 255.0
    return np.asarray(np.round(255.0 * shares**2.2), np.uint8)
