"""Shapes by name on viser's scene: drawn once, and moved when they are drawn again."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.palette import rgb
from aicon_baselines.view.server import viser

FloatArray = NDArray[np.float64]


class Marks:
    """Meshes, lines and texts, in the plane as in space; nothing is sent twice.

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

    def hide(self, *names: str) -> None:
        """Hide shapes, as far as they are there."""
        for name in names:
            if name in self._handles and self._handles[name].visible:
                self._handles[name].visible = False

    def mesh(
        self,
        name: str,
        vertices: FloatArray,
        faces: NDArray[np.int_],
        color: str,
        opacity: float | None = None,
    ) -> None:
        """Draw points (N, 3) and triangles (F, 3), seen from both sides and without a shadow."""
        handle = self._shown(name)
        if handle is not None:
            handle.vertices = vertices.astype(np.float32)
            if tuple(handle.color) != rgb(color):
                handle.color = rgb(color)
            return

        self._handles[name] = self._scene.add_mesh_simple(
            f"/{name}",
            vertices.astype(np.float32),
            faces.astype(np.uint32),
            color=rgb(color),
            opacity=opacity,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def polyline(
        self,
        name: str,
        points: ArrayLike,
        color: str,
        thickness: float = 3.0,
        closed: bool = False,
    ) -> None:
        """Draw a line through points (N, 3), its thickness in pixels of the screen."""
        placed = np.asarray(points, np.float64)
        if len(placed) < 2:
            placed = np.repeat(placed, 2, axis=0)
        ends = np.roll(placed, -1, axis=0)
        segments = np.stack([placed, ends], axis=1)[: None if closed else -1].astype(np.float32)

        handle = self._shown(name)
        if handle is not None:
            handle.points = segments
            return
        self._handles[name] = self._scene.add_line_segments(
            f"/{name}", segments, rgb(color), thickness=thickness, thickness_units="screen"
        )

    def text(self, name: str, text: str, position: ArrayLike, scale: float = 1.0) -> None:
        """Write a text centred above a point (3,) of the scene."""
        place = np.asarray(position, np.float64)
        handle = self._shown(name)
        if handle is not None:
            handle.text, handle.position = text, place
            return
        self._handles[name] = self._scene.add_label(
            f"/{name}", text, position=place, anchor="bottom-center", font_screen_scale=scale
        )

    def _shown(self, name: str) -> Any:
        """What viser has of this name, shown again; None where there is nothing yet."""
        handle = self._handles.get(name)
        if handle is not None:
            handle.visible = True
        return handle
