"""The physical constants of the navigation task."""

import dataclasses

from aicon_envs.checks import check_number

_POSITIVE = ("max_speed", "dt", "radius", "max_range")


@dataclasses.dataclass(frozen=True)
class Physics:
    """Constants of the disc agent and its sensors.

    Attributes:
        bearing_noise: Standard deviation of every sensed bearing, rad.
        range_noise: Standard deviation of the sensed clearance, m.
        actuation_noise: Standard deviation of the velocity per axis, m/s.
        max_speed: Upper limit of the commanded speed (Euclidean norm), m/s.
        dt: Duration of one step, s.
        radius: Radius of the agent, m.
        max_range: Largest clearance that the sensor reports, m.

    Raises:
        ValueError: If a constant is not finite, is negative or, where it must be, not positive; or
            if one step could carry the agent through an obstacle,
            (max_speed + 8 actuation_noise) dt > 2 radius.
    """

    bearing_noise: float = 0.03
    range_noise: float = 0.01
    actuation_noise: float = 0.02
    max_speed: float = 0.5
    dt: float = 0.05
    radius: float = 0.1
    max_range: float = 20.0

    def __post_init__(self) -> None:
        """Check every constant; numbers of any kind become plain floats."""
        for name, value in dataclasses.asdict(self).items():
            number = check_number(name, value, positive=name in _POSITIVE)
            object.__setattr__(self, name, number)

        # Eight standard deviations: noise that large does not happen in any number of steps.
        fastest = self.max_speed + 8.0 * self.actuation_noise
        if fastest * self.dt > 2.0 * self.radius:
            raise ValueError(
                "one step may not carry the agent through an obstacle: "
                f"(max_speed + 8 actuation_noise) dt must be <= 2 radius, got {self}"
            )
