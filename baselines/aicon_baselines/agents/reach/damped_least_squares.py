"""Damped least squares, the classical inverse kinematics."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from aicon_baselines.agents.reach.inverse_kinematics import FloatArray, InverseKinematics


@dataclass(frozen=True)
class DampedLeastSquares(InverseKinematics):
    """q̇ = k Jᵀ (J Jᵀ + λ² I)⁻¹ h (Wampler 1986), as a whole within the speeds, joints clamped.

    h is what position (m) and rotation (rad, times a lever in m) of the tip lack. It knows nothing
    of collisions.

    Attributes:
        damping: λ, m/rad.
    """

    damping: float = 0.2

    def velocity(
        self, observation: Mapping[str, FloatArray], way: FloatArray | None = None
    ) -> FloatArray:
        """Velocities of the joints ``(n,)``, rad/s or m/s, in one episode."""
        robot, joints = self.kinematics, observation["q"]
        nominal = self._toward_target(observation) if way is None else way / self.dt
        nominal = nominal / max(1.0, float(np.abs(nominal / robot.speed).max()))

        # A joint that would come to its stop in this step goes there.
        least = (robot.low + self.stop_distance - joints) / self.dt
        most = (robot.high - self.stop_distance - joints) / self.dt
        clamped: FloatArray = np.clip(nominal, np.minimum(least, 0.0), np.maximum(most, 0.0))
        return clamped

    def _toward_target(self, observation: Mapping[str, FloatArray]) -> FloatArray:
        """The velocity k Jᵀ (J Jᵀ + λ² I)⁻¹ h, ``(n,)``, rad/s or m/s."""
        missing = self.missing(observation)
        jacobian = self.kinematics.jacobian() * np.repeat([1.0, self.lever], 3)[:, None]
        if self.orientation == "free":
            missing, jacobian = missing[:3], jacobian[:3]

        damped = jacobian @ jacobian.T + self.damping**2 * np.eye(len(missing))
        nominal: FloatArray = self.gain * jacobian.T @ np.linalg.solve(damped, missing)
        return nominal
