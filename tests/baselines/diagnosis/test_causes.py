"""What may be why is recognised in episodes of which it is known."""

import numpy as np
from _inputs.histories import (
    DT,
    STEPS,
    actuator,
    circling,
    conflict,
    history,
    innovation,
    resting,
    straight,
)

from aicon_baselines.diagnosis import Finding, diagnose
from aicon_baselines.diagnosis.history import History


def only_cause(of: History) -> Finding:
    """The cause, if there is exactly one."""
    (cause,) = diagnose(of).causes
    return cause


def test_a_conflict_that_is_explored_without_end_names_its_goals() -> None:
    meetings = {"x": conflict(-0.9, exploring=True, magnitudes=(1.0, 0.8))}
    found = only_cause(history(circling(3.0), meetings=meetings))

    assert (found.kind, found.subjects) == ("conflict", ("arrive", "keep off"))
    assert "does not end" in found.text


def test_a_conflict_that_is_not_explored_says_how_much_stronger_one_is() -> None:
    meetings = {"x": conflict(-0.9, exploring=False, magnitudes=(1.0, 0.1))}
    found = only_cause(history(resting(5.0), meetings=meetings))

    assert found.kind == "conflict"
    assert "10 times as strong" in found.text


def test_gradients_that_agree_are_no_conflict() -> None:
    meetings = {"x": conflict(0.9, exploring=False, magnitudes=(1.0, 0.8))}
    assert not diagnose(history(circling(3.0), meetings=meetings)).causes


def test_a_conflict_that_was_over_when_the_robot_came_to_rest_is_not_the_reason() -> None:
    meeting = conflict(-0.9, exploring=True, magnitudes=(1.0, 0.8))
    meeting.exploring[50:] = False
    meeting.cosine[50:] = 1.0

    assert not diagnose(history(resting(6.0), meetings={"x": meeting})).causes


def test_a_saturated_actuator_is_named_with_its_component() -> None:
    found = only_cause(history(straight(), actuators={"a": actuator(share=1.0)}))

    assert (found.kind, found.subjects) == ("limit", ("a",))
    assert "component 1" in found.text


def test_an_actuator_within_its_limit_is_not() -> None:
    assert not diagnose(history(straight(), actuators={"a": actuator(share=0.9)})).causes


def test_an_actuator_that_its_constraints_slow_down_is() -> None:
    slowed = {"a": actuator(share=0.3, constraints=("ClearanceLimits",))}
    found = only_cause(history(straight(), actuators=slowed))
    assert found.text.startswith("a uses 30 % of its limit: it is slowed down by ClearanceLimits")


def test_rest_on_a_slope_is_told_where_the_action_is_iterated() -> None:
    rests = {"a": actuator(share=0.0, gradient=0.2, smallest=1 / 60)}
    plain = {"a": actuator(share=0.0, gradient=0.2)}

    found = only_cause(history(resting(5.0), actuators=rests))
    assert "a gradient is left" in found.text
    assert not diagnose(history(resting(5.0), actuators=plain)).causes


def test_a_biased_estimate_disagrees_with_its_readings() -> None:
    found = only_cause(history(straight(), innovations=[innovation(mean=3.0, deviation=1.0)]))

    assert (found.kind, found.subjects) == ("disagreement", ("p",))
    assert "to the same side" in found.text


def test_an_estimate_that_is_too_sure_of_itself_disagrees_as_well() -> None:
    found = only_cause(history(straight(), innovations=[innovation(mean=0.0, deviation=8.0)]))
    assert found.kind == "disagreement"


def test_white_innovations_are_no_disagreement() -> None:
    fine = history(straight(), innovations=[innovation(mean=0.0, deviation=1.0)])
    assert not diagnose(fine).causes


def test_a_sensor_that_fell_silent_is_named() -> None:
    present = np.arange(STEPS) < STEPS // 2
    found = only_cause(history(straight(), present={"z_tar": present}))

    assert (found.kind, found.subjects) == ("silence", ("z_tar",))
    assert "none at the end" in found.text


def test_a_goal_that_never_rests_is_told_with_the_range_of_its_cost() -> None:
    cost = 2.0 + np.sin(2 * np.pi * DT * np.arange(STEPS) / 3.0)
    found = only_cause(history(circling(3.0), costs={"arrive": cost}))

    assert (found.kind, found.subjects) == ("restlessness", ("arrive",))
    assert "rose 13 times from about 1.01 to about 2.99" in found.text


def test_whatever_happened_there_is_something_to_read() -> None:
    assert "Nothing else stands out" in str(diagnose(history(circling(3.0))))
