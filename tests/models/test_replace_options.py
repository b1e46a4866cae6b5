"""Options of nested dataclasses, replaced by dotted names."""

from dataclasses import dataclass, field
from typing import Any

import pytest

from aicon_torch import OptionError
from aicon_torch.models import replace_options


@dataclass(frozen=True)
class Wheel:
    radius: float = 0.1

    def __post_init__(self) -> None:
        if not self.radius > 0:
            raise OptionError(f"radius={self.radius!r}: expected a positive number.")


@dataclass(frozen=True)
class Axle:
    length: float = 0.5
    wheel: Wheel = field(default_factory=Wheel)


@dataclass(frozen=True)
class Robot:
    name: str = "robot"
    front: Axle = field(default_factory=Axle)
    back: Axle | None = None


def test_nothing_changes_without_changes() -> None:
    assert replace_options(Robot(), {}) == Robot()


def test_fields_are_named_by_their_path() -> None:
    changed = replace_options(
        Robot(), {"name": "cart", "front.length": 0.7, "front.wheel.radius": 0.2}
    )
    assert changed == Robot(name="cart", front=Axle(length=0.7, wheel=Wheel(0.2)))


def test_the_options_that_were_given_stay_what_they_are() -> None:
    robot = Robot()
    replace_options(robot, {"front.wheel.radius": 0.2})
    assert robot == Robot()


@pytest.mark.parametrize("order", [1, -1])
def test_a_part_is_replaced_in_a_new_whole_whatever_the_order(order: int) -> None:
    changes: list[tuple[str, Any]] = [("back", Axle(length=0.3)), ("back.wheel.radius", 0.2)]
    changed = replace_options(Robot(), dict(changes[::order]))
    assert changed.back == Axle(length=0.3, wheel=Wheel(0.2))


@pytest.mark.parametrize(
    ("changes", "culprit"),
    [
        ({"colour": "red"}, "'cart' has no option 'colour'. Options: 'name', 'front', 'back'"),
        ({"front.width": 1.0}, "'front' of 'cart' has no option 'width'. Options: 'length'"),
        ({"front.wheel.tyre": 1}, "'wheel' of 'front' of 'cart' has no option 'tyre'"),
        ({"back.length": 1.0}, "'back' of 'cart' is None; it has no option 'length'"),
        ({"name.first": "a"}, "'name' of 'cart' is 'robot'; it has no option 'first'"),
        ({"front.wheel.radius": 0.0}, "radius=0.0"),
    ],
    ids=str,
)
def test_what_is_unknown_or_cannot_be_is_named(changes: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        replace_options(Robot(), changes, "'cart'")
