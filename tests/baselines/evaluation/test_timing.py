"""Programs timed side by side."""

import pytest

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.timing import ratios, replay, spread, take_turns


def test_programs_take_turns_after_a_warm_up() -> None:
    calls: list[str] = []
    programs = {name: lambda name=name: calls.append(name) for name in ("a", "b")}
    times = take_turns(programs, rounds=2, steps=3, name="test")

    assert "".join(calls) == "aaabbb" * 3
    assert all(len(seconds) == 2 and min(seconds) >= 0 for seconds in times.values())


@pytest.mark.parametrize("wrong", ["rounds", "steps"])
def test_no_round_and_no_step_are_refused(wrong: str) -> None:
    with pytest.raises(ComparisonError, match=f"{wrong} must be 1 or more, not 0"):
        take_turns({"a": lambda: None}, **{"rounds": 1, "steps": 1, wrong: 0}, name="test")


def test_spread_is_median_and_percentiles() -> None:
    assert spread(range(101), factor=2.0) == "100 (10 to 190)"
    assert spread([0.5]) == "0.5 (0.5 to 0.5)"
    assert spread([1.4321], factor=1e3) == "1,432 (1,432 to 1,432)"
    assert spread([999.7]) == "1,000 (1,000 to 1,000)"
    assert ratios([4.0, 9.0], [2.0, 3.0]) == [2.0, 3.0]


def test_replay_goes_through_the_observations_with_the_memory() -> None:
    class Counter:
        def __init__(self) -> None:
            self.seen: list[tuple[str, int | None]] = []

        def predict(self, observation: str, state: int | None = None) -> tuple[None, int]:
            self.seen.append((observation, state))
            return None, (state or 0) + 1

    policy = Counter()
    step = replay(policy, ["x", "y"])
    for _ in range(3):
        step()
    assert policy.seen == [("x", None), ("y", 1), ("x", 2)]
