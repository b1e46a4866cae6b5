"""What a policy cannot be made of, or be asked about, is refused by its name."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import torch
from _inputs.following import distance, follower, wandering
from _inputs.tracking import MOVE, near, tracked_point, tracking_model

from aicon_torch import (
    Actuator,
    AiconError,
    Goal,
    GraphError,
    ObservationError,
    Policy,
    Shield,
    WorldModel,
    load_exported,
)
from aicon_torch.export.codegen import has_compiler


def kept_away() -> WorldModel:
    """A graph that only says where not to be."""
    away = Goal("away", lambda p: 0.5 - distance(p), safety=True)
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    return tracking_model(MOVE, tracked_point(), goals=[away], actuators=actuators)


def test_safety_goals_alone_are_no_policy_but_a_shield() -> None:
    with pytest.raises(GraphError, match=r"Only safety goals .* 'a': .*Shield\(policy, model\)"):
        Policy(kept_away())

    shield = Shield(lambda observation: torch.ones(2), kept_away())
    action, _ = shield.predict({"z": torch.tensor([3.0, 1.0])})
    assert action.norm() > 0.9

    followed = kept_away().with_goal(Goal("near", near))
    assert list(Policy(followed).model.goals) == ["away", "near"]


WRONG: dict[str, tuple[Callable[[Policy], Any], str]] = {
    "model": (lambda p: Policy(3), "model=3: expected WorldModel"),  # type: ignore[arg-type]
    "law": (lambda p: Policy(p.model, law=3), "law=3: expected ActionLaw, such as Foresight"),
    "perception": (
        lambda p: Policy(p.model, perception=3),
        r"perception=3: .*perception\(observation, values, starts\)",
    ),
    "goal": (lambda p: p.with_goal(3), r"goals: expected .*Goal\('name', cost\), got in it 3"),
    "estimator": (lambda p: p.with_estimator(3), "estimators: expected .*, got in it 3"),
    "file": (lambda p: load_exported(3), "path=3: expected a file"),
}


@pytest.mark.parametrize(("call", "told"), WRONG.values(), ids=WRONG.keys())
def test_an_argument_that_is_something_else_is_named(call: Callable[[Any], Any], told: str) -> None:
    with pytest.raises(AiconError, match=told):
        call(follower())


def as_it_is(observation: Any, values: Any, starts: Any) -> Any:
    """A perception that has nothing to do."""
    return observation


def follows(kind: str, folder: Path, perception: Any = None) -> Any:
    """A policy as it is, compiled or exported."""
    if kind != "readable" and not has_compiler():
        pytest.skip("there is no C compiler")

    policy = Policy(follower().model, perception=perception)
    if kind == "readable":
        return policy
    if kind == "compiled":
        return policy.compile()
    policy.export(folder / "policy.so")
    return load_exported(folder / "policy.so", perception)


@pytest.mark.parametrize("kind", ["readable", "compiled", "exported"])
def test_what_is_no_memory_is_refused_wherever_one_is_expected(kind: str, tmp_path: Path) -> None:
    asked: list[Callable[[Any], Any]] = []
    for perception in (None, as_it_is):
        policy = follows(kind, tmp_path, perception)
        asked.append(partial(policy.predict, wandering(1)[0]))
        asked.append(partial(policy.switch, near=0.5))
        if kind != "exported":
            asked += [policy.trace, policy.explain]

    for ask in asked:
        for memory in ({}, 3, {"p": torch.ones(2)}):
            with pytest.raises(ObservationError, match="state: "):
                ask(memory)
