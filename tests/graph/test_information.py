"""What a log tells of the numbers that learn, and which of them it leaves open."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import pytest
import torch
from _inputs.logs import LOGS, random_actions, stacked
from _inputs.random_numbers import normal
from torch import Tensor

from aicon_torch import EKF, Actuator, Affine, Goal, Measurement, Policy, Sensor, WorldModel
from aicon_torch.errors import GraphError
from aicon_torch.graph import Information

STEPS = 6


@dataclass(frozen=True)
class Scaled:
    """A reading of a place in another unit, by two factors of which only the product shows."""

    gain: float = 2.0
    zoom: float = 0.5

    def __call__(self, x: Tensor, z: Tensor) -> Tensor:
        return self.gain * self.zoom * x - z


def walk() -> WorldModel:
    """A random walk of two coordinates that is read with noise."""
    belief = EKF(
        "x", "P", predict=Affine(x=1.0, a="dt"), noise=0.2, initial=((0.0, 0.0), 2.0),
        correct=[Measurement(Scaled(), noise=0.5, size=2)],
    )  # fmt: skip
    return WorldModel(
        sensors={"z": Sensor(2, "m", optional=True)},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[belief],
        goals=[Goal("home", lambda x: x.square().sum(-1))],
        dtype=torch.float64,
    )


def information(*names: str, rows: int = 4000) -> Information:
    """In a log of the walk itself."""
    steps = math.sqrt(0.2) * normal(rows, STEPS, 2, seed=1)
    steps[:, 0] += math.sqrt(2.0) * normal(rows, 2, seed=2)
    readings = steps.cumsum(1) + math.sqrt(0.5) * normal(rows, STEPS, 2, seed=3)
    learner = walk().learn(*names)
    return learner.information({"z": readings}, {"a": torch.zeros(rows, STEPS, 2)})


def test_of_noises_it_is_that_of_the_joint_gaussian_of_all_readings() -> None:
    """The oracle, ½ tr(C⁻¹ ∂ᵢC C⁻¹ ∂ⱼC), has no filter; the log is a sample of it."""
    found = information("x.noise", "x.measurements.0.noise")
    assert found.names == ("x.noise", "x.measurements.0.noise")

    since = torch.minimum(*torch.meshgrid(*[torch.arange(1.0, STEPS + 1)] * 2, indexing="ij"))
    of_walk, of_reading = 0.2 * since.double(), 0.5 * torch.eye(STEPS, dtype=torch.float64)
    whole = torch.linalg.inv(2.0 + of_walk + of_reading)
    slopes = torch.stack((whole @ of_walk, whole @ of_reading))  # by the logarithms
    of_a_coordinate = torch.einsum("iab,jba->ij", slopes, slopes) / 2
    torch.testing.assert_close(found.matrix / 8000, of_a_coordinate, rtol=0.05, atol=0.0)


def test_factors_of_which_only_the_product_shows_are_named() -> None:
    gain, zoom = "x.measurements.0.residual.gain", "x.measurements.0.residual.zoom"
    found = information(gain, zoom, "x.noise")
    (open_direction,) = found.undetermined()
    assert open_direction.keys() == {gain, zoom}
    assert sum(open_direction.values()) == pytest.approx(0, abs=1e-6)
    deviations = found.deviations()
    assert deviations[gain] == deviations[zoom] == math.inf
    assert 0 < deviations["x.noise"] < 0.05
    with pytest.raises(GraphError, match=rf"does not determine .*'{gain}' with .*'{zoom}'"):
        found.check()
    information(gain, "x.noise").check()


def test_a_shorter_log_tells_less() -> None:
    few, many = (information("x.noise", rows=rows) for rows in (2, 200))
    few.check(most=3.0)
    with pytest.raises(GraphError, match=r"'x.noise'"):
        few.check(most=0.3)
    many.check(most=0.3)


@pytest.mark.parametrize("log", ["nav2d", pytest.param("pusht", marks=pytest.mark.slow)])
def test_it_is_that_of_finite_differences_and_adds_up_over_episodes(log: str) -> None:
    policy, observations = LOGS[log].make(), stacked(LOGS[log].observations())
    actions, learner = random_actions(policy), policy.learn(*LOGS[log].numbers)
    found = learner.information(observations, actions)
    wanted = differences(learner, observations, actions)
    torch.testing.assert_close(found.matrix, wanted, rtol=1e-5, atol=1e-5)

    total = torch.zeros_like(found.matrix)
    for row in range(2):
        alone = [{n: s[row] for n, s in part.items()} for part in (observations, actions)]
        total += learner.information(*alone).matrix
    torch.testing.assert_close(total, found.matrix)


def differences(learner: Policy, log: dict[str, Tensor], actions: dict[str, Tensor]) -> Tensor:
    """The information, with slopes by central differences and the formula as it stands."""

    def told() -> list[Tensor]:
        found: list[Tensor] = []
        for innovations in learner.filter(log, actions).innovations.values():
            counts = innovations.counts
            found += [innovations.residual[counts], innovations.spread[counts]]
        return found

    slopes, width = [], 1e-5
    components = [value for parameter in learner.parameters() for value in parameter.view(-1)]
    with torch.no_grad():
        spreads = told()[1::2]
        for component in components:
            above, below = told_at(told, component, width), told_at(told, component, -width)
            pairs = zip(above, below, strict=True)
            slopes.append([(high - low) / (2 * width) for high, low in pairs])

    matrix = torch.zeros(len(slopes), len(slopes), dtype=torch.float64)
    for (i, one), (j, two) in itertools.product(enumerate(slopes), repeat=2):
        for place, spread in enumerate(spreads):
            inverse = torch.linalg.inv(spread)
            off, around = one[2 * place], inverse @ one[2 * place + 1]
            matrix[i, j] += torch.einsum("ta,tab,tb->", off, inverse, two[2 * place])
            matrix[i, j] += torch.einsum("tab,tba->", around, inverse @ two[2 * place + 1]) / 2
    return matrix


def told_at(told: Callable[[], list[Tensor]], component: Tensor, shift: float) -> list[Tensor]:
    """What is told where one number is a little larger."""
    component += shift
    found = told()
    component -= shift
    return found


def test_what_the_command_is_divided_by_is_left_open() -> None:
    """The servo's constants: a command that makes up for them shows nothing of them."""
    policy, log = LOGS["pusht"].make(), LOGS["pusht"]
    learner = policy.learn("x_pusher.noise", "d_pusher.servo.velocity_by_velocity")
    found = learner.information(stacked(log.observations()), random_actions(policy))
    with pytest.raises(GraphError, match="not determine 'd_pusher.servo.velocity_by_velocity'"):
        found.check()


def test_where_nothing_learns_there_is_nothing_to_ask() -> None:
    with pytest.raises(GraphError, match="nothing learns"):
        walk().information({"z": torch.zeros(3, 2)}, {"a": torch.zeros(3, 2)})
