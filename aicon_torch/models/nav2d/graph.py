"""2D navigation with bearing and range (Sect. "Conflict Resolution in 2D Navigation").

A disc steers to a target of which it sees the bearing, among obstacles of which it feels the
clearance. It knows neither its position nor a map. Three gradients meet at its displacement x_rob:
p₁ brings the target nearer, p₂ makes its position more certain, p₃ keeps clear of obstacles.

The clearance is one number. The direction in which it grows is estimated from how it changes with
motion, so x_obs is (d, ∇d). Everything is relative to the agent and aligned with the world's axes.
"""

import math

from torch import Tensor

from aicon_torch.estimation import Deterministic
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.models.nav2d.options import Options
from aicon_torch.models.watched import watched
from aicon_torch.parts.clearance import Clearance, ClearanceLimits
from aicon_torch.parts.clock import clock
from aicon_torch.parts.landmark import BearingPrior, Landmark
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Sensor

COLLISION_LENGTH = 0.04
"""ℓ of p_collision = exp(−d/ℓ), m: clearances of a few ℓ are where the agent slides along walls."""

TARGET_DISTANCE = 5.0
"""Distance at which the target is believed before the first step, m: a bearing does not say it."""

TARGET_DISTANCE_DEVIATION = 3.0
"""Its standard deviation, m: the target is anywhere from near to a few rooms away."""

LONGEST_RANGE = 20.0
"""Largest clearance that the sensor reports, m."""

JUMP_DEVIATIONS = 6.0
"""Change of a reading between two steps that noise may bring, in its standard deviations."""

PASSING_DISTANCE = 0.1
"""Distance at which the agent may pass a landmark, whose bearing then turns fast, m."""

MAX_GAP = 1.0
"""Steps without a reading after which the agent slows down."""

JUMPS = 3
"""Steps for which a velocity is wrong after the direction to the nearest obstacle has jumped."""


def build(options: Options) -> Policy:
    """The navigation policy."""
    return Policy(world_model(options), options.resolution, options.law)


def world_model(options: Options) -> WorldModel:
    """The graph of the paper's navigation, with its paths p₁, p₂ and p₃."""
    robot = Deterministic("x_rob", displacement, is_motion=True)
    target, obstacle = _target(options), _obstacle(options)

    # The cost of reaching has the paths p₁ and p₂, that of avoiding p₃.
    reach = Goal("reach", target.expected_distance())
    avoid = Goal("avoid", obstacle.collision_likelihood(COLLISION_LENGTH))

    return WorldModel(
        sensors=_sensors(options),
        actuators={"a": _actuator(options, obstacle)},
        estimators=[robot, target.estimator(), obstacle.estimator()],
        goals=[reach, avoid],
        dt=options.dt,
        clock="z_elapsed",
        dtype=options.dtype,
    )


def displacement(a: Tensor, dt: Tensor) -> Tensor:
    """x_rob = a·dt: the agent's displacement in one step ``(*B, 2)``, m, at a velocity in m/s."""
    return a * dt


def _sensors(options: Options) -> dict[str, Sensor]:
    """What the agent reads; angles may come from any one turn."""
    # All readings are noisy, so they change while the agent moves.
    late = watched(options.dt, options.delay, MAX_GAP if options.watchdog else None)
    if options.watchdog:
        late["driven_by"] = "a"
    angle = {"range": (-2 * math.pi, 2 * math.pi), "period": 2 * math.pi, **late}

    # A reading that changes faster than this is no reading: motion past something near, and noise.
    jumps = JUMP_DEVIATIONS / options.dt
    turning = options.max_speed / PASSING_DISTANCE + jumps * options.bearing_noise
    fastest = options.max_speed + jumps * options.range_noise
    sensors = {
        "z_tar": Sensor(1, "rad", key="bearing", rate_limit=turning, **angle),
        "z_obs": Sensor(
            1, "m", key="range", range=(-1.0, LONGEST_RANGE), rate_limit=fastest, **late
        ),
    }

    if options.sensing == "range_bearing":
        sensors["z_dir"] = Sensor(1, "rad", key="obstacle_bearing", **angle)
    sensors["z_elapsed"] = clock()
    return sensors


def _actuator(options: Options, obstacle: Clearance) -> Actuator:
    """The velocity, limited near obstacles where readings or actions are late, or readings wrong.

    The nearest point of an obstacle jumps from one wall to another. Where its direction is read,
    the velocity turns with it, and is the wrong one for a few steps.
    """
    jumps = JUMPS if options.sensing == "range_bearing" else 0
    latency = (options.action_delay + jumps) * options.dt
    offset = options.range_offset

    # What is read and done at once needs no limit besides the goal that avoids obstacles.
    limits = []
    if options.delay or latency or offset:
        limits = [obstacle.limits(ClearanceLimits.for_latency(latency, offset))]
    return Actuator(2, "m/s", limit=options.max_speed, constraints=limits, key="executed")


def _target(options: Options) -> Landmark:
    """p_tar, P_tar: where the target is, from its bearing and from the agent's motion."""
    # A bearing tells the direction at once; the distance takes some motion across it.
    prior = BearingPrior(
        TARGET_DISTANCE,
        across=TARGET_DISTANCE * options.bearing_noise,
        along=TARGET_DISTANCE_DEVIATION,
    )
    return Landmark(
        "p_tar",
        "z_tar",
        noise=options.bearing_noise,
        motion_noise=_motion_noise(options),
        prior=prior,
        delay=options.delay,
    )


def _obstacle(options: Options) -> Clearance:
    """x_obs, P_obs: the clearance and its direction, from its reading and the agent's motion."""
    return Clearance(
        "x_obs",
        "z_obs",
        noise=options.range_noise,
        motion_noise=_motion_noise(options),
        dt=options.dt,
        direction="z_dir" if options.sensing == "range_bearing" else None,
        direction_noise=options.bearing_noise,
        delay=options.delay,
    )


def _motion_noise(options: Options) -> float:
    """Standard deviation of each component of a displacement, m."""
    return options.actuation_noise * options.dt
