"""Shapes in space by name, on viser's scene: drawn once, and moved when they are drawn again."""

from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.view.mesh import add_mesh
from aicon_baselines.view.server import viser
from aicon_baselines.view.style import Color

FloatArray = NDArray[np.float64]

_UNIT_BALL = trimesh.creation.icosphere(2)


class Shapes:
    """What is drawn besides the bodies: arrows, ellipsoids, lines, texts.

    Args:
        scene: Viser's scene.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._handles: dict[str, Any] = {}

    def clear(self) -> None:
        """Remove all shapes."""
        for handle in self._handles.values():
            handle.remove()
        self._handles.clear()

    def hide(self, name: str) -> None:
        """Hide a shape, if it is there."""
        if name in self._handles and self._handles[name].visible:
            self._handles[name].visible = False

    def arrow(
        self, name: str, tail: FloatArray, along: FloatArray, color: Color, width: float
    ) -> None:
        """Draw an arrow from a point (3,) along a vector (3,), m."""
        points = np.stack([tail, tail + along])[np.newaxis].astype(np.float32)
        if name in self._handles:
            handle = self._handles[name]
            handle.points, handle.colors = points, _linear(color)
            handle.shaft_radius, handle.head_radius = width / 2.0, 1.4 * width
            handle.visible = True
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
        color: Color,
        opacity: float | None = None,
    ) -> None:
        """Draw a ball."""
        self.ellipsoid(name, center, radius * np.eye(3), color, opacity)

    def ellipsoid(
        self,
        name: str,
        center: ArrayLike,
        axes: FloatArray,
        color: Color,
        opacity: float | None = None,
    ) -> None:
        """Draw an ellipsoid with its half axes as columns (3, 3), m."""
        vertices = np.asarray(center, np.float64) + _UNIT_BALL.vertices @ axes.T
        self.mesh(name, vertices, _UNIT_BALL.faces, color, opacity)

    def mesh(
        self,
        name: str,
        vertices: FloatArray,
        faces: NDArray[np.int_],
        color: Color,
        opacity: float | None = None,
    ) -> None:
        """Draw a mesh of points (N, 3) and triangles (F, 3); drawn again, its points move."""
        if name in self._handles:
            self._handles[name].vertices = vertices.astype(np.float32)
            self._handles[name].visible = True
            return

        self._handles[name] = add_mesh(self._scene, name, vertices, faces, color, opacity)

    def capsule(
        self,
        name: str,
        start: FloatArray,
        end: FloatArray,
        radius: float,
        color: Color,
        opacity: float,
    ) -> None:
        """Draw a capsule around a segment whose length does not change."""
        length = float(np.linalg.norm(end - start))
        if name not in self._handles:
            shape = trimesh.creation.capsule(length, radius, count=[12, 12])
            self.mesh(name, shape.vertices, shape.faces, color, opacity)

        # Along z at first, from the origin on.
        handle, rotation = self._handles[name], np.array([1.0, 0.0, 0.0, 0.0])
        if length > 0.0:
            mujoco.mju_quatZ2Vec(rotation, (end - start) / length)
        handle.position, handle.wxyz, handle.visible = (start + end) / 2.0, rotation, True

    def line(self, name: str, points: ArrayLike, color: Color, closed: bool = False) -> None:
        """Draw a line through points (N, 3), three pixels of the screen thick."""
        placed = np.asarray(points, np.float64)
        ends = np.roll(placed, -1, axis=0)
        segments = np.stack([placed, ends], axis=1)[: None if closed else -1].astype(np.float32)
        if name in self._handles:
            self._handles[name].points = segments
            self._handles[name].visible = True
            return

        self._handles[name] = self._scene.add_line_segments(
            f"/{name}", segments, color, thickness=3.0, thickness_units="screen"
        )

    def text(self, name: str, text: str, position: ArrayLike) -> None:
        """Write a text centred above a point (3,)."""
        place = np.asarray(position, np.float64)
        if name in self._handles:
            handle = self._handles[name]
            handle.text, handle.position, handle.visible = text, place, True
            return

        self._handles[name] = self._scene.add_label(
            f"/{name}", text, position=place, anchor="bottom-center", font_screen_scale=0.9
        )


def _linear(color: Color) -> NDArray[np.uint8]:
    """A colour as arrows take it: proportional to light, not to what the eye sees."""
    shares = np.array(color) / 255.0
    return np.asarray(np.round(255.0 * shares**2.2), np.uint8)
