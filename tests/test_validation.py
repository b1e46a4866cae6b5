"""Options: what is neither True nor False is no flag."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _inputs.tracking import move, near, tracked_point

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Exploration,
    Goal,
    NullspaceProjection,
    OptionError,
    Sensor,
    TrapEscape,
    make_policy,
)
from aicon_torch.dampers import PlaceEscape

FLAGS: dict[str, Callable[[Any], Any]] = {
    "optional": lambda flag: Sensor(2, "m", optional=flag),
    "keeps_direction": lambda flag: Actuator(2, "m/s", keeps_direction=flag),
    "accumulate": lambda flag: DirectDescent(accumulate=flag),
    "relative": lambda flag: NullspaceProjection(relative=flag),
    "unless_tracking": lambda flag: Exploration(unless_tracking=flag),
    "onward": lambda flag: TrapEscape(onward=flag),
    "seeks": lambda flag: PlaceEscape(seeks=flag),
    "safety": lambda flag: Goal("near", near, safety=flag),
    "Deterministic 'x': is_motion": lambda flag: Deterministic("x", move, is_motion=flag),
    "'p': is_motion": lambda flag: tracked_point(is_motion=flag),
    "watchdog": lambda flag: make_policy("nav2d", watchdog=flag),
}


@pytest.mark.parametrize(("name", "build"), FLAGS.items(), ids=FLAGS.keys())
def test_a_flag_is_true_or_false(name: str, build: Callable[[Any], Any]) -> None:
    build(np.True_)
    for wrong in ("no", 1, None):
        with pytest.raises(OptionError, match=f"{name}={wrong!r}: expected True or False"):
            build(wrong)


@pytest.mark.parametrize(("name", "wrong"), [("progress", ["near"]), ("hold", 3), ("along", 3)])
def test_an_escape_names_goals(name: str, wrong: Any) -> None:
    with pytest.raises(OptionError, match=f"{name}="):
        TrapEscape(**{name: wrong})


@pytest.mark.parametrize("name", ["progress_margin", "hold_gain"])
@pytest.mark.parametrize("wrong", [-1.0, np.nan, "2"])
def test_numbers_of_an_escape_are_not_negative(name: str, wrong: Any) -> None:
    with pytest.raises(OptionError, match=f"{name}="):
        TrapEscape(**{name: wrong})
