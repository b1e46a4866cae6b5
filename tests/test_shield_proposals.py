"""What a shield takes for a proposal, and what it refuses."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs.pillars import located, straight, world
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


def test_what_is_masked_in_a_proposal_asks_for_nothing() -> None:
    proposed = np.ma.array([0.3, 0.4], mask=[False, True])
    action, _ = Shield(lambda observation: proposed, world()).predict({"position": np.zeros(2)})
    np.testing.assert_allclose(action, [0.3, 0.0], atol=1e-6)


def test_an_observation_without_keys_is_refused() -> None:
    with pytest.raises(ObservationError, match=r"by key.*'position'.*got ndarray"):
        Shield(straight, world()).predict(np.zeros(2))  # type: ignore[arg-type]  # wrong on purpose


def test_what_cannot_be_shielded_is_refused_by_name() -> None:
    with pytest.raises(OptionError, match="something with predict, or a function"):
        Shield(3, world())
    with pytest.raises(OptionError, match="a WorldModel, such as policy.model, got Shield"):
        Shield(straight, Shield(straight, world()))  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(GraphError, match=r"an action of shape \(1,\); expected \(2,\)"):
        Shield(straight, world(), size=1)

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


@pytest.mark.filterwarnings("ignore:The PyTorch API of MaskedTensors:UserWarning")
def test_a_masked_tensor_asks_for_nothing_where_its_mask_is() -> None:
    numbers, mask = torch.tensor([0.3, 0.2]), torch.tensor([True, False])
    masked = torch.masked.masked_tensor(numbers, mask)
    action, _ = Shield(lambda _: masked, world()).predict({"position": np.zeros(2)})
    np.testing.assert_allclose(action, [0.3, 0.0], atol=1e-6)


@pytest.mark.parametrize(
    "proposal", [torch.ones(2).to_sparse(), torch.ones(2, device="meta")], ids=["sparse", "meta"]
)
def test_a_tensor_that_is_not_dense_is_no_proposal(proposal: Tensor) -> None:
    with pytest.raises(ObservationError, match="policy within proposes: expected real numbers"):
        Shield(lambda _: proposal, world()).predict({"position": np.zeros(2)})
