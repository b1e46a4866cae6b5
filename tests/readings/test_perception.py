"""Perception: what makes readings of raw observations before a step."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs import as_arrays, drifting, navigation, observation_with, tracking_model
from numpy.typing import NDArray
from torch import Tensor, nn

from aicon_torch import (
    DirectDescent,
    GraphError,
    ObservationError,
    Policy,
    Sensor,
    load_exported,
)
from aicon_torch.export.codegen import has_compiler
from aicon_torch.parts import clock


class Camera:
    """Reads bearing and range off an "image", and notes what else it is told."""

    def __init__(self) -> None:
        self.values: list[Mapping[str, Tensor] | None] = []
        self.starts: list[NDArray[np.bool_] | None] = []

    def __call__(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: NDArray[np.bool_] | None,
    ) -> Mapping[str, Any]:
        self.values.append(values)
        self.starts.append(starts)

        image = observation["image"]
        return {"bearing": image[..., :1], "range": image[..., 1:]}


def image_of(observation: Mapping[str, Any]) -> dict[str, Any]:
    return {"image": np.concatenate((observation["bearing"], observation["range"]), axis=-1)}


def seeing() -> tuple[Policy, Camera]:
    """The navigation's policy with a camera."""
    camera, policy = Camera(), navigation()
    return Policy(policy.model, policy.resolution, policy.law, perception=camera), camera


def test_readings_come_from_the_perception() -> None:
    policy, _ = seeing()
    memory = expected = None

    for reading in drifting(20, (3,)):
        arrays = as_arrays(reading)
        action, memory = policy.predict(image_of(arrays), memory)
        plain, expected = navigation().predict(arrays, expected)

        assert np.array_equal(action, plain)
        assert_same_memory(memory, expected, 0.0)


def test_it_is_told_the_values_of_the_last_step() -> None:
    policy, camera = seeing()
    _, memory = policy.predict(image_of(observation_with()))
    policy.predict(image_of(observation_with()), memory)

    first, second = camera.values
    assert first is None
    assert second is not None and second.keys() == policy.model.quantities.keys()
    for name, value in second.items():
        assert torch.equal(value, memory[name])


@pytest.mark.parametrize("kind", [np.array, list, torch.tensor])
def test_it_is_told_which_rows_start(kind: Any) -> None:
    policy, camera = seeing()
    image = image_of(as_arrays(drifting(1, (3,))[0]))
    _, memory = policy.predict(image)
    policy.predict(image, memory, episode_start=kind([True, False, True]))

    assert camera.starts[0] is None
    assert isinstance(camera.starts[1], np.ndarray)
    assert camera.starts[1].tolist() == [True, False, True]


def test_estimates_alone_are_perceived_too() -> None:
    policy, camera = seeing()
    memory = policy.estimate(image_of(observation_with()))

    assert len(camera.values) == 1
    assert_same_memory(memory, navigation().estimate(observation_with()), 0.0)


def test_a_perception_that_is_still_being_trained_is_refused() -> None:
    class Network(Camera, nn.Module):
        def __init__(self) -> None:
            nn.Module.__init__(self)
            Camera.__init__(self)
            self.layer = nn.Dropout()

    with pytest.raises(GraphError, match="'perception' has a layer Dropout in training mode"):
        Policy(tracking_model(), law=DirectDescent(gain=1.0), perception=Network())
    Policy(tracking_model(), law=DirectDescent(gain=1.0), perception=Network().eval())


def test_a_compiled_policy_keeps_its_perception() -> None:
    policy, camera = seeing()
    assert policy.compile().perception is camera


def test_what_it_returns_is_checked_like_an_observation() -> None:
    policy, _ = seeing()
    with pytest.raises(ObservationError, match=r"'z_obs'.*got \(2,\)"):
        policy.predict(image_of(observation_with(range=np.ones(2))))

    _, memory = policy.predict(image_of(observation_with(range=np.array([np.nan]))))
    assert not memory["z_obs.present"]


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_loaded_policy_asks_for_what_was_perceived_and_not_for_the_time(tmp_path: Path) -> None:
    """Without its perception it would be blind, and would not know."""
    sensors = {"z": Sensor(2, "m", optional=True), "z_elapsed": clock()}
    model = tracking_model(sensors=sensors, clock="z_elapsed")
    policy = Policy(model, law=DirectDescent(gain=1.0), perception=Camera())
    policy.export(tmp_path / "policy.so")
    loaded = load_exported(tmp_path / "policy.so")

    loaded.predict({"z": np.ones(2)})
    with pytest.raises(ObservationError, match="'z', and the perception"):
        loaded.predict({"elapsed": np.array([0.1])})
