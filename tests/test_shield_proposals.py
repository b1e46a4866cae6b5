"""What a shield takes for a proposal, and what it refuses."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from _inputs.pillars import DT, located, straight, world
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Goal,
    GraphError,
    Interconnection,
    ObservationError,
    OptionError,
    Sensor,
    Shield,
    WorldModel,
    load_exported,
)


def test_what_a_proposal_means_can_be_learned() -> None:
    class Scaled(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.scale = torch.tensor(0.5, dtype=torch.float64)

        def forward(self, proposal: Tensor) -> Tensor:
            return self.scale * proposal

    shield = Shield(straight, world(), nominal=Scaled(), size=2)
    learner = shield.policy.learn("x_proposal.relation.scale")
    reading = {"position": torch.zeros(2), "proposal": torch.tensor([0.3, 0.1])}
    action, _ = learner.predict(reading, create_graph=True)
    (slope,) = torch.autograd.grad(action.sum(), list(learner.parameters()))
    assert float(action.detach().sum()) == pytest.approx(0.5 * 0.4)
    assert float(slope) > 0.0


def masked_tensor() -> Any:
    """Two numbers of which the second is none."""
    numbers, mask = torch.tensor([0.3, 0.2]), torch.tensor([True, False])
    return torch.masked.masked_tensor(numbers, mask)


@pytest.mark.filterwarnings("ignore:The PyTorch API of MaskedTensors:UserWarning")
@pytest.mark.parametrize(
    "broken",
    [
        lambda: np.array([np.nan, 0.3]),
        lambda: np.array([0.3, np.inf]),
        lambda: torch.tensor([-torch.inf, 0.3]),
        lambda: np.ma.array([0.3, 0.4], mask=[False, True]),
        masked_tensor,
    ],
    ids=["nan", "inf", "tensor", "masked", "masked tensor"],
)
@pytest.mark.parametrize("is_first", [True, False])
def test_what_is_not_finite_in_part_asks_for_rest(
    broken: Callable[[], Any], is_first: bool
) -> None:
    told: Any = np.array([0.3, 0.4])
    shield, state, seen = Shield(lambda _: told, world()), None, {"position": np.array([0.0, 2.0])}
    if not is_first:
        _, state = shield.predict(seen)

    told = broken()
    action, state = shield.predict(seen, state)
    np.testing.assert_array_equal(np.asarray(action), (0.0, 0.0))

    told = np.array([0.3, 0.4])
    action, _ = shield.predict(seen, state)
    np.testing.assert_allclose(action, told, atol=1e-6)


@pytest.mark.parametrize(
    "is_place",
    [pytest.param(False, id="action", marks=pytest.mark.slow), pytest.param(True, id="place")],
)
def test_a_shield_and_what_it_exports_rest_while_nothing_is_proposed_whatever_it_means(
    is_place: bool, tmp_path: Any
) -> None:
    def towards(proposal: Tensor, position: Tensor, dt: Tensor) -> Tensor:
        return (proposal - position) / dt

    told: Any = None
    shield = Shield(lambda _: told, world(), nominal=towards if is_place else None)
    shield.export(tmp_path / "shield.so")
    exported, memory, state = load_exported(tmp_path / "shield.so"), None, None
    seen = {"position": np.array([[0.0, 2.0], [0.0, 2.0]])}
    way = np.array([0.02, 0.01])
    for step in range(30):
        told = np.tile(seen["position"][0] + way if is_place else way, (2, 1))
        if step % 10 > 4:
            told[0, step % 2] = np.nan
        action, state = shield.predict(seen, state)
        also, memory = exported.predict({**seen, "proposal": told}, memory)

        expected = np.tile(way / DT if is_place else way, (2, 1))
        expected[0] *= step % 10 <= 4
        np.testing.assert_allclose(action, expected, atol=1e-6)
        np.testing.assert_allclose(also, action, atol=1e-6)


def test_a_bound_moves_a_robot_to_which_nothing_is_proposed() -> None:
    def inside(x: Tensor) -> Tensor:
        return 1.0 - x.norm(dim=-1)

    model = world()
    own = WorldModel(
        sensors=model.sensors,
        actuators=model.actuators,
        estimators=model.declaration.estimators,
        goals=[Goal("ring", inside, safety=True)],
        dt=DT,
        dtype=torch.float64,
    )
    told: Any = np.zeros(2)
    shield = Shield(lambda _: told, own)
    _, state = shield.predict({"position": np.array([0.5, 0.0])})
    told = np.full(2, np.nan)
    action, _ = shield.predict({"position": np.array([0.5, 0.0])}, state)
    assert action[0] > 0.1 and abs(action[1]) < 1e-6


def test_a_policy_that_changes_what_it_observes_blinds_no_shield() -> None:
    def normalises(observation: Any) -> Any:
        action = straight(observation)
        observation["position"] -= 5.0
        observation["image"] -= 1.0
        return action

    shield, blind = Shield(straight, world()), Shield(normalises, world())
    states: list[Any] = [None, None]
    image = np.ones(3)
    for step in range(40):
        seen = {"position": np.array([0.05 * step, 0.02]), "image": image}
        expected, states[0] = shield.predict(seen, states[0])
        action, states[1] = blind.predict(seen, states[1])
        np.testing.assert_array_equal(action, expected)
    assert image[0] == 1.0 - 40  # what no sensor reads is not copied


def test_a_sensor_under_the_name_of_the_proposal_is_refused() -> None:
    model = world()
    sensors = {**model.sensors, "z_other": Sensor(5, "m", key="proposal")}
    parts = {"actuators": model.actuators, "goals": list(model.goals.values()), "dt": model.dt}
    taken = WorldModel(sensors=sensors, estimators=model.declaration.estimators, **parts)
    with pytest.raises(GraphError, match="'z_other' has the name or the key 'proposal'"):
        Shield(straight, taken)


@pytest.mark.parametrize("proposed", [None, "left", {"a": 1.0}, ([0.1, 0.2], None)])
def test_a_proposal_that_is_no_action_is_named(proposed: Any) -> None:
    shield = Shield(lambda observation: proposed, world())
    with pytest.raises(ObservationError, match="what the policy within proposes: "):
        shield.predict({"position": np.zeros(2)})


def test_an_observation_without_keys_is_refused() -> None:
    with pytest.raises(ObservationError, match=r"by key.*'position'.*got ndarray"):
        Shield(straight, world()).predict(np.zeros(2))  # type: ignore[arg-type]  # wrong on purpose


def test_what_cannot_be_shielded_is_refused_by_name() -> None:
    for no_policy in (3, Shield):  # a class is none before it is made
        with pytest.raises(OptionError, match="something with predict, or a function"):
            Shield(no_policy, world())
    with pytest.raises(OptionError, match="goes_around='no': expected True or False"):
        Shield(straight, world(), goes_around="no")  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(OptionError, match="a WorldModel, such as policy.model, got Shield"):
        Shield(straight, Shield(straight, world()))  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(GraphError, match=r"an action of shape \(1,\); expected \(2,\)"):
        Shield(straight, world(), size=1)
    with pytest.raises(OptionError, match="nominal=3: expected a function of 'proposal'"):
        Shield(straight, world(), nominal=3)  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(GraphError, match="nominal: it reads 'x'; expected 'proposal' among them"):
        Shield(straight, world(), nominal=lambda x: x)

    def far(x: Tensor) -> Tensor:
        return x.square().sum(dim=-1)

    parts: dict[str, Any] = {"sensors": {"position": Sensor(2, "m")}, "estimators": [located()]}
    one = {"v": Actuator(2, "m/s", limit=1.0)}
    with pytest.raises(GraphError, match="'far'.* is a safety goal"):
        Shield(straight, WorldModel(**parts, actuators=one, goals=[Goal("far", far)]))

    two = {**one, "w": Actuator(2, "m/s", limit=1.0)}
    norm = Interconnection(far, inputs=["w"])
    goals = [Goal("far", far, safety=True), Goal("w rests", norm, safety=True)]
    with pytest.raises(GraphError, match="'v'.*'w'.* drives exactly one"):
        Shield(straight, WorldModel(**parts, actuators=two, goals=goals))


@pytest.mark.parametrize(
    "proposal", [torch.ones(2).to_sparse(), torch.ones(2, device="meta")], ids=["sparse", "meta"]
)
def test_a_tensor_that_is_not_dense_is_no_proposal(proposal: Tensor) -> None:
    with pytest.raises(ObservationError, match="policy within proposes: expected real numbers"):
        Shield(lambda _: proposal, world()).predict({"position": np.zeros(2)})
