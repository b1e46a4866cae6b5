"""The batched kernel: N disc agents, each in its own world.

All arrays put the coordinate first, (2, N) for points and (2, N, S) for the S boundary segments of
each world, so that every operation runs over contiguous memory, and a step is a fixed, small number
of numpy calls for any N. Only additions, products, square roots and `arctan2` on contiguous rows
occur: each world's trajectory is the same number for number whether it is stepped alone or in a
batch.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aicon_envs.arrays import BoolArray, FloatArray
from aicon_envs.nav2d.boundaries import Boundaries
from aicon_envs.nav2d.noise import NoiseStream
from aicon_envs.nav2d.physics import Physics
from aicon_envs.nav2d.world import NavigationMap

SensorArray = NDArray[np.float32]

ARRIVAL_DISTANCE = 0.2
"""Distance to the target below which the agent has arrived, m."""

LARGEST_SQUARED = 1e150
"""A command as large as this can still be squared, m/s."""


class Simulation:
    """N disc agents with velocity control.

    With command u (norm limited to max_speed), noise w ~ N(0, actuation_noise² I) and position p:
    p⁺ = p + (u + w) dt, in m. With u = 0 the brakes hold, p⁺ = p. A world whose episode has ended
    no longer moves.

    Args:
        num_worlds: Number N of worlds.
        physics: Constants of the agents and their sensors.

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

        self._noise = NoiseStream(num_worlds, physics)
        self._boundaries = Boundaries(num_worlds)
        self._evaluate()

    def load(
        self,
        indices: Sequence[int],
        maps: Sequence[NavigationMap],
        generators: Sequence[np.random.Generator],
    ) -> None:
        """Put the agents of the worlds `indices` at the start of `maps`, each with fresh noise."""
        self._boundaries.load(indices, [world.obstacles for world in maps])
        self._noise.restart(indices, generators)

        columns = list(indices)
        self.position[:, columns] = np.array([world.start for world in maps]).T
        self.target[:, columns] = np.array([world.target for world in maps]).T
        self.active[columns] = True
        self.reward[columns] = 0.0

        self._evaluate()

    def step(self, command: FloatArray) -> None:
        """Move every active agent by one step.

        Args:
            command: Velocities, (N, 2), m/s, world frame.
        """
        noise = self._noise.advance()

        # Limit the norm of the command, add the noise of motors that drive, and move.
        velocity = command.T.copy()
        np.clip(velocity, -LARGEST_SQUARED, LARGEST_SQUARED, out=velocity)
        drives = (velocity != 0.0).any(0)
        max_speed = self.physics.max_speed
        velocity *= max_speed / np.maximum(_norm(velocity), max_speed)
        velocity += noise.velocity * drives
        self.position = self.position + velocity * (self.physics.dt * self.active)

        was_active = self.active
        distance_before = self.distance
        self._evaluate()
        self.active = was_active & ~self.ended

        # Arrival and collision count once, in the step in which they happen.
        event = 1.0 * self.success - self.collision
        self.reward = distance_before - self.distance + was_active * event

    def sense_bearing(self) -> SensorArray:
        """Return the noisy direction to the target, (N,), rad.

        The noise of a step is drawn once: reading a sensor twice gives the same.
        """
        return _direction(self._to_target, self._noise.current.bearing)

    def sense_range(self) -> SensorArray:
        """Return the noisy clearance, (N,), m, within [0, max_range]."""
        clearance: FloatArray = self.clearance + self._noise.current.clearance
        np.maximum(clearance, 0.0, out=clearance)
        np.minimum(clearance, self.physics.max_range, out=clearance)
        return clearance.astype(np.float32)

    def sense_obstacle_bearing(self) -> SensorArray:
        """Return the noisy direction to the nearest obstacle point, (N,), rad; 0 without any."""
        return _direction(self._to_obstacle, self._noise.current.obstacle_bearing)

    def _evaluate(self) -> None:
        """Derive every true quantity from the positions."""
        self._to_target = self.target - self.position
        self._to_obstacle = self._boundaries.nearest(self.position)

        self.distance = _norm(self._to_target)
        clearance = _norm(self._to_obstacle) - self.physics.radius
        self.clearance = np.minimum(clearance, self.physics.max_range)

        # A collision is no success, even at the target.
        arrived = self.distance < ARRIVAL_DISTANCE
        self.collision = self.clearance <= 0.0
        self.success = arrived & ~self.collision
        self.ended = arrived | self.collision


def _norm(vector: FloatArray) -> FloatArray:
    """Return the norms of vectors (2, N), (N,)."""
    squared = vector * vector
    norm: FloatArray = np.sqrt(squared[0] + squared[1])
    return norm


def _direction(vector: FloatArray, noise: FloatArray) -> SensorArray:
    """Return the noisy directions of vectors (2, N), (N,), rad, in [-π, π)."""
    # The noise may carry the angle beyond ±π: wrap it.
    angle: FloatArray = np.arctan2(vector[1], vector[0])
    angle += noise + np.pi
    angle %= 2.0 * np.pi
    angle -= np.pi
    return angle.astype(np.float32)
