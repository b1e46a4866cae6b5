"""The batched kernel: N disc agents, each in its own world.

All arrays put the coordinate first, (2, N) for points and (2, N, S) for the S boundary segments of each world, so that
every operation runs over contiguous memory, and a step is a fixed, small number of numpy calls for any N.
Only additions, products, square roots and `arctan2` on contiguous rows occur: each world's trajectory is the same
number for number whether it is stepped alone or in a batch.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from aicon_envs.nav2d.physics import Physics
from aicon_envs.nav2d.world import NavigationMap, Vertices, union

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
SensorArray = NDArray[np.float32]

ARRIVAL_DISTANCE = 0.2
"""Distance to the target below which the agent has arrived, m."""

_FAR = 1e9
"""Where padding segments lie, m: out of every sensor's range."""


class Simulation:
    """N disc agents with velocity control.

    With command u (norm limited to max_speed), noise w ~ N(0, actuation_noise² I) and position p:
    p⁺ = p + (u + w) dt, in m. A world whose episode has ended no longer moves.

    Attributes:
        position: True positions, (2, N), m.
        target: Targets, (2, N), m.
        distance: Distance to the target, (N,), m.
        clearance: Distance to the nearest obstacle minus the radius, at most max_range, (N,), m.
        reward: Decrease of the distance in the last step, +1 at arrival, -1 at a collision, (N,).
        success: The agent has arrived and has not collided, (N,).
        collision: The clearance is not positive, (N,).
        ended: The agent has arrived or collided, (N,).
        active: The world still moves, (N,).
    """

    def __init__(self, num_worlds: int, physics: Physics) -> None:
        """Prepare `num_worlds` empty worlds; `load` each before stepping."""
        self.physics = physics
        self.position: FloatArray = np.zeros((2, num_worlds))
        self.target: FloatArray = np.zeros((2, num_worlds))
        self.reward: FloatArray = np.zeros(num_worlds)
        self.active: BoolArray = np.ones(num_worlds, dtype=np.bool_)
        self._noise = _NoiseStream(num_worlds, physics)
        self._walls = _Walls(num_worlds)
        self._update()

    def load(
        self, indices: Sequence[int], maps: Sequence[NavigationMap], generators: Sequence[np.random.Generator]
    ) -> None:
        """Put the agents of the worlds `indices` at the start of `maps`, with a fresh source of noise each."""
        self._walls.load(indices, [map_.obstacles for map_ in maps])
        self._noise.restart(indices, generators)
        columns = list(indices)
        self.position[:, columns] = np.array([map_.start for map_ in maps]).T
        self.target[:, columns] = np.array([map_.target for map_ in maps]).T
        self.active[columns] = True
        self.reward[columns] = 0.0
        self._update()

    def step(self, command: FloatArray) -> None:
        """Move every active agent by one step.

        Args:
            command: Velocities, (N, 2), m/s, world frame.
        """
        noise = self._noise.advance()
        velocity = command.T.copy()
        limit = self.physics.max_speed
        velocity *= limit / np.maximum(_norm(velocity), limit)
        velocity += noise[:2]
        self.position = self.position + velocity * (self.physics.dt * self.active)
        before, active = self.distance, self.active
        self._update()
        self.active = active & ~self.ended
        self.reward = before - self.distance + active * (1.0 * self.success - self.collision)

    def sense_bearing(self) -> SensorArray:
        """Return the noisy direction to the target, (N,), rad.

        The noise of a step is drawn once: reading a sensor twice gives the same.
        """
        return _direction(self._to_target, self._noise.current[2])

    def sense_range(self) -> SensorArray:
        """Return the noisy clearance, (N,), m, within [0, max_range]."""
        clearance: FloatArray = self.clearance + self._noise.current[3]
        np.maximum(clearance, 0.0, out=clearance)
        np.minimum(clearance, self.physics.max_range, out=clearance)
        return clearance.astype(np.float32)

    def sense_obstacle_bearing(self) -> SensorArray:
        """Return the noisy direction to the nearest obstacle point, (N,), rad; 0 plus noise without obstacles."""
        return _direction(self._to_wall, self._noise.current[4])

    def _update(self) -> None:
        """Derive every true quantity from the positions."""
        self._to_target = self.target - self.position
        self._to_wall = self._walls.nearest(self.position)
        self.distance = _norm(self._to_target)
        self.clearance = np.minimum(_norm(self._to_wall) - self.physics.radius, self.physics.max_range)
        self.collision = self.clearance <= 0.0
        near = self.distance < ARRIVAL_DISTANCE
        self.success = near & ~self.collision
        self.ended = near | self.collision


class _Walls:
    """Boundary segments a + t d, t in [0, 1], of N worlds, padded to the same number S.

    Held as one array (3, 2, N, S) of a, d and d / |d|² (which projects a point onto the segment).
    """

    def __init__(self, num_worlds: int) -> None:
        self._rows = np.arange(num_worlds)
        self._segments = _padding(num_worlds, 1)

    def load(self, indices: Sequence[int], obstacles: Sequence[list[Vertices]]) -> None:
        loaded = [boundary_segments(polygons) for polygons in obstacles]
        self._reserve(max(segments.shape[2] for segments in loaded), keep=len(indices) < len(self._rows))
        for index, segments in zip(indices, loaded, strict=True):
            self._segments[:, :, index] = _padding(1, self._segments.shape[3])[:, :, 0]
            self._segments[:, :, index, : segments.shape[2]] = segments

    def nearest(self, position: FloatArray) -> FloatArray:
        """Return the vectors from the positions (2, N) to the nearest boundary points, (2, N), m."""
        start, direction, projection = self._segments
        away = position[:, :, np.newaxis] - start
        product = away * projection
        along = product[0] + product[1]
        np.maximum(along, 0.0, out=along)
        np.minimum(along, 1.0, out=along)
        away -= along * direction
        squared = away * away
        index = (squared[0] + squared[1]).argmin(axis=1)
        nearest: FloatArray = -away[:, self._rows, index]
        return nearest

    def _reserve(self, size: int, keep: bool) -> None:
        """Make room for `size` segments a world; only when all worlds are replaced does the room shrink."""
        old = self._segments
        if keep and size <= old.shape[3]:
            return
        self._segments = _padding(len(self._rows), max(size, 1))
        if keep:
            self._segments[:, :, :, : old.shape[3]] = old


class _NoiseStream:
    """Standard normal numbers for N worlds, five a step, each world from a generator of its own, scaled.

    The numbers are drawn in blocks; the block length does not change them, because a generator yields the same
    sequence however it is cut.
    """

    _BLOCK = 128

    def __init__(self, num_worlds: int, physics: Physics) -> None:
        actuation, bearing, clearance = physics.actuation_noise, physics.bearing_noise, physics.range_noise
        self._scale = np.array([actuation, actuation, bearing, clearance, bearing])
        self._generators = [np.random.default_rng(0) for _ in range(num_worlds)]
        self._block: FloatArray = np.zeros((self._BLOCK, len(self._scale), num_worlds))
        self._next = 0
        self.current: FloatArray = np.zeros((len(self._scale), num_worlds))

    def restart(self, indices: Sequence[int], generators: Sequence[np.random.Generator]) -> None:
        for index, generator in zip(indices, generators, strict=True):
            self._generators[index] = generator
            self.current[:, index] = self._draw(generator, 1)[0]
            self._block[self._next :, :, index] = self._draw(generator, self._BLOCK - self._next)

    def advance(self) -> FloatArray:
        if self._next == self._BLOCK:
            self._next = 0
            for index, generator in enumerate(self._generators):
                self._block[:, :, index] = self._draw(generator, self._BLOCK)
        self.current = self._block[self._next]
        self._next += 1
        return self.current

    def _draw(self, generator: np.random.Generator, steps: int) -> FloatArray:
        numbers: FloatArray = generator.standard_normal((steps, len(self._scale)))
        numbers *= self._scale
        return numbers


def boundary_segments(obstacles: list[Vertices]) -> FloatArray:
    """Return the boundary of the union of polygons as segments, array (3, 2, S) of a, d and d / |d|² by (x, y)."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(union(obstacles)))]
    if not rings:
        return np.zeros((3, 2, 0))
    start = np.concatenate([ring[:-1] for ring in rings]).T
    direction = np.concatenate([np.diff(ring, axis=0) for ring in rings]).T
    squared_length = (direction**2).sum(axis=0)
    proper = squared_length > 0.0
    return np.stack([start, direction, direction / np.where(proper, squared_length, 1.0)])[:, :, proper]


def _padding(num_worlds: int, size: int) -> FloatArray:
    """Return segments of no length at (_FAR, 0)."""
    segments = np.zeros((3, 2, num_worlds, size))
    segments[0, 0] = _FAR
    return segments


def _norm(vector: FloatArray) -> FloatArray:
    squared = vector * vector
    norm: FloatArray = np.sqrt(squared[0] + squared[1])
    return norm


def _direction(vector: FloatArray, noise: FloatArray) -> SensorArray:
    """Return the noisy directions of vectors (2, N), (N,), rad, in [-π, π)."""
    angle: FloatArray = np.arctan2(vector[1], vector[0])
    angle += noise + np.pi
    angle %= 2.0 * np.pi
    angle -= np.pi
    return angle.astype(np.float32)
