"""Late readings: the belief of then is corrected, and moved on to now."""

from typing import Any

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch import EKF, Affine, GraphError, LateEKF, Measurement
from aicon_torch.quantities import AGE, PRESENT

DT = 0.1
OPTIONS: dict[str, Any] = {
    "predict": Affine(x=1.0, u=1.0),
    "noise": 0.01,
    "initial": ((0.0, 0.0), 100.0),
}


def residual(x: Tensor, z: Tensor) -> Tensor:
    return x - z


def late(steps: int) -> LateEKF:
    correct = [Measurement(residual, 0.04, size=2)]
    moved_by = {"u": 2}
    own: dict[str, Any] = {"sensor": "z", "steps": steps, "moved_by": moved_by}
    return LateEKF("x", "P", **own, correct=correct, **OPTIONS).double()


def run(filtered: EKF, ages: list[int | None], seed: int = 0) -> tuple[dict[str, Tensor], Tensor]:
    """Beliefs after readings of these ages, in steps, None for no reading; and where it is."""
    moves = normal(len(ages), 3, 2, seed=seed)
    places = moves.cumsum(0)
    belief = filtered.initial({})
    belief = {name: value.expand(3, *value.shape) for name, value in belief.items()}

    for step, age in enumerate(ages):
        taken = places[max(step - (age or 0), 0)]
        known = {
            "u": moves[step],
            "z": taken,
            "z" + AGE: torch.full((3,), DT * (age or 0), dtype=torch.float64),
            "z" + PRESENT: torch.full((3,), age is not None),
            "dt": DT,
        }
        belief = filtered.update({**belief, **known})
    return belief, places[-1]


@pytest.mark.parametrize("steps", [1, 4])
def test_prompt_readings_are_filtered_as_ever(steps: int) -> None:
    prompt = EKF("x", "P", correct=[Measurement(residual, 0.04, size=2)], **OPTIONS).double()
    ages: list[int | None] = [0, 0, None, 0, None, None, 0]

    expected, _ = run(prompt, ages)
    belief, _ = run(late(steps), ages)
    torch.testing.assert_close(belief["x"], expected["x"])
    torch.testing.assert_close(belief["P"], expected["P"])


@pytest.mark.parametrize(
    "ages", [[0, 1, 2, 3, 3, 3, 3], [0, 1, None, None, 2, 1, 0], [0, 1, 2, 0, None, None, 2]]
)
def test_readings_of_any_age_tell_where_it_is_now(ages: list[int | None]) -> None:
    """Without noise in readings and motion; each is newer than the one before."""
    belief, place = run(late(3), ages)
    torch.testing.assert_close(belief["x"], place, rtol=0, atol=1e-2)


def test_it_becomes_less_certain_by_what_happened_since() -> None:
    belief, _ = run(late(3), [0, 1, 2, 3, 3, 3])
    assert belief["x_lag"].eq(3).all()
    noise = 0.01 * torch.eye(2, dtype=torch.float64)
    torch.testing.assert_close(belief["P"], belief["P_then"] + 3 * noise)


def test_without_readings_the_belief_of_then_goes_along() -> None:
    belief, _ = run(late(2), [0, *[None] * 6])
    assert belief["x_lag"].eq(2).all() and belief["x"].isfinite().all()


def test_ages_are_times_however_long_the_steps_were() -> None:
    """It moves evenly, and is seen as it was 0.3 s ago, in steps that differ from row to row."""
    correct = [Measurement(residual, 1e-6, size=2)]
    options = {**OPTIONS, "predict": Affine(x=1.0, u="dt"), "noise": 1e-6, "correct": correct}
    moved_by = {"u": 2, "dt": 1}
    filtered = LateEKF("x", "P", sensor="z", steps=6, moved_by=moved_by, **options).double()

    velocity = normal(2, 2, seed=3)
    belief = filtered.initial({"dt": DT})
    belief = {name: value.expand(2, *value.shape) for name, value in belief.items()}
    now = torch.zeros(2, 1, dtype=torch.float64)
    for lengths in ([1, 2], [3, 1], [1, 1], [1, 3], [2, 1], [1, 1], [1, 1], [1, 2], [1, 1]):
        dt = DT * torch.tensor(lengths, dtype=torch.float64).unsqueeze(-1)
        now = now + dt
        known = {
            "u": velocity,
            "z": velocity * (now - 0.3).clamp(min=0.0),
            "z" + AGE: torch.full((2,), 0.3, dtype=torch.float64),
            "z" + PRESENT: torch.ones(2, dtype=torch.bool),
            "dt": dt,
        }
        belief = filtered.update({**belief, **known})

    # Ages count to the beginning of a step, which here is at most half a step off.
    torch.testing.assert_close(belief["x"], velocity * now, rtol=0, atol=0.11)
    assert belief["x_lag"].flatten().tolist() == [3, 2]


def test_what_is_on_time_corrects_the_belief_of_its_own_step() -> None:
    """As much as an EKF that gets both on time, once the late one has come too."""

    def felt(x: Tensor, f: Tensor) -> Tensor:
        return x[..., :1] - f

    seen, touched = Measurement(residual, 0.04, size=2), Measurement(felt, 0.01)
    prompt = EKF("x", "P", correct=[touched, seen], **OPTIONS).double()
    moved_by = {"u": 2, "f": 1}
    own: dict[str, Any] = {"sensor": ("z", "y"), "steps": 3, "moved_by": moved_by}
    filtered = LateEKF("x", "P", **own, correct=[seen], prompt=[touched], **OPTIONS).double()

    # It moves; a force is felt now, and from the third step on it is seen as it was two steps ago.
    moves, readings, forces = (normal(6, 3, k, seed=k) for k in (2, 3, 1))
    expected, belief = prompt.initial({}), filtered.initial({})
    expected, belief = (
        {name: value.expand(3, *value.shape) for name, value in one.items()}
        for one in (expected, belief)
    )
    absent = {"y" + PRESENT: torch.zeros(3, dtype=torch.bool), "y" + AGE: torch.zeros(3)}
    for step in range(6):
        sees = torch.full((3,), step >= 2)
        now = {"u": moves[step], "f": forces[step], "dt": DT, **absent}
        late_reading = {"z": readings[max(step - 2, 0), :, :2], "z" + PRESENT: sees}
        age = {"z" + AGE: torch.full((3,), 2 * DT, dtype=torch.float64)}
        belief = filtered.update({**belief, **now, **late_reading, **age})

        at_once = {"z": readings[step, :, :2], "z" + PRESENT: torch.full((3,), step < 4)}
        expected = prompt.update({**expected, **now, **at_once})

    torch.testing.assert_close(belief["x"], expected["x"])
    torch.testing.assert_close(belief["P"], expected["P"])


def test_what_was_missing_at_a_step_is_missing_whenever_that_is_gone_through() -> None:
    """As an EKF that gets all of it again, from the prior on, once a late reading has come."""

    def felt(x: Tensor, f: Tensor) -> Tensor:
        return x[..., :1] - f

    seen, touched = Measurement(residual, 0.04, size=2), Measurement(felt, 0.01)
    moved_by = {"u": 2, "f": 1, "f" + PRESENT: 1}
    own: dict[str, Any] = {"sensor": "z", "steps": 4, "moved_by": moved_by}
    filtered = LateEKF("x", "P", **own, correct=[seen], prompt=[touched], **OPTIONS).double()
    at_once = EKF("x", "P", correct=[touched, seen], **OPTIONS).double()

    # It is felt at two steps of six, and seen at the last one as it was three steps before.
    moves, forces, reading = normal(6, 2, seed=2), normal(6, 1, seed=1), normal(2, seed=3)
    belief, expected = filtered.initial({}), at_once.initial({})
    for step in range(6):
        now = {"u": moves[step], "f": forces[step], "dt": DT}
        now["f" + PRESENT] = torch.tensor(step in (0, 5))
        sight = {"z": reading, "z" + AGE: torch.tensor(3 * DT)}
        belief = filtered.update({**belief, **now, **sight, "z" + PRESENT: torch.tensor(step == 5)})
        expected = at_once.update(
            {**expected, **now, **sight, "z" + PRESENT: torch.tensor(step == 2)}
        )

    torch.testing.assert_close(belief["x"], expected["x"])
    torch.testing.assert_close(belief["P"], expected["P"])


def test_whichever_sensor_has_read_tells_when() -> None:
    seen = Measurement(residual, 0.04, size=2)
    own: dict[str, Any] = {"sensor": ("z", "y"), "steps": 3, "moved_by": {"u": 2}}
    filtered = LateEKF("x", "P", **own, correct=[seen], **OPTIONS).double()
    belief = {key: value.expand(2, *value.shape) for key, value in filtered.initial({}).items()}

    # One row is seen by the first sensor, a step late, the other by the second, on time.
    values = {
        "u": normal(2, 2),
        "z": normal(2, 2),
        "z" + PRESENT: torch.tensor([True, False]),
        "z" + AGE: torch.tensor([DT, 0.0]),
        "y" + PRESENT: torch.tensor([False, True]),
        "y" + AGE: torch.tensor([0.0, 0.0]),
        "dt": DT,
    }

    for _ in range(2):
        belief = filtered.update({**belief, **values})
    assert belief["x_lag"].flatten().tolist() == [1, 0]


def test_what_moves_it_must_be_read() -> None:
    with pytest.raises(GraphError, match=r"moved_by of 'x'.*'x', 'u', not 'v'"):
        LateEKF("x", "P", sensor="z", steps=1, moved_by={"v": 2}, **OPTIONS)


def test_what_is_on_time_must_measure_the_mean() -> None:
    own: dict[str, Any] = {"sensor": "z", "steps": 1, "moved_by": {"u": 2}}
    felt = Measurement(lambda f: f, 0.01)
    with pytest.raises(GraphError, match=r"A prompt measurement of 'x' reads 'f'.*read 'x'"):
        LateEKF("x", "P", **own, prompt=[felt], **OPTIONS)
