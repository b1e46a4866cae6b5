"""Drawing in the plane, on viser's three-dimensional scene: shapes by name, drawn anew or moved."""

from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.view.marks import FloatArray, Marks
from aicon_baselines.view.server import viser
from aicon_baselines.worlds.shape import Shape, believed, circle

HEIGHT = 10.0
"""Height of the part of the scene that is seen at first."""

_ASPECT = 1.1  # width over height of the part of a window beside the panel
_FIELD_OF_VIEW = 0.45  # rad; narrow, so that the plane looks flat
_LAYER = 0.01  # distance between two layers
_ARROW_FACES = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]])


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
        self._sizes: dict[str, list[int]] = {}
        self._faces: dict[str, NDArray[np.int_]] = {}

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

    def clear(self) -> None:
        """Remove all shapes."""
        super().clear()
        self._sizes.clear()

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
        """Draw shapes by name."""
        for name, shape in shapes.items():
            if shape.color:
                opacity = None if shape.opacity == 1.0 else shape.opacity
                self.fill(name, [shape.points], shape.color, shape.layer, opacity)
            if shape.edge:
                edge, layer = f"{name}.edge", shape.layer + 0.1
                self.line(edge, shape.points, shape.edge, layer, shape.width, closed=True)

    def fill(
        self,
        name: str,
        rings: Sequence[FloatArray],
        color: str,
        layer: float,
        opacity: float | None = None,
    ) -> None:
        """Fill polygons (N, 2) without holes; drawn again, they are the same ones, moved."""
        sizes = [len(ring) for ring in rings]
        if not sizes:
            return
        vertices = self.to_scene(np.concatenate(rings), layer)

        # Other polygons have other triangles.
        if self._sizes.get(name) != sizes:
            self._sizes[name], self._faces[name] = sizes, triangulate(rings)
            self._handles.pop(name, None)
        self.mesh(name, vertices, self._faces[name], color, opacity)

    def ellipse(
        self,
        name: str,
        center: ArrayLike,
        covariance: ArrayLike,
        color: str,
        layer: float,
        opacity: float | None = None,
    ) -> None:
        """Fill an ellipse of two standard deviations around a mean (2,), covariance (2, 2)."""
        ring = believed(center, covariance, layer, color).points
        self.fill(name, [ring], color, layer, opacity)

    def disc(
        self,
        name: str,
        center: ArrayLike,
        radius: float,
        color: str,
        layer: float,
        opacity: float | None = None,
    ) -> None:
        """Fill a disc."""
        ring = np.asarray(center, np.float64) + radius * circle()
        self.fill(name, [ring], color, layer, opacity)

    def line(
        self,
        name: str,
        points: ArrayLike,
        color: str,
        layer: float,
        thickness: float = 2.0,
        closed: bool = False,
    ) -> None:
        """Draw a line through points (N, 2), its thickness in pixels of the screen."""
        self.polyline(name, self.to_scene(points, layer), color, thickness, closed)

    def arrow(
        self,
        name: str,
        tail: ArrayLike,
        direction: ArrayLike,
        color: str,
        layer: float,
        length: float,
        width: float,
    ) -> None:
        """Draw an arrow from a point (2,) of the world; length and width are those of the scene."""
        along = np.asarray(direction, np.float64) * self._flip
        norm = float(np.linalg.norm(along))
        if norm == 0.0:
            self.hide(name)
            return

        along /= norm
        across = np.array([-along[1], along[0]])
        start = self.to_scene(tail, layer)
        corners = arrow_outline(length, width) @ np.stack([along, across])
        vertices = start + np.pad(corners, ((0, 0), (0, 1)))
        self.mesh(name, vertices, _ARROW_FACES, color)


def arrow_outline(length: float, width: float) -> FloatArray:
    """Corners of a shaft and a head along the first axis, (7, 2)."""
    head_width = max(2.6 * width, 0.16)
    neck = length - min(1.1 * head_width, 0.6 * length)
    shaft = [(0.0, -width / 2), (neck, -width / 2), (neck, width / 2), (0.0, width / 2)]
    head = [(neck, -head_width / 2), (length, 0.0), (neck, head_width / 2)]
    return np.array(shaft + head)


def triangulate(rings: Sequence[FloatArray]) -> NDArray[np.int_]:
    """Triangles that fill polygons without holes: indices into all their points, (F, 3)."""
    faces, first = [], 0
    for ring in rings:
        pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(ring))
        for triangle in shapely.get_parts(pieces):
            corners = shapely.get_coordinates(triangle)[:3]
            gaps = np.linalg.norm(corners[:, np.newaxis] - ring, axis=-1)
            faces.append(first + gaps.argmin(axis=1))
        first += len(ring)
    return np.array(faces)
