"""A shield does what is proposed, keeps its safety goals, and goes around what is in the way."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from _inputs.pillars import DT, PILLARS, RADIUS, TARGET, TRAP, straight, world
from _inputs.walls import point_policy, wall
from torch import Tensor

from aicon_torch import (
    Shield,
    load_exported,
)


def drive(shield: Shield, start: Any, steps: int = 400) -> tuple[Any, Any]:
    """The way ``(steps + 1, *B, 2)``, and the last state."""
    way, state = [np.asarray(start, float)], None
    for _ in range(steps):
        action, state = shield.predict({"position": way[-1]}, state)
        way.append(way[-1] + DT * action)
    return np.stack(way), state


def gaps(way: Any, pillars: Mapping[str, tuple[float, float]]) -> Any:
    return np.min([np.linalg.norm(way - c, axis=-1) - RADIUS for c in pillars.values()], axis=0)


def test_what_is_allowed_is_done_as_it_was_proposed() -> None:
    shield = Shield(straight, world())
    observation = {"position": np.array([0.0, 2.0])}
    action, _ = shield.predict(observation)
    np.testing.assert_allclose(action, straight(observation), rtol=1e-6)


@pytest.mark.parametrize("proposed", [(0.0, 0.0), (0.5, -0.2)])
def test_what_else_a_model_wants_is_not_followed(proposed: tuple[float, float]) -> None:
    shield = Shield(lambda _: np.array(proposed), point_policy([wall()]).model)
    seen = {"z": np.array([-0.5, 0.0]), "z_target": np.array([-3.0, 0.0])}
    action, _ = shield.predict(seen)
    np.testing.assert_allclose(action, proposed, rtol=1e-6)


@pytest.mark.parametrize("pillars", [PILLARS, TRAP], ids=["pillar", "trap"])
def test_it_keeps_its_bounds_and_goes_around_what_is_in_the_way(
    pillars: Mapping[str, tuple[float, float]],
) -> None:
    starts = np.array([[0.0, 0.0], [0.0, 0.05], [0.2, -0.3]])
    way, _ = drive(Shield(straight, world(pillars)).compile(), starts)
    assert gaps(way, pillars).min() > 0.0
    np.testing.assert_allclose(way[-1], np.tile(TARGET, (3, 1)), atol=0.05)


def test_without_the_way_around_it_stays_where_it_is_held_up() -> None:
    way, _ = drive(Shield(straight, world(), goes_around=False), (0.0, 0.0), 120)
    np.testing.assert_allclose(way[-1], (1.5 - RADIUS, 0.0), atol=0.05)


@pytest.mark.slow
def test_a_random_policy_never_violates_its_bounds() -> None:
    generator = np.random.default_rng(0)
    shield = Shield(lambda seen: 3 * generator.normal(size=(64, 2)), world(TRAP)).compile()
    way, _ = drive(shield, generator.uniform(-0.5, 0.3, (64, 2)), 500)
    assert gaps(way, TRAP).min() > 0.0


def test_a_batch_is_its_rows_compiled_or_not_and_so_is_what_it_exports(tmp_path: Any) -> None:
    starts = np.array([[0.0, 0.0], [0.9, 0.1], [0.0, 2.0]])
    shield = Shield(straight, world())
    together, _ = drive(shield, starts, 60)
    fast = shield.compile()
    compiled, _ = drive(fast, starts, 60)
    np.testing.assert_allclose(compiled, together, atol=1e-6)
    for row, start in enumerate(starts):
        form = shield if row == 1 else fast
        np.testing.assert_allclose(drive(form, start, 60)[0], together[:, row], atol=1e-6)

    shield.export(tmp_path / "shield.so")
    exported, position, memory = load_exported(tmp_path / "shield.so"), starts[0], None
    for step in range(60):
        seen = {"position": position, "proposal": straight({"position": position})}
        action, memory = exported.predict(seen, memory)
        position = position + DT * action
        np.testing.assert_allclose(position, together[step + 1, 0], atol=1e-5)


class Counting:
    """A policy with a state of its own: it counts the steps of each episode."""

    def predict(self, observation: Any, state: Any, starts: Any, deterministic: bool) -> Any:
        count = len(observation["position"])
        steps = np.zeros(count) if state is None else np.where(starts, 0, state) + 1
        return np.stack([steps, np.zeros(count)], axis=-1) / 100, steps


def test_the_policy_within_keeps_its_state_and_begins_anew_where_an_episode_does() -> None:
    shield, state = Shield(Counting(), world()), None
    seen = {"position": np.array([[0.0, 2.0], [0.0, 2.0]])}
    for _ in range(3):
        action, state = shield.predict(seen, state, np.array([False, False]))
    action, state = shield.predict(seen, state, np.array([True, False]))
    np.testing.assert_allclose(action[:, 0], (0.01, 0.03), atol=1e-6)


def test_places_to_go_to_are_read_by_a_wish_and_sent_by_a_command() -> None:
    def towards(proposal: Tensor, position: Tensor, dt: Tensor) -> Tensor:
        return (proposal - position) / dt

    def place(v: Tensor, position: Tensor, dt: Tensor) -> Tensor:
        return position + v * dt

    shield = Shield(lambda seen: np.array([0.02, 2.01]), world(command=place), nominal=towards)
    action, _ = shield.predict({"position": np.array([0.0, 2.0])})
    np.testing.assert_allclose(action, (0.02, 2.01), atol=1e-6)


def test_it_explains_what_it_changed_and_why() -> None:
    shield = Shield(straight, world())
    _, state = drive(shield, (0.0, 0.0), 40)
    told = shield.explain(state)
    assert list(told.held) == ["pillar"] and told.held["pillar"].asked < told.held["pillar"].allowed
    assert "pillar: a gap of" in str(told)

    _, free = shield.predict({"position": np.array([0.0, 2.0])})
    assert shield.explain(free).held == {} and "on the way around" not in str(shield.explain(free))

    _, both = shield.predict({"position": np.zeros((2, 2))})
    for row in ((), 3, (0, 0), True):
        with pytest.raises(ValueError, match="batch shape"):
            shield.explain(both, row)


def test_for_those_in_a_hurry_it_keeps_its_state_itself() -> None:
    shield = Shield(straight, world())
    seen = {"position": np.array([0.8, 0.0])}
    first = shield.act(seen)
    shield.act(seen)
    shield.reset()
    np.testing.assert_array_equal(shield.act(seen), first)
