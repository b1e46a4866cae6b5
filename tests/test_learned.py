"""What learns is chosen by name, stays what it must be, and has an effect."""

import copy
import math
import pickle
from pathlib import Path
from typing import Any

import pytest
import torch
from _inputs import MOVE, tracked_point, tracking_model
from _inputs.logs import LOGS, random_actions, stacked
from torch import Tensor, nn

from aicon_torch import Measurement, Policy, load_exported
from aicon_torch.errors import GraphError, OptionError
from aicon_torch.export.codegen import has_compiler

RADIUS = "x_pose.predict.radius"
GYRATION = "x_pose.predict.dynamics.body.radius_of_gyration"


def pusher() -> Policy:
    return LOGS["pusht"].make()


def test_exactly_what_is_named_learns() -> None:
    policy = pusher()
    learner = policy.learn(RADIUS, "x_pose.noise")
    names = {name for name, _ in learner.named_parameters()}
    wanted = {"x_pose/predict/radius", "x_pose/noise"}
    assert names == {f"model.learned.{name}.theta" for name in wanted}
    assert list(policy.parameters()) == []
    assert policy.model.numbers.keys() == learner.model.numbers.keys()


def test_numbers_start_as_they_are_or_as_told() -> None:
    policy = pusher()
    told = {GYRATION: 0.04, "x_pusher.noise": 1e-4}
    before, now = policy.model.numbers, policy.learn(RADIUS, start=told).model.numbers
    for name, value in now.items():
        is_told = name.endswith("radius_of_gyration") or name == "x_pusher.noise"
        assert torch.equal(value.double(), before[name].double()) != is_told, name
    assert now[GYRATION] == now["x_keypoints.relation.radius_of_gyration"] == 0.04
    torch.testing.assert_close(now["x_pusher.noise"], 1e-4 * torch.eye(2, dtype=torch.float64))


def test_what_is_positive_stays_positive() -> None:
    learner = pusher().learn(RADIUS, "x_pose.noise", "x_target.relation.pose")
    with torch.no_grad():
        for parameter in learner.parameters():
            parameter -= 100.0
    numbers = learner.model.numbers
    assert numbers[RADIUS] > 0 and (numbers["x_pose.noise"].diagonal() > 0).all()
    assert (numbers["x_target.relation.pose"] < 0).all()  # a place is free


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("x_pose.nose", "No number is named 'x_pose.nose'. Numbers: .*'x_pose.noise'"),
        ("push.tolerance", "'push.tolerance.*cannot learn: nothing"),
    ],
)
def test_a_name_without_a_number_or_an_effect_is_an_error(name: str, message: str) -> None:
    with pytest.raises(GraphError, match=message):
        pusher().learn(name)


@pytest.mark.parametrize("start", ["a", math.nan, math.inf, [1.0, 2.0, 3.0], -1.0])
def test_a_start_that_is_none_is_named(start: Any) -> None:
    with pytest.raises(GraphError, match="'p.noise'"):
        tracking_model().learn(start={"p.noise": start})
    with pytest.raises(GraphError, match="start=3: expected numbers by name"):
        tracking_model().learn(start=3)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(GraphError, match="learn: expected the name of a number: .*'p.noise'"):
        tracking_model().learn()


def test_a_state_is_loaded_strictly() -> None:
    learner, other = pusher().learn(RADIUS), pusher().learn(RADIUS)
    with torch.no_grad():
        next(learner.parameters()).fill_(0.3)
    other.load_state_dict(learner.state_dict())
    assert other.model.numbers[RADIUS] == learner.model.numbers[RADIUS] > 0.015
    with pytest.raises(RuntimeError, match="Unexpected key"):
        pusher().load_state_dict(learner.state_dict())
    assert copy.deepcopy(learner).model.numbers[RADIUS] == learner.model.numbers[RADIUS]


def test_what_learns_is_pickled() -> None:
    learner = pusher().learn(RADIUS, "x_pose.noise", "x_pusher.measurements.0.noise")
    with torch.no_grad():
        for number, parameter in enumerate(learner.parameters(), start=1):
            parameter.fill_(0.1 * number)

    for copied in (pickle.loads(pickle.dumps(learner)), copy.deepcopy(learner)):
        expected, found = learner.model.numbers, copied.model.numbers
        assert all(torch.equal(found[name], value) for name, value in expected.items())
        assert copied.state_dict().keys() == learner.state_dict().keys()

        # It learns on its own.
        with torch.no_grad():
            copied.model.learned["x_pose/predict/radius"].theta.fill_(1.0)
        assert copied.model.numbers[RADIUS] != learner.model.numbers[RADIUS]


def test_what_learned_before_and_is_not_named_again_stays() -> None:
    first = tracking_model().learn("p.noise", start={"p.noise": 0.02})
    second = first.learn("p.measurements.0.noise")
    assert [name for name, _ in second.named_parameters()] == [
        "learned.p/measurements/0/noise.theta"
    ]
    torch.testing.assert_close(second.numbers["p.noise"], first.numbers["p.noise"])
    assert len(list(first.parameters())) == 1

    both = second.learn("p.noise", "p.measurements.0.noise")
    assert len(list(both.parameters())) == 2


def test_a_learner_is_made_where_nothing_is_recorded() -> None:
    with torch.no_grad():
        learner = tracking_model().learn("p.noise")
    assert len(list(learner.parameters())) == 1


class Seen(nn.Module):
    """A network that says where a point is."""

    def __init__(self) -> None:
        super().__init__()
        self.layer = nn.Linear(2, 2)

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        return p - self.layer(z)


def test_a_network_learns_under_the_name_of_what_it_is_in() -> None:
    point = tracked_point(correct=[Measurement(Seen(), 0.1, size=2)])
    model = tracking_model(MOVE, point)
    weights, noise = model.learn("p.measurements.0"), model.learn("p.noise")
    assert sum(parameter.numel() for parameter in weights.parameters()) == 6
    assert [name for name, _ in noise.named_parameters()] == ["learned.p/noise.theta"]


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_copy_of_a_compiled_policy_goes_on_with_parameters_of_its_own() -> None:
    log = LOGS["nav2d"]
    learner, observation = log.make().learn("p_tar.noise"), log.observations()[0]
    compiled = learner.compile()
    action, _ = compiled.predict(observation)

    copied = copy.deepcopy(compiled)
    assert torch.equal(copied.predict(observation)[0], action)
    with torch.no_grad():
        next(iter(compiled.parameters())).add_(1.0)
    assert torch.equal(copied.predict(observation)[0], action)
    with pytest.raises(OptionError, match="call compile"):
        compiled.predict(observation)


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_compiled_or_exported_policy_says_that_parameters_have_changed(tmp_path: Path) -> None:
    log = LOGS["nav2d"]
    learner, observations = log.make().learn("p_tar.noise"), log.observations()
    compiled = learner.compile()
    action, _ = compiled.predict(observations[0])
    torch.testing.assert_close(action, learner.predict(observations[0])[0])
    learner.export(tmp_path / "policy.so")
    exported = load_exported(tmp_path / "policy.so")
    assert learner.is_exported(exported)

    filtered = learner.filter(stacked(observations), random_actions(learner))
    filtered.log_likelihood().sum().backward()
    torch.optim.SGD(learner.parameters(), lr=1.0).step()
    with pytest.raises(OptionError, match="call compile"):
        compiled.predict(observations[0])
    assert not learner.is_exported(exported)
    learner.compile().predict(observations[0])
