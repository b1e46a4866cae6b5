"""What the camera shows of the object: colour mask, edges of its top face, registration of its known outline.

Plain numpy, one image at a time. What comes out are the corners in the frame of the camera; projecting them is the
graph's matter.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class View(NamedTuple):
    """One image from a known place.

    Attributes:
        rgb: ``(H, W, 3)``, 0 to 255.
        depth: ``(H, W)``, along the optical axis, m.
        rotation: Of the camera, ``(3, 3)``: columns are right, down and forward.
        position: Of the camera, ``(3,)``, m.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    rotation: Array
    position: Array


class Sight(NamedTuple):
    """What an image shows.

    Attributes:
        pose: The object's (x, y, θ), m and rad.
        top: Height of its top face, m.
        score: Share of the visible outline and surface that fits, 0 to 1.
        middle: Middle of what is seen of it, ``(2,)``, m.
    """

    pose: Array
    top: float
    score: float
    middle: Array


@dataclass(frozen=True)
class Registration:
    """Finds an object of known outline.

    Attributes:
        corners: The outline about the object's frame, in order, ``(N, 2)``, m.
        intrinsics: Focal length, centre (x, y), width and height, px.
        accept: Score from which a registration that starts at the prior is taken as it is.
        least: Fewest edge points.
        tilts: Number of orientations that a search tries.
    """

    corners: Array
    intrinsics: tuple[float, ...]
    accept: float = 0.85
    least: int = 12
    tilts: int = 16

    def __call__(self, view: View, prior: Array | None) -> Sight | None:
        """Find the object.

        Args:
            view: The image.
            prior: Its expected pose (x, y, θ), m and rad; None if nothing is known.

        Returns:
            What it shows; None if it shows too little of the object.
        """
        surface, edges, top, stick = self.segment(view)
        if len(edges) < self.least or len(surface) < 2 * self.least:
            return None
        best = None
        if prior is not None:
            best = self.fit(prior, view, surface, edges, top, stick)
        if best is None or best.score < self.accept:
            for start in self.starts(surface):
                found = self.fit(start, view, surface, edges[:: max(1, len(edges) // 60)], top, stick)
                if best is None or found.score > best.score:
                    best = found
            assert best is not None  # there are starts
            best = self.fit(best.pose, view, surface, edges, top, stick)
        return best

    def segment(self, view: View) -> tuple[Array, Array, float, NDArray[np.bool_]]:
        """The top face: points on it and on its edges ``(n, 2)``, m, its height, and where the stick is in front."""
        focal, cx, cy, *_ = self.intrinsics
        red, green, blue = view.rgb.astype(np.int16).transpose(2, 0, 1)
        body = (red > 60) & (2 * red > 3 * np.maximum(green, blue))
        marker = (blue > 60) & (2 * blue > 3 * np.maximum(red, green))
        stick = np.maximum(np.maximum(red, green), blue) < 60
        v, u = np.nonzero(body | marker)
        none = np.zeros((0, 2))
        if len(u) < self.least:
            return none, none, 0.0, stick
        depth = view.depth[v, u]
        rays = np.stack(((u - cx) / focal, (v - cy) / focal, np.ones(len(u)))) * depth
        heights = view.rotation[2] @ rays + view.position[2]
        top = float(np.median(heights[heights > np.quantile(heights, 0.3)]))
        bright = np.maximum(red, blue)[v, u]
        flat = (np.abs(heights - top) < 0.012) & (bright > 0.75 * np.median(bright))  # its sides are in the shade
        face = np.zeros(body.shape, np.bool_)
        face[v[flat], u[flat]] = True
        face = _closed(face) & (body | marker)
        v, u = np.nonzero(face)
        if len(u) < self.least:
            return none, none, top, stick
        surface = self.on_plane(u, v, view, top)
        blocked = _grown(stick)
        points = []
        height, width = face.shape
        for du, dv in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            inside = (u + du >= 0) & (u + du < width) & (v + dv >= 0) & (v + dv < height)
            a, b = u[inside], v[inside]
            border = ~face[b + dv, a + du] & ~blocked[b + dv, a + du]
            points.append(self.on_plane(a[border] + 0.5 * du, b[border] + 0.5 * dv, view, top))
        edges = np.concatenate(points)
        return surface, edges[:: max(1, len(edges) // 150)], top, stick

    def on_plane(self, u: NDArray[Any], v: NDArray[Any], view: View, height: float) -> Array:
        """Where rays through pixels meet the plane of a height, ``(n, 2)``, m."""
        focal, cx, cy, *_ = self.intrinsics
        rays = view.rotation @ np.stack(((u - cx) / focal, (v - cy) / focal, np.ones(len(u))))
        points: Array = (view.position[:2, None] + rays[:2] * (height - view.position[2]) / rays[2]).T
        return points

    def fit(
        self,
        start: Array,
        view: View,
        surface: Array,
        edges: Array,
        top: float,
        stick: NDArray[np.bool_],
        rounds: int = 10,
    ) -> Sight:
        """Gauss-Newton on the distance of edge points to the nearest side of the outline."""
        pose = np.array(start, dtype=np.float64)
        for count in range(rounds):
            corners = self.placed(pose)
            offset, normal = _to_outline(edges, corners)
            bound = 0.04 if count < 5 else 0.01  # later, what is far off belongs to something else
            weight = 1.0 / (1.0 + (offset / (0.3 * bound)) ** 2)
            arm = edges - pose[:2]
            jacobian = np.column_stack((normal, arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]))
            square = (jacobian * weight[:, None]).T @ jacobian + np.diag([1e-3, 1e-3, 1e-5])
            step = np.linalg.solve(square, (jacobian * weight[:, None]).T @ offset)
            step[:2] = np.clip(step[:2], -0.03, 0.03)
            step[2] = np.clip(step[2], -0.3, 0.3)
            pose += step
            if np.abs(step).max() < 1e-5:
                break
        return Sight(pose, top, self.score(pose, view, surface, edges, top, stick), surface.mean(0))

    def score(
        self, pose: Array, view: View, surface: Array, edges: Array, top: float, stick: NDArray[np.bool_]
    ) -> float:
        """The least of three shares: edge points on the outline, surface inside it, and its visible inside seen."""
        corners = self.placed(pose)
        offset, _ = _to_outline(edges, corners)
        fits = float((np.abs(offset) < 0.006).mean())
        inside = float(_inside(surface[:: max(1, len(surface) // 200)], corners, 0.006).mean())
        grid = self.samples @ _turn(pose[2]).T + pose[:2]
        focal, cx, cy, width, height = self.intrinsics
        local = (np.column_stack((grid, np.full(len(grid), top))) - view.position) @ view.rotation
        u, v = focal * local[:, 0] / local[:, 2] + cx, focal * local[:, 1] / local[:, 2] + cy
        seen = (u > 1) & (u < width - 2) & (v > 1) & (v < height - 2)
        columns, rows = u[seen].round().astype(int), v[seen].round().astype(int)
        free = ~stick[rows, columns]
        color = view.rgb[rows, columns].astype(np.int16)[free]
        red, green, blue = color.T if len(color) else np.zeros((3, 0), np.int16)
        shown = (2 * red > 3 * np.maximum(green, blue)) | (2 * blue > 3 * np.maximum(red, green))
        return min(fits, inside, float(shown.mean()) if len(shown) >= 5 else 0.0)

    @cached_property
    def samples(self) -> Array:
        """Points well inside the outline, ``(n, 2)``, m."""
        low, high = self.corners.min(0), self.corners.max(0)
        x, y = np.meshgrid(np.arange(low[0], high[0], 0.012), np.arange(low[1], high[1], 0.012))
        grid = np.column_stack((x.ravel(), y.ravel()))
        kept: Array = grid[_inside(grid, self.corners, -0.008)]
        return kept

    def starts(self, surface: Array) -> list[Array]:
        """Poses to search from: the centre on the visible part, turned in all directions."""
        x, y = surface.mean(0)
        return [np.array([x, y, angle]) for angle in np.arange(self.tilts) * 2 * np.pi / self.tilts]

    def placed(self, pose: Array) -> Array:
        """The corners at a pose, ``(N, 2)``."""
        corners: Array = self.corners @ _turn(pose[2]).T + pose[:2]
        return corners


def _turn(angle: float) -> Array:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _to_outline(points: Array, corners: Array) -> tuple[Array, Array]:
    """Signed distance of points to the nearest side ``(n,)``, and the unit vector it is measured along ``(n, 2)``."""
    start, along = corners, np.roll(corners, -1, axis=0) - corners
    relative = points[:, None] - start
    share = ((relative * along).sum(-1) / (along * along).sum(-1)).clip(0.0, 1.0)
    gap = relative - share[..., None] * along
    nearest = (gap * gap).sum(-1).argmin(1)
    side = along[nearest] / np.linalg.norm(along[nearest], axis=1, keepdims=True)
    normal = np.column_stack((side[:, 1], -side[:, 0]))
    chosen = gap[np.arange(len(points)), nearest]
    return (chosen * normal).sum(-1), normal


def _inside(points: Array, corners: Array, margin: float) -> NDArray[np.bool_]:
    """Whether points are inside a polygon, or no farther than a margin outside; inside by so much if it is negative."""
    after = np.roll(corners, -1, axis=0)
    x, y = points[:, 0, None], points[:, 1, None]
    crosses = (corners[:, 1] > y) != (after[:, 1] > y)
    rise = after[:, 1] - corners[:, 1]
    where = corners[:, 0] + (y - corners[:, 1]) / np.where(rise == 0, 1.0, rise) * (after[:, 0] - corners[:, 0])
    within = (crosses & (x < where)).sum(1) % 2 == 1
    start, along = corners, after - corners
    relative = points[:, None] - start
    share = ((relative * along).sum(-1) / (along * along).sum(-1)).clip(0.0, 1.0)
    distance = np.sqrt(((relative - share[..., None] * along) ** 2).sum(-1)).min(1)
    result: NDArray[np.bool_] = within & (distance > -margin) if margin < 0 else within | (distance < margin)
    return result


def _grown(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask with its neighbours."""
    grown = mask.copy()
    grown[1:] |= mask[:-1]
    grown[:-1] |= mask[1:]
    grown[:, 1:] |= mask[:, :-1]
    grown[:, :-1] |= mask[:, 1:]
    return grown


def _closed(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask without its holes of one pixel."""
    return ~_grown(~_grown(mask))
