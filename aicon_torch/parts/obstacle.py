"""A ball, still or moving, and how far a robot's capsules are from it."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from aicon_torch.errors import OptionError
from aicon_torch.estimation import EKF, Measurement, covariance_name
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.parts.hinge import Margin, SquaredHinge
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.parts.self_collision import Capsule, moving_links, segment_distance
from aicon_torch.quantities import as_number, as_size
from aicon_torch.validation import check_positive


class Obstacle(Margin, nn.Module):
    """g = w Σ max(0, 1 − dᵢ/d₀)², where dᵢ is the distance of capsule i to a ball.

    Objects of other shapes are :class:`aicon_torch.parts.Solids`.

    Args:
        radius: Of the ball, m.
        capsules: The shape of the robot; those on its base are left out, since they cannot give
            way.
        cost: Margin d₀ (m) and weight w.

    Raises:
        OptionError: If a radius is not positive, or no capsule is on a link that moves.

    Example:
        >>> ball = Obstacle(0.08, shape.capsules, SquaredHinge(margin=0.02, weight=1.0))
        >>> Goal("ball", Interconnection(ball, inputs=["x_body", "x_ball"]), safety=True)
    """

    radii: Tensor

    def __init__(self, radius: float, capsules: Sequence[Capsule], cost: SquaredHinge) -> None:
        super().__init__()
        self.radius, self.cost = radius, cost
        check_positive(self, ("radius",))
        self.moving = moving_links(capsules)
        radii = [capsules[index].radius for index in self.moving]
        self.register_buffer("radii", torch.tensor(radii, dtype=torch.float64))

    def forward(self, x_body: Tensor, x_obstacle: Tensor) -> Tensor:
        """The cost ``(*B,)``.

        Args:
            x_body: The segments of the robot's capsules, ``(*B, C, 6)``, m.
            x_obstacle: Where the ball is, ``(*B, 3)``, m; what follows, such as its velocity,
                is not read.
        """
        return self.cost(self.distances(x_body, x_obstacle))

    def distances(self, x_body: Tensor, x_obstacle: Tensor) -> Tensor:
        """The distance of each capsule, ``(*B, C)``, m; negative where they overlap."""
        centre = x_obstacle[..., None, :3]
        start, end = torch.split(x_body[..., self.moving, :], 3, dim=-1)
        segment = torch.cat((start - centre, end - centre), dim=-1)

        # From there the centre is the origin, a segment without length.
        of_axes = segment_distance(segment, torch.zeros_like(segment))
        return of_axes - self.radius - self.radii.to(x_body)


def drift(acceleration: float, dt: float) -> tuple[float, float]:
    """What an unknown acceleration σ, m/s², adds in a step to the variances of place and velocity.

    As long as the step lasts, it moves by σ dt²/2, and the velocity changes by σ dt.
    """
    return (acceleration * dt**2 / 2) ** 2, (acceleration * dt) ** 2


def moved_evenly(x: Tensor, dt: Tensor) -> Tensor:
    """(p + v dt, v): position and velocity ``(*B, 2 n)``, m and m/s, after a time dt, s."""
    position, velocity = x.chunk(2, dim=-1)
    return torch.cat((position + velocity * dt, velocity), dim=-1)


class Transition(nn.Module):
    """The Jacobian of :func:`moved_evenly` by position and velocity: (I, I dt; 0, I).

    Args:
        size: Number n of components of a position.
    """

    identity: Tensor
    by_time: Tensor

    def __init__(self, size: int) -> None:
        super().__init__()

        # (0, I; 0, 0) is the identity moved n columns on, without what comes round again.
        identity = torch.eye(2 * size, dtype=torch.float64)
        self.register_buffer("identity", identity)
        self.register_buffer("by_time", identity.roll(size, 1).triu(1))

    def forward(self, dt: Tensor) -> Tensor:
        """``(2 n, 2 n)``, or ``(*B, 2 n, 2 n)`` by a time of each row, ``(*B, 1)``, s."""
        return self.identity + dt.unsqueeze(-1) * self.by_time


def moving_point(
    name: str,
    reading: str,
    dt: float,
    noise: float = 0.002,
    acceleration: float = 2.0,
    speed: float = 0.5,
    size: int = 3,
) -> EKF:
    """Position and velocity of something that is seen: a Kalman filter with constant velocity.

    p⁻ = p + v dt, v⁻ = v + N(0, (σ dt)²) in each component.

    Args:
        name: Of the estimate ``(*B, 2 n)``, m and m/s, such as ``"x_ball"``; its covariance is
            ``"P_ball"``.
        reading: The sensor of its position, ``(*B, n)``, m.
        dt: Time step in which the velocity changes, s; the motion takes as long as a clock tells.
        noise: Standard deviation of a reading, m.
        acceleration: σ, m/s².
        speed: Standard deviation of the velocity before the first motion, m/s.
        size: n: 3 in space, 2 in a plane.

    Raises:
        GraphError: If the size is no whole number above 0.
        OptionError: If a number is not above 0.

    Example:
        >>> moving_point("x_ball", "z_ball", dt=0.02)
    """
    size = as_size(f"moving_point {name!r}:", size)
    numbers = {"dt": dt, "noise": noise, "acceleration": acceleration, "speed": speed}
    for option, number in numbers.items():
        if not 0 < as_number(number) < math.inf:
            raise OptionError(f"{option}={number!r}: expected a positive number.")
    position = torch.eye(2 * size, dtype=torch.float64)[:size]

    of_position, of_velocity = drift(acceleration, dt)
    difference: dict[str, float | Tensor] = {name: position, reading: -1.0}
    prior = ReadingPrior((noise**2,) * size + (speed**2,) * size)
    return EKF(
        name,
        covariance_name(name),
        predict=Interconnection(moved_evenly, [name, "dt"], **{name: Transition(size)}),
        noise=(of_position,) * size + (of_velocity,) * size,
        initial=first_belief(prior, reading),
        correct=[Measurement(Affine(**difference), noise**2, size=size)],
        size=2 * size,
    )
