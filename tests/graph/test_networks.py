"""Networks in a graph: which layers fit, and what is said of one that does not."""

from collections.abc import Callable, Sequence

import pytest
import torch
from _asserts import assert_rows_stand_alone
from _inputs import MOVE, TRACK, normal, tracked_point, tracking_model
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    GraphError,
    Interconnection,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

BEAMS = 12


class Seen(nn.Module):
    """Where a network sees the point in a scan, against where it is believed."""

    def __init__(self, *layers: nn.Module) -> None:
        super().__init__()
        self.layers = nn.Sequential(*layers)

    def forward(self, p: Tensor, z: Tensor) -> Tensor:
        return p - self.layers(z)


CONVOLUTIONS = (
    nn.Unflatten(-1, (1, BEAMS)),
    *(nn.Conv1d(1, 4, 3, padding=1), nn.BatchNorm1d(4), nn.ReLU(), nn.MaxPool1d(2)),
    *(nn.Flatten(), nn.Linear(2 * BEAMS, 2)),
)
NETWORKS: dict[str, Sequence[nn.Module]] = {
    "BatchNorm": (nn.Linear(BEAMS, 8), nn.BatchNorm1d(8), nn.Tanh(), nn.Linear(8, 2)),
    "a convolution": CONVOLUTIONS,
    "a convolution of an image": (
        nn.Unflatten(-1, (1, 3, 4)),
        *(nn.Conv2d(1, 2, 3, padding=1), nn.BatchNorm2d(2), nn.ELU(), nn.AdaptiveAvgPool2d(1)),
        *(nn.Flatten(), nn.Linear(2, 2)),
    ),
    "GroupNorm": (nn.Linear(BEAMS, 8), nn.GroupNorm(2, 8), nn.Linear(8, 2)),
    "Dropout": (nn.Linear(BEAMS, 8), nn.Dropout(0.5), nn.Linear(8, 2)),
}


def scanning(layers: Sequence[nn.Module]) -> WorldModel:
    """A point that a network sees in a scan."""
    measurement = Measurement(Seen(*layers).eval(), noise=0.1, size=2)
    return tracking_model(
        MOVE,
        tracked_point(correct=[measurement]),
        sensors={"z": Sensor(BEAMS, "m")},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
    )


@pytest.mark.parametrize("name", NETWORKS)
def test_layers_that_take_one_batch_dimension_fit(name: str) -> None:
    """A robot alone, a batch of them, and a grid."""
    policy = Policy(scanning(NETWORKS[name]), Sum(), DirectDescent(gain=1.0))
    readings = [{"z": normal(3, 2, BEAMS, seed=seed)} for seed in range(3)]
    policy.predict({"z": readings[0]["z"][0, 0]})
    assert_rows_stand_alone(policy, readings, rows=[0, 1])


def test_a_network_tells_where_an_estimate_begins() -> None:
    """It takes one batch dimension, and tells a mean and a covariance."""

    class First(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.layers = nn.Sequential(*CONVOLUTIONS)

        def forward(self, z: Tensor) -> tuple[Tensor, Tensor]:
            mean = self.layers(z)
            return mean, torch.diag_embed(mean.exp())

    measurement = Measurement(Seen(*CONVOLUTIONS).eval(), noise=0.1, size=2)
    point = tracked_point(initial=First().eval(), size=2, correct=[measurement])
    sensors = {"z": Sensor(BEAMS, "m")}
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    model = tracking_model(MOVE, point, sensors=sensors, actuators=actuators)
    policy = Policy(model, Sum(), DirectDescent(gain=1.0))
    readings = [{"z": normal(3, 2, BEAMS, seed=seed)} for seed in range(3)]
    assert_rows_stand_alone(policy, readings, rows=[0, 1])


def test_a_network_that_reads_a_matrix_beside_a_vector_fits() -> None:
    """A covariance keeps its two dimensions."""

    class Unsure(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.norm = nn.BatchNorm1d(3)

        def forward(self, p: Tensor, P: Tensor) -> Tensor:
            return self.norm(torch.cat((p, P.flatten(1).sum(-1, keepdim=True)), -1)).sum(-1)

    paths = tracking_model(goals=[Goal("unsure", Unsure().eval())]).paths()
    assert str(paths) == "unsure → p → x → a"


def test_a_layer_of_torch_is_wired_by_names() -> None:
    relation = Interconnection(nn.Bilinear(2, 2, 2), inputs=["p", "z"])
    model = tracking_model(MOVE, tracked_point(correct=[Measurement(relation, 0.1, size=2)]))
    assert "p" in model.estimators[-1].inputs


@pytest.mark.parametrize("layer", [nn.BatchNorm1d(8), nn.Dropout(0.5)])
def test_a_network_that_is_still_in_training_is_refused(layer: nn.Module) -> None:
    """It would mix the rows of a batch, or act at random."""
    network = Seen(nn.Linear(2, 8), layer, nn.Linear(8, 2))
    point = tracked_point(correct=[Measurement(network, 0.1, size=2)])
    with pytest.raises(GraphError, match=r"'p'.*(Batch|Dropout).*training.*\.eval\(\)"):
        tracking_model(MOVE, point)


@pytest.mark.parametrize("layer", [nn.BatchNorm1d(8), nn.Dropout(0.5)])
def test_training_mode_is_refused_where_it_makes_a_difference(layer: nn.Module) -> None:
    network = Seen(nn.Linear(2, 8), layer, nn.Linear(8, 2)).eval()
    point = tracked_point(correct=[Measurement(network, 0.1, size=2)])
    model = tracking_model(MOVE, point)
    for trained in (model, Policy(model, law=DirectDescent(1.0))):
        with pytest.raises(GraphError, match=r"'p'.*(Batch|Dropout).*training.*\.eval\(\)"):
            trained.train()
        assert not layer.training
        assert trained.eval() is trained

    plain = Policy(tracking_model(), law=DirectDescent(1.0))
    assert plain.train() is plain and plain.training


# --- precision


def single(p: Tensor, z: Tensor) -> Tensor:
    return p - SINGLE(z)


def narrowed_move(a: Tensor, dt: float) -> Tensor:
    return MOVER((a * dt).float())


SINGLE, MOVER = nn.Linear(2, 2), nn.Linear(2, 2)
MIXED: dict[str, Callable[[], WorldModel]] = {
    "a network that a function uses": lambda: tracking_model(
        MOVE, tracked_point(correct=[Measurement(single, 0.1, size=2)])
    ),
    "a quantity in single precision": lambda: tracking_model(
        Deterministic("x", narrowed_move), TRACK
    ),
}


@pytest.mark.parametrize("name", MIXED)
def test_a_network_of_another_precision_is_an_error_that_says_what_to_do(name: str) -> None:
    with pytest.raises(GraphError, match=r"float64.*\.double\(\).*dtype=torch\.float32"):
        MIXED[name]()


def test_a_network_that_is_a_module_of_the_graph_takes_its_precision() -> None:
    layers = nn.Sequential(nn.Linear(2, 4), nn.GELU(), nn.Linear(4, 2))
    point = tracked_point(correct=[Measurement(Seen(*layers), 0.1, size=2)])
    model = tracking_model(MOVE, point)
    assert {parameter.dtype for parameter in model.parameters()} == {torch.float64}
