"""Readings that are missing: the estimates predict and go on; an episode must begin with them."""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import rollout
from _inputs import lean
from _inputs.pushing import RADIUS, body_of, wandering, without

from aicon_torch.models import pusht
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import PoseMotion

POLICY = lean("pusht")
BODY = body_of()


def registered(reading: dict[str, torch.Tensor]) -> torch.Tensor:
    return BODY.registration(PIXEL * reading["environment_state"].unflatten(-1, (-1, 2)))


@pytest.mark.parametrize("lost", ["all keypoints", "one coordinate", "the key"])
def test_without_keypoints_it_predicts_and_goes_on(lost: str) -> None:
    """The pose is where the pushes have moved it; the next reading corrects it."""
    motion = PoseMotion(pusht.Options().contact.dynamics(BODY), RADIUS)
    memory = None
    for step, reading in enumerate(wandering(8, 3)):
        seen, blind = dict(reading), step in (3, 4, 5)
        if blind and lost == "the key":
            seen = without(reading, "environment_state")
        elif blind:
            hidden = seen["environment_state"].clone()
            hidden[:, slice(None) if lost == "all keypoints" else 3] = torch.nan
            seen["environment_state"] = hidden

        before = memory
        action, memory = POLICY.predict(seen, memory)
        assert action.isfinite().all()
        assert all(value.isfinite().all() for value in memory.values())

        if not blind:
            error = (memory["x_pose"] - registered(reading))[:, :2]
            assert (error.abs() < 0.2 * PIXEL).all()
            continue
        assert before is not None
        predicted = motion(before["x_pose"], memory["x_pusher"], memory["d_pusher"])
        torch.testing.assert_close(memory["x_pose"], predicted)
        growth = (memory["P_pose"] - before["P_pose"]).diagonal(dim1=-2, dim2=-1)
        assert growth.min() > 0


def test_without_its_own_place_it_reckons_from_what_it_did() -> None:
    memory = rollout(POLICY, wandering(3, 3))[-1]
    blind = wandering(4, 3)[3] | {"agent_pos": torch.full((3, 2), torch.nan, dtype=torch.float64)}
    _, after = POLICY.predict(blind, memory)
    torch.testing.assert_close(after["x_pusher"], memory["x_pusher"] + 0.1 * memory["a"])


def test_rows_may_drop_out_alone() -> None:
    """A row that loses its reading is one that lost it alone, and the others do not notice."""
    first, second = wandering(2, 3)
    _, memory = POLICY.predict(first)
    hidden = second["environment_state"].clone()
    hidden[1] = torch.nan

    some, none, everything = (
        POLICY.predict(reading, memory)[1]
        for reading in (
            second | {"environment_state": hidden},
            second,
            without(second, "environment_state"),
        )
    )
    for name in ("a", "x_pose", "P_pose"):
        torch.testing.assert_close(some[name][[0, 2]], none[name][[0, 2]])
        torch.testing.assert_close(some[name][1], everything[name][1])


MISSING = [("agent_pos",), ("environment_state",), ("agent_pos", "environment_state")]
each_missing = pytest.mark.parametrize("missing", MISSING, ids=str)


@each_missing
@pytest.mark.parametrize("kind", [np.asarray, torch.as_tensor])
def test_an_episode_begins_with_the_first_readings(missing: tuple[str, ...], kind: Any) -> None:
    """Until they have come a row rests, and the others do not notice."""
    reading = {name: value.numpy() for name, value in wandering(1, 3)[0].items()}
    some = dict(reading)
    for name in missing:
        some[name] = np.where([[False], [True], [False]], np.nan, reading[name])
    reading, some = (
        {name: kind(value) for name, value in given.items()} for given in (reading, some)
    )

    _, expected = POLICY.predict(reading)
    _, waiting = POLICY.predict(some)
    assert waiting["begins"].tolist() == [False, True, False]
    assert waiting["a"][1].tolist() == [0.0, 0.0]
    assert torch.equal(waiting["a"][[0, 2]], expected["a"][[0, 2]])
    assert "at rest" in str(POLICY.explain(waiting, row=1))

    _, after = POLICY.predict(reading, waiting)
    torch.testing.assert_close(after["a"][1], expected["a"][1])
    torch.testing.assert_close(after["x_pose"][1], expected["x_pose"][1])


@each_missing
def test_however_long_it_waits_the_first_reading_tells(missing: tuple[str, ...]) -> None:
    readings = wandering(4, 2)
    memory = None
    for reading in readings[:2]:
        blind = dict(reading)
        for name in missing:
            blind[name] = torch.full_like(reading[name], torch.nan)
        action, memory = POLICY.predict(blind, memory)
        assert action.isfinite().all()
        assert all(value.isfinite().all() for value in memory.values())

    for reading in readings[2:]:
        action, memory = POLICY.predict(reading, memory)
        assert action.isfinite().all()
    assert memory is not None
    place = PIXEL * readings[3]["agent_pos"]
    assert (memory["x_pusher"] - place).norm(dim=-1).max() < 5 * PIXEL
    error = (memory["x_pose"] - registered(readings[3]))[:, :2]
    assert error.norm(dim=-1).max() < PIXEL


def test_at_rest_it_stays_where_it_is_whatever_is_read() -> None:
    """A command is a place: it would follow readings of the pusher that are wrong."""
    memory, commands = rollout(POLICY, wandering(3, 3))[-1], []
    blind = without(wandering(4, 3)[3], "environment_state")
    for step in range(8):
        shifted = blind["agent_pos"] + 30.0 * step
        command, memory = POLICY.predict(blind | {"agent_pos": shifted}, memory)
        commands.append(command)

    assert (memory["a"] == 0).all()
    assert torch.equal(commands[-1], commands[3])


def test_keypoints_that_no_body_of_this_shape_has_are_none() -> None:
    memory = rollout(POLICY, wandering(3, 3))[-1]
    reading = dict(wandering(4, 3)[3])
    reading["environment_state"] = reading["environment_state"].clone()
    reading["environment_state"][1, 4] += 20.0  # px

    _, after = POLICY.predict(reading, memory)
    assert after["z_keypoints.present"].tolist() == [True, False, True]
