"""2D navigation with bearing and range (Sect. "Conflict Resolution in 2D Navigation").

A disc steers to a target of which it sees the bearing, among obstacles of which it feels the clearance. It knows
neither its position nor a map. Three gradients meet at its displacement x_rob: p₁ brings the target nearer, p₂ makes
its position more certain, p₃ keeps clear of obstacles.

The clearance is one number. The direction in which it grows is estimated from how it changes with motion, so x_obs is
(d, ∇d). Everything is relative to the agent and aligned with the world's axes.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Literal, cast

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.estimation import EKF, Deterministic
from aicon_torch.resolution import Escape
from aicon_torch.estimation import Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.mechanism import Mechanism
from aicon_torch.control import Policy
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.resolution import Resolution


@dataclass(frozen=True)
class Options(Mechanism):
    """Options of the navigation policy, besides those of the mechanism.

    Attributes:
        dt: Time step, s.
        max_speed: Largest speed, m/s.
        sensing: ``"range"``, or ``"range_bearing"`` if the direction of the nearest obstacle is measured as well.
        bearing_noise: Standard deviation of bearings, rad.
        range_noise: Standard deviation of the clearance, m.
        actuation_noise: Standard deviation of each velocity component, m/s.
        prior_range: Distance at which the target is believed before the first step, m.
        prior_range_noise: Its standard deviation, m.
        collision_length: ℓ of p_collision = exp(−d/ℓ), m.
        exit_on_progress: A: exploration ends only once the target is nearer than when it began.
        hold_level: B: exploration holds the level of p_collision.
        along_obstacle: C: exploration moves in the nullspace of p₃ even where p₁ dominates.
        gain: k of the action law, m/s²: the velocity is −k·dt times the resolved gradient, whose length is at most 1.
    """

    dt: float = 0.05
    max_speed: float = 0.5
    sensing: Literal["range", "range_bearing"] = "range"
    bearing_noise: float = 0.03
    range_noise: float = 0.01
    actuation_noise: float = 0.02
    prior_range: float = 5.0
    prior_range_noise: float = 3.0
    collision_length: float = 0.04
    exit_on_progress: bool = True
    hold_level: bool = True
    along_obstacle: bool = True
    gain: float = 20.0

    def __post_init__(self) -> None:
        """Check the quantities that must be positive; resolution and action law check theirs."""
        noises = ("bearing_noise", "range_noise", "actuation_noise", "prior_range_noise")
        for name in ("dt", "max_speed", *noises, "prior_range", "collision_length"):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise OptionError(f"{name}={value!r}: expected a positive number.")


_AS_IN_TEXT = {"relative": False, "partner": "second", "ratio_of": "weights", "average_time": 1.0}
_LITERAL = {
    **_AS_IN_TEXT,
    "exit_on_progress": False,
    "hold_level": False,
    "along_obstacle": False,
}

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "paper_literal": {**_LITERAL, "accumulate": True, "gain": 10.0},
        "steepest": {"resolution": "steepest", "accumulate": True, "gain": 0.3, "max_speed": 0.25},
        "potential_field": {"resolution": "sum", "accumulate": True, "gain": 0.6, "max_speed": 0.25},
        "no_progress_exit": {"exit_on_progress": False},
        "no_level_hold": {"hold_level": False},
        "no_obstacle_nullspace": {"along_obstacle": False},
        "no_projection": {"projector": "none"},
        "no_exploration": {"explore": False},
        "no_softmax": {"temperature": None},
        "no_hysteresis": {"margin": 0.0},
        "as_in_text": _AS_IN_TEXT,
    }
)
"""Named options: ours, the paper's text and nothing else, the baselines, ours without one part each, and ours with the
mechanism's settings nearer to the text (pushT has a preset of this name, too).

Gain, speed and law are the best of the same search for each policy (``scripts/tune.py``).
"""


def move(a: Tensor, dt: float) -> Tensor:
    """x_rob = a·dt: the agent's displacement in one step, ``(*B, 2)``, m."""
    return a * dt


def bearing_to_target(p_tar: Tensor, z_tar: Tensor) -> Tensor:
    """Residual of the target's bearing, ``(*B, 1)``, rad in [−π, π)."""
    return wrap(torch.atan2(p_tar[..., 1:], p_tar[..., :1]) - z_tar)


def bearing_slope(p_tar: Tensor) -> Tensor:
    """∂bearing/∂p = (−y, x)/‖p‖², ``(*B, 1, 2)``, rad/m; nearer than 1 cm as at 1 cm."""
    x, y = p_tar.unbind(-1)
    return (torch.stack((-y, x), -1) / (p_tar * p_tar).sum(-1, keepdim=True).clamp(min=1e-4)).unsqueeze(-2)


def seen_at(z_tar: Tensor, prior_range: float = 5.0, across: float = 0.15, along: float = 3.0) -> tuple[Tensor, Tensor]:
    """The target's prior: at some range in the direction of the first bearing.

    Args:
        z_tar: First bearing, ``(*B, 1)``, rad.
        prior_range: Believed range, m.
        across: Standard deviation across the line of sight, m.
        along: Standard deviation along the line of sight, m.

    Returns:
        Mean ``(*B, 2)``, m, and covariance ``(*B, 2, 2)``, m².
    """
    sight = torch.cat((torch.cos(z_tar), torch.sin(z_tar)), dim=-1)
    spread = (along**2 - across**2) * sight.unsqueeze(-1) * sight.unsqueeze(-2)
    return prior_range * sight, spread + across**2 * torch.eye(2, dtype=z_tar.dtype, device=z_tar.device)


def slide(x_obs: Tensor, x_rob: Tensor) -> Tensor:
    """(d, ∇d) after a displacement: d + ∇d·x_rob, and the same ∇d, ``(*B, 3)``, m."""
    distance, gradient = x_obs[..., :1], x_obs[..., 1:]
    return torch.cat((distance + (gradient * x_rob).sum(-1, keepdim=True), gradient), dim=-1)


def slide_slope(x_rob: Tensor) -> Tensor:
    """∂slide/∂x_obs = (1, x_rob; 0, I), ``(*B, 3, 3)``."""
    carry = torch.nn.functional.pad(x_rob.unsqueeze(-2), (1, 0, 0, 2))
    return torch.eye(3, dtype=x_rob.dtype, device=x_rob.device) + carry


def felt_at(z_obs: Tensor, noise: float = 0.01) -> tuple[Tensor, Tensor]:
    """The obstacle's prior, ``(*B, 3)`` and ``(3, 3)``: the first reading as clearance, no idea of its direction."""
    mean = torch.cat((z_obs, torch.zeros_like(z_obs), torch.zeros_like(z_obs)), dim=-1)
    return mean, torch.diag(z_obs.new_tensor((noise**2, 0.5, 0.5)))


def unit_slope(x_obs: Tensor) -> Tensor:
    """A clearance grows by one metre a metre: |∇d| − 1, ``(*B, 1)``."""
    return cast(Tensor, torch.linalg.vector_norm(x_obs[..., 1:], dim=-1, keepdim=True) - 1.0)


def unit_slope_slope(x_obs: Tensor) -> Tensor:
    """∂(|∇d| − 1)/∂x_obs = (0, ∇d/|∇d|), ``(*B, 1, 3)``; zero where ∇d is."""
    gradient = x_obs[..., 1:]
    unit = gradient / torch.linalg.vector_norm(gradient, dim=-1, keepdim=True).clamp(min=1e-9)
    return torch.nn.functional.pad(unit, (1, 0)).unsqueeze(-2)


def away_from_obstacle(x_obs: Tensor, z_dir: Tensor) -> Tensor:
    """∇d points away from the nearest obstacle: its sum with the direction there is zero, ``(*B, 2)``."""
    return x_obs[..., 1:] + torch.cat((torch.cos(z_dir), torch.sin(z_dir)), dim=-1)


def expected_distance(p_tar: Tensor, P_tar: Tensor) -> Tensor:
    """g₁ = ‖μ_tar‖ + tr Σ_tar, ``(*B,)``."""
    return cast(Tensor, torch.linalg.vector_norm(p_tar, dim=-1) + P_tar.diagonal(dim1=-2, dim2=-1).sum(-1))


def collision_likelihood(x_obs: Tensor, length: float = 0.04) -> Tensor:
    """g₂ = p_collision = exp(−d/ℓ), ``(*B,)``: its gradient keeps growing toward contact."""
    return torch.exp(-x_obs[..., 0] / length)


def wrap(angle: Tensor) -> Tensor:
    """The angle in [−π, π), rad."""
    return torch.remainder(angle + math.pi, 2 * math.pi) - math.pi


def world_model(options: Options) -> WorldModel:
    """The graph of the paper's navigation, with its paths p₁, p₂ and p₃."""
    approach = Affine(p_tar=1.0, x_rob=-1.0)  # the target comes nearer by what the agent moves, m
    clearance = Affine(x_obs=torch.tensor([[1.0, 0.0, 0.0]]), z_obs=-1.0)  # d and its reading agree, m
    feel = [
        Measurement(clearance, options.range_noise**2),
        Measurement(Interconnection(unit_slope, x_obs=unit_slope_slope), 0.05),
    ]
    sensors = {
        "z_tar": Sensor(1, "rad", key="bearing", range=(-2 * math.pi, 2 * math.pi)),
        "z_obs": Sensor(1, "m", key="range", range=(-1.0, 1e3)),
    }
    if options.sensing == "range_bearing":
        sensors["z_dir"] = Sensor(1, "rad", key="obstacle_bearing", range=(-2 * math.pi, 2 * math.pi))
        feel.append(Measurement(away_from_obstacle, options.bearing_noise**2, size=2))
    elif options.sensing != "range":
        raise OptionError(f"sensing={options.sensing!r}: expected 'range' or 'range_bearing'.")
    sight = Measurement(Interconnection(bearing_to_target, p_tar=bearing_slope), options.bearing_noise**2)
    slip = (options.actuation_noise * options.dt) ** 2
    prior = partial(
        seen_at,
        prior_range=options.prior_range,
        across=options.prior_range * options.bearing_noise,
        along=options.prior_range_noise,
    )
    return WorldModel(
        sensors=sensors,
        actuators={"a": Actuator(2, "m/s", limit=options.max_speed)},
        estimators=[
            Deterministic("x_rob", move, is_motion=True),
            EKF(
                "p_tar",
                "P_tar",
                predict=approach,
                noise=slip,
                initial=prior,
                size=2,
                correct=[sight],
            ),
            EKF(
                "x_obs",
                "P_obs",
                predict=Interconnection(slide, x_obs=slide_slope),
                noise=(slip, 2 * options.dt, 2 * options.dt),
                initial=partial(felt_at, noise=options.range_noise),
                size=3,
                correct=feel,
            ),
        ],
        goals=[
            Goal("reach", expected_distance),
            Goal("avoid", partial(collision_likelihood, length=options.collision_length)),
        ],
        dt=options.dt,
        dtype=options.dtype,
    )


def resolution(options: Options) -> Resolution:
    """The rule that the options name, with A, B and C."""
    escape = Escape(
        progress="reach" if options.exit_on_progress else None,
        hold="avoid" if options.hold_level else None,
        along="avoid" if options.along_obstacle else None,
    )
    return options.rule(escape)


def build(options: Options) -> Policy:
    """The navigation policy."""
    return Policy(world_model(options), resolution(options), options.law())
