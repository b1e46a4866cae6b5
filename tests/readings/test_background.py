"""Perception in the background: a step takes what is ready, and waits for nothing."""

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aicon_torch import (
    BackgroundPerception,
    Foresight,
    OptionError,
    Policy,
    load_exported,
    make_policy,
)

SECONDS = 20.0
"""Until a test that waits gives up."""


class Camera:
    """Reads bearing and range off an "image" as soon as it may, and tells how old they are."""

    def __init__(self) -> None:
        self.may_see = threading.Event()
        self.images: list[float] = []
        self.error: Exception | None = None

    def begin(self, observation: Mapping[str, Any], values: Any, starts: Any) -> Callable[[], Any]:
        image = observation["image"].copy()

        def see() -> Any:
            assert self.may_see.wait(SECONDS)
            self.images.append(float(image[1]))
            if self.error is not None:
                raise self.error
            return image

        return see

    def readings(self, seen: Any, observation: Mapping[str, Any], late: int = 0) -> dict[str, Any]:
        image = np.full(2, np.nan) if seen is None else seen
        return {"bearing": image[:1], "range": image[1:], "age": np.array(0.1 * late)}

    def __call__(self, observation: Mapping[str, Any], values: Any, starts: Any) -> dict[str, Any]:
        return self.readings(self.begin(observation, values, starts)(), observation)


def test_a_perception_in_one_part_is_refused() -> None:
    with pytest.raises(OptionError, match=r"begin=None: expected a function, begin\(\.\.\.\)"):
        BackgroundPerception(lambda *_: {})  # type: ignore[arg-type]  # wrong on purpose


def image_of(distance: float) -> dict[str, Any]:
    return {"image": np.array([0.3, distance])}


def seeing() -> tuple[BackgroundPerception, Camera]:
    camera = Camera()
    return BackgroundPerception(camera), camera


def finish(background: BackgroundPerception, camera: Camera) -> None:
    """Let the camera see, and wait until what it has seen can be taken."""
    camera.may_see.set()
    assert background._running is not None
    background._running[0].exception(SECONDS)


def distance(readings: Mapping[str, Any]) -> float:
    return float(readings["range"][0])


def test_a_step_does_not_wait_and_a_later_one_takes_what_was_seen() -> None:
    background, camera = seeing()
    values: dict[str, Any] = {}
    assert np.isnan(distance(background(image_of(1.0), None, None)))
    assert np.isnan(distance(background(image_of(2.0), values, None)))

    finish(background, camera)
    readings = background(image_of(3.0), values, None)
    assert distance(readings) == 1.0


def test_it_tells_how_many_steps_ago_the_observation_came() -> None:
    background, camera = seeing()
    background(image_of(1.0), None, None)
    background(image_of(2.0), {}, None)
    background(image_of(3.0), {}, None)
    finish(background, camera)
    assert background(image_of(4.0), {}, None)["age"] == pytest.approx(0.3)


def test_of_what_came_meanwhile_the_newest_is_seen_next() -> None:
    background, camera = seeing()
    for step in range(4):
        background(image_of(float(step)), None if step == 0 else {}, None)
    finish(background, camera)

    assert distance(background(image_of(4.0), {}, None)) == 0.0
    finish(background, camera)
    assert distance(background(image_of(5.0), {}, None)) == 4.0
    assert 1.0 not in camera.images and 2.0 not in camera.images and 3.0 not in camera.images


@pytest.mark.parametrize("starts", [None, np.array([False, True])])
def test_what_was_seen_in_an_episode_that_has_ended_is_dropped(starts: Any) -> None:
    background, camera = seeing()
    background(image_of(1.0), None, None)
    finish(background, camera)

    values: dict[str, Any] | None = None if starts is None else {}
    assert np.isnan(distance(background(image_of(2.0), values, starts)))
    finish(background, camera)
    assert distance(background(image_of(3.0), {}, None)) == 2.0


def test_an_error_is_raised_by_the_step_that_would_have_taken_the_reading() -> None:
    background, camera = seeing()
    camera.error = ValueError("the lens is dirty")
    background(image_of(1.0), None, None)
    finish(background, camera)
    with pytest.raises(ValueError, match="the lens is dirty"):
        background(image_of(2.0), {}, None)


@pytest.mark.parametrize(
    "kind", ["eager", pytest.param("compiled", marks=pytest.mark.slow), "exported"]
)
def test_every_policy_takes_it_and_its_estimators_take_the_age(kind: str, tmp_path: Path) -> None:
    """What comes late through the background is as good as a late reading that tells its age."""
    policy = make_policy("nav2d", delay=2, law=Foresight(iterations=1))
    background, camera = seeing()
    seen: Any = Policy(policy.model, policy.resolution, policy.law, background)
    if kind == "compiled":
        seen = seen.compile()
    if kind == "exported":
        seen.export(tmp_path / "policy.so")
        seen = load_exported(tmp_path / "policy.so", perception=background)

    found: Any = None
    expected: Any = None
    for step in range(6):
        _, found = seen.predict(image_of(2.0 - 0.1 * step), found)
        finish(background, camera)

        image = np.array([0.3, 2.1 - 0.1 * step]) if step else np.full(2, np.nan)
        late = {"bearing": image[:1], "range": image[1:], "age": np.array(0.1 if step else 0.0)}
        _, expected = policy.predict(late, expected)

    for name in expected:
        np.testing.assert_allclose(found[name], expected[name], atol=1e-9, equal_nan=True)
