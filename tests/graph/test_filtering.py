"""A log is filtered as a policy would, and differentiably."""

from typing import Any

import pytest
import torch
from _inputs.logs import AGREES, LOGS, STEPS, Log, random_actions, slope_off, stacked
from _inputs.random_numbers import normal
from _inputs.tracking import tracking_model

from aicon_torch import EKF, Actuator, Affine, Goal, Measurement, Policy, Sensor, WorldModel
from aicon_torch.errors import ObservationError

LOG = pytest.mark.parametrize("log", LOGS.values(), ids=LOGS)
MANY = ("nav2d", "arm_push", "pusht", "pusht, with a noise that grows with the push")
SOME_LOGS_AT_FIRST = pytest.mark.parametrize(
    "log",
    [
        pytest.param(log, id=name, marks=[pytest.mark.slow] * (name in MANY))
        for name, log in LOGS.items()
    ],
)
"""Some have many numbers, each with two more filters for its differences."""


@LOG
def test_estimates_are_those_of_a_policy_that_somebody_else_acts_for(log: Log) -> None:
    policy, observations = log.make(), log.observations()
    actions = random_actions(policy)
    filtered = policy.filter(stacked(observations), actions)

    memory = None
    for step, observation in enumerate(observations):
        done = {name: series[:, step - 1] for name, series in actions.items()}
        memory = policy.estimate(observation, memory, done if step else None)
        for name, series in filtered.estimates.items():
            torch.testing.assert_close(series[:, step], memory[name], rtol=0, atol=0)


@pytest.mark.parametrize("mode", (torch.no_grad, torch.inference_mode))
def test_where_no_gradient_is_recorded_there_is_none(mode: Any) -> None:
    log = LOGS["nav2d"]
    policy = log.learner()
    with mode():
        filtered = policy.filter(stacked(log.observations()), random_actions(policy))
    assert not any(series.requires_grad for series in filtered.estimates.values())


@SOME_LOGS_AT_FIRST
def test_likelihood_has_the_gradient_of_finite_differences(log: Log) -> None:
    learner, observations = log.learner(), stacked(log.observations())
    actions = random_actions(learner)

    def likelihood() -> torch.Tensor:
        filtered = learner.filter(observations, actions)
        estimates = [filtered.estimates[name].square().mean() for name in learner.model.owners]
        return filtered.log_likelihood().sum() + torch.stack(estimates).sum()

    parameters = dict(learner.named_parameters())
    slopes = torch.autograd.grad(likelihood(), list(parameters.values()), allow_unused=True)
    found = 0
    for (name, parameter), slope in zip(parameters.items(), slopes, strict=True):
        if slope is None:  # it has an effect on actions only
            continue
        found += 1
        assert slope.abs().max() > 0, name
        assert slope_off(likelihood, parameter, slope.sum()) <= AGREES, name
    assert found >= 2


@LOG
def test_a_batch_equals_its_rows(log: Log) -> None:
    policy, observations = log.make(), stacked(log.observations())
    actions = random_actions(policy)
    together = policy.filter(observations, actions).log_likelihood()

    for row in range(len(together)):
        alone = policy.filter(
            {name: series[row] for name, series in observations.items()},
            {name: series[row] for name, series in actions.items()},
        )
        torch.testing.assert_close(alone.log_likelihood(), together[row], rtol=1e-9, atol=1e-9)


# --- a filter whose likelihood is known


def expected(x: torch.Tensor) -> torch.Tensor:
    return x.square().sum(-1)


def tracker(gate: float | None = None) -> WorldModel:
    position = Measurement(Affine(x=1.0, z=-1.0), noise=0.5, size=2, gate=gate)
    belief = EKF(
        "x", "P", predict=Affine(x=1.0, a="dt"), noise=0.2, initial=((0.0, 0.0), 2.0),
        correct=[position],
    )  # fmt: skip
    return WorldModel(
        sensors={"z": Sensor(2, "m", optional=True)},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[belief],
        goals=[Goal("home", expected)],
        dtype=torch.float64,
    )


def test_likelihood_is_that_of_the_joint_gaussian_of_all_readings() -> None:
    """The oracle is the covariance of a random walk that is read with noise; it has no filter."""
    readings, steps = normal(3, 6, 2, seed=1), 6
    filtered = tracker().filter({"z": readings}, {"a": torch.zeros(3, steps, 2)})

    earlier = torch.minimum(*torch.meshgrid(*[torch.arange(1.0, steps + 1)] * 2, indexing="ij"))
    covariance = 2.0 + 0.2 * earlier.double() + 0.5 * torch.eye(steps, dtype=torch.float64)
    joint = torch.distributions.MultivariateNormal(torch.zeros(steps).double(), covariance)
    wanted = joint.log_prob(readings[..., 0]) + joint.log_prob(readings[..., 1])
    torch.testing.assert_close(filtered.log_likelihood(), wanted)
    assert filtered.readings().tolist() == [steps] * 3


def test_a_reading_that_is_missing_tells_nothing() -> None:
    readings = normal(6, 2, seed=1)
    readings[2] = torch.nan
    filtered = tracker().filter({"z": readings}, {"a": torch.zeros(6, 2)})

    innovations = filtered.innovations["x.measurements.0"]
    assert innovations.counts.tolist() == [True, True, False, True, True, True]
    assert innovations.log_likelihood()[2] == 0
    assert filtered.log_likelihood().isfinite()


def test_refusing_every_reading_is_not_likely() -> None:
    readings = normal(6, 2, seed=1)
    readings[3] = 50.0
    believing, gated = (
        tracker(gate).filter({"z": readings}, {"a": torch.zeros(6, 2)}) for gate in (None, 9.0)
    )
    innovations = gated.innovations["x.measurements.0"]
    assert innovations.counts.all()
    assert believing.log_likelihood() < gated.log_likelihood() < 0
    assert innovations.log_likelihood()[3] < innovations.log_likelihood()[2]


def test_truncation_ends_the_gradient_and_changes_no_number() -> None:
    model = tracker().learn("x.noise", "x.prior_covariance")
    readings, actions = {"z": normal(STEPS, 2, seed=1)}, {"a": torch.zeros(STEPS, 2)}
    whole, truncated = (model.filter(readings, actions, truncate=k) for k in (None, 4))
    torch.testing.assert_close(whole.log_likelihood(), truncated.log_likelihood())

    last = [filtered.estimates["x"][-1].sum() for filtered in (whole, truncated)]
    prior = model.learned["x/prior_covariance"].theta
    assert torch.autograd.grad(last[0], prior)[0].abs().sum() > 0
    assert not torch.autograd.grad(last[1], prior)[0].any()


def test_a_truncated_gradient_reaches_what_its_window_begins_with() -> None:
    model = tracker().learn("x.noise", "x.prior_covariance")
    readings, actions = {"z": normal(STEPS, 2, seed=1)}, {"a": torch.zeros(STEPS, 2)}
    prior = model.learned["x/prior_covariance"].theta

    found = {}
    for truncate in (None, 4, STEPS):
        filtered = model.filter(readings, actions, truncate=truncate)
        (found[truncate],) = torch.autograd.grad(filtered.estimates["x"][:4].sum(), prior)
    assert found[None].abs().sum() > 0
    torch.testing.assert_close(found[4], found[None])
    torch.testing.assert_close(found[STEPS], found[None])


@pytest.mark.parametrize(
    ("readings", "actions", "message"),
    [
        ({"y": (5, 2)}, {"a": (5, 2)}, "no 'y'"),
        ({"z": (5, 3)}, {"a": (5, 2)}, r"\(5, 2\).*got \(5, 3\)"),
        ({"z": (5, 2)}, {"a": (4, 2)}, r"\(5, 2\).*got \(4, 2\)"),
        ({"z": (5, 2)}, {}, "'a' is missing"),
        ({"z": (2,)}, {"a": (2,)}, "steps"),
    ],
    ids=["an unknown sensor", "a wrong size", "fewer actions", "no actions", "no steps"],
)
def test_a_wrong_log_is_an_error(
    readings: dict[str, tuple[int, ...]], actions: dict[str, tuple[int, ...]], message: str
) -> None:
    given = [{n: torch.zeros(shape) for n, shape in part.items()} for part in (readings, actions)]
    with pytest.raises(ObservationError, match=message):
        tracker().filter(*given)


@pytest.mark.parametrize(
    ("log", "truncate", "message"),
    [
        ({}, None, "readings: expected a series of one of 'z'"),
        ({"z": "a"}, None, "'z': expected numbers"),
        ({"z.age": torch.zeros(4), "z": torch.ones(5, 2)}, None, r"'z.age'.*\(5,\), got \(4,\)"),
        *(({"z": torch.ones(5, 2)}, steps, f"truncate={steps}") for steps in (0, -1, 0.5)),
    ],
)
def test_what_is_no_series_is_named(log: Any, truncate: Any, message: str) -> None:
    sensors = {"z": Sensor(2, "m", optional=True, age=0.1)}
    with pytest.raises(ObservationError, match=message):
        tracking_model(sensors=sensors).filter(log, {"a": torch.zeros(5, 2)}, truncate)


def test_actions_must_be_finite() -> None:
    with pytest.raises(ObservationError, match="finite"):
        tracker().filter({"z": torch.zeros(3, 2)}, {"a": torch.full((3, 2), torch.nan)})


def test_what_only_acts_keeps_no_graph() -> None:
    policy = Policy(tracker().learn("x.noise"))
    action, memory = policy.predict({"z": torch.zeros(2)})
    assert not action.requires_grad
    assert not any(value.requires_grad for value in memory.values())
