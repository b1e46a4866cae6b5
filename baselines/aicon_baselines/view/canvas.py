"""Drawing in the plane, on viser's three-dimensional scene: shapes by name, drawn anew or moved."""

from collections.abc import Mapping

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.view.marks import FloatArray, Marks
from aicon_baselines.view.server import viser
from aicon_baselines.worlds.shape import Shape

HEIGHT = 10.0
"""Height of the part of the scene that is seen at first."""

_ASPECT = 1.1  # width over height of the part of a window beside the panel
_FIELD_OF_VIEW = 0.45  # rad; narrow, so that the plane looks flat
_LAYER = 0.01  # distance between two layers


class Canvas(Marks):
    """A plane seen from above, on which every shape has a name.

    Higher layers cover lower ones.

    Args:
        server: The server of the page.
        flipped: Whether y points down.

    Attributes:
        scale: Length in the scene of one unit of the world.
    """

    def __init__(self, server: viser.ViserServer, flipped: bool = False) -> None:
        super().__init__(server.scene)
        self._flip = np.array([1.0, -1.0 if flipped else 1.0])
        self._center, self.scale = np.zeros(2), 1.0

        # Straight from above; with +y up, the mouse turns the view as one expects.
        distance = 0.5 * 1.08 * HEIGHT / np.tan(0.5 * _FIELD_OF_VIEW)
        server.scene.set_up_direction("+y")
        server.initial_camera.fov = _FIELD_OF_VIEW
        server.initial_camera.position = (0.0, 0.0, float(distance))
        server.initial_camera.look_at = (0.0, 0.0, 0.0)

        # Colours as they are, without light and shade.
        server.scene.configure_default_lights(enabled=False)
        server.scene.add_light_ambient("/light", intensity=2.0)

    def fit(self, low: ArrayLike, high: ArrayLike) -> None:
        """Show the rectangle between two corners, in the world's unit; nothing is drawn yet."""
        low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
        width, height = high - low
        self._center = (low + high) / 2
        self.scale = HEIGHT / max(height, width / _ASPECT)

    def to_scene(self, points: ArrayLike, layer: float = 0.0) -> FloatArray:
        """Points (N, 2) of the world as points (N, 3) of the scene."""
        flat = (np.asarray(points, np.float64) - self._center) * self.scale * self._flip
        height = np.full((*flat.shape[:-1], 1), layer * _LAYER)
        placed: FloatArray = np.concatenate([flat, height], axis=-1)
        return placed

    def to_world(self, position: ArrayLike) -> FloatArray:
        """A point (3,) of the scene as one (2,) of the world."""
        flat = np.asarray(position, np.float64)[:2]
        placed: FloatArray = flat * self._flip / self.scale + self._center
        return placed

    def draw(self, shapes: Mapping[str, Shape]) -> None:
        """Draw shapes by name, or move those that are there."""
        for name, shape in shapes.items():
            if shape.color:
                self._fill(name, shape)
            if shape.edge:
                edge = self.to_scene(shape.points, shape.layer + 0.1)
                self.polyline(f"{name}.edge", edge, shape.edge, shape.width, closed=True)

    def line(
        self, name: str, points: ArrayLike, color: str, layer: float, thickness: float = 2.0
    ) -> None:
        """Draw a line through points (N, 2), its thickness in pixels of the screen."""
        self.polyline(name, self.to_scene(points, layer), color, thickness)

    def _fill(self, name: str, shape: Shape) -> None:
        """Fill a polygon without holes; drawn again, it is the same one, moved."""
        known = self._handles.get(name)
        if known is not None and len(known.vertices) != len(shape.points):
            self._handles.pop(name).remove()  # other polygons have other triangles

        faces = triangulate(shape.points) if name not in self._handles else np.zeros((0, 3), int)
        opacity = None if shape.opacity == 1.0 else shape.opacity
        self.mesh(name, self.to_scene(shape.points, shape.layer), faces, shape.color, opacity)


def triangulate(ring: FloatArray) -> NDArray[np.int_]:
    """Triangles that fill a polygon (N, 2) without holes: indices of its points, (F, 3)."""
    faces = []
    pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(ring))
    for triangle in shapely.get_parts(pieces):
        corners = shapely.get_coordinates(triangle)[:3]
        gaps = np.linalg.norm(corners[:, np.newaxis] - ring, axis=-1)
        faces.append(gaps.argmin(axis=1))
    return np.array(faces)
