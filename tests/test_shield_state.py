"""The state of a shield: saved and read, refused by name, and explained."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from _inputs.pillars import DT, located, straight, world

from aicon_torch import Actuator, Goal, ObservationError, Sensor, Shield, WorldModel

SEEN = {"position": np.array([0.95, 0.0])}


class Counting:
    """A policy with a state of its own: the steps that it was asked."""

    def predict(self, observation: Any, state: Any, *_: Any) -> Any:
        return straight(observation), torch.zeros(()) if state is None else state + 1


@pytest.mark.parametrize("is_compiled", [False, True], ids=["readable", "compiled"])
def test_a_state_that_was_saved_goes_on(is_compiled: bool, tmp_path: Any) -> None:
    shield = Shield(Counting(), world())
    if is_compiled:
        shield = shield.compile()
    state = None
    for _ in range(5):
        _, state = shield.predict(SEEN, state)

    torch.save(state, tmp_path / "state.pt")
    loaded = torch.load(tmp_path / "state.pt", weights_only=True)
    expected, goes_on = shield.predict(SEEN, state)
    action, after = shield.predict(SEEN, loaded)
    np.testing.assert_array_equal(action, expected)
    assert after.inner == goes_on.inner == 5


@pytest.mark.parametrize("use", ["predict", "trace", "explain"])
def test_what_is_no_state_of_a_shield_is_named(use: str) -> None:
    shield = Shield(straight, world())
    _, state = shield.predict(SEEN)
    for wrong, name in ((state.memory, "dict"), (3, "int"), ((state.memory, None), "tuple")):
        arguments = (SEEN, wrong) if use == "predict" else (wrong,)
        with pytest.raises(ObservationError, match=f"the ShieldState that .*, got {name}"):
            getattr(shield, use)(*arguments)


def test_a_goal_that_is_switched_off_has_held_nothing() -> None:
    shield = Shield(straight, world())
    _, state = shield.predict(SEEN)
    assert list(shield.explain(state).held) == ["pillar"]

    memory = shield.policy.switch(state.memory, pillar=False)
    action, state = shield.predict(SEEN, state._replace(memory=memory))
    np.testing.assert_allclose(action, (1.0, 0.0), atol=1e-6)
    assert shield.explain(state).held == {}


def watched() -> WorldModel:
    """The point, of which a reading that is older than 0.1 s is too old."""
    model = world()
    return WorldModel(
        sensors={"position": replace(model.sensors["position"], max_age=0.1)},
        actuators=model.actuators,
        estimators=model.declaration.estimators,
        goals=list(model.goals.values()),
        dt=DT,
        dtype=torch.float64,
    )


def test_it_says_which_reading_is_missing_where_it_rests() -> None:
    shield, state = Shield(straight, watched()), None
    for position in (0.0, *[np.nan] * 5):
        seen = {"position": np.array([position, 2.0])}
        action, state = shield.predict(seen, state)
    told = shield.explain(state)
    assert not action.any() and "no reading of 'position': the last is 0.25 s old" in told.alerts
    assert "  older than 0.10 s: 0% of the action is executed" in str(told)
    assert any(alert.startswith("no reading of 'proposal'") for alert in told.alerts)


def test_it_names_a_goal_whose_gap_is_no_number_and_none_that_nothing_moves() -> None:
    def broken(x: Any) -> Any:
        return torch.where(x[..., 0] > 0.5, torch.nan, -x[..., 1])

    def elsewhere(x: Any, lamp: Any) -> Any:
        return lamp[..., 0] + 0.0 * x[..., 0]

    model = WorldModel(
        sensors={"position": Sensor(2, "m"), "lamp": Sensor(1, "1")},
        actuators={"v": Actuator(2, "m/s", limit=1.0)},
        estimators=[located()],
        goals=[Goal("broken", broken, safety=True), Goal("elsewhere", elsewhere, safety=True)],
        dt=DT,
        dtype=torch.float64,
    )
    shield = Shield(lambda _: np.array([1.0, 0.0]), model)
    for place, held in ((0.0, []), (0.9, ["broken"])):
        seen = {"position": np.array([place, 1.0]), "lamp": np.array([3.0])}
        action, state = shield.predict(seen)
        told = shield.explain(state)
        assert list(told.held) == held and ("so nothing moves" in str(told)) == bool(held)
        assert bool(action.any()) == (not held)
