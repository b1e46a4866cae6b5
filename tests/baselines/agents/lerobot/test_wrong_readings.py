"""What a motor cannot have meant moves no arm: neither a shielded one nor one that seeks a pose."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import AboveTable, arm, joints, to_action
from lerobot.processor.core import TransitionKey

from lerobot_robot_aicon import EndEffectorStep
from lerobot_robot_aicon.arm_options import ShieldOptions
from lerobot_robot_aicon.commanded_joints import CommandedJoints
from lerobot_robot_aicon.joint_shield import JointShield

pytestmark = pytest.mark.slow

HOME = np.array([0.0, -90.0, 80.0, 10.0, 0.0])
STEP = np.degrees(1.5 / 30)
"""How far a joint may go in a step, degrees."""

WRONG = (np.nan, np.inf, 300.0, -300.0, 60.0, -45.0)

Sending = Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]]
"""From what motors show and where they are told to go to what they are sent, ``(5,)``, degrees."""


@pytest.fixture(scope="module")
def shield() -> JointShield:
    return JointShield(ShieldOptions(urdf="so101", table=0.0))


@pytest.fixture(scope="module")
def seeking() -> EndEffectorStep:
    return EndEffectorStep(urdf="so101", orientation="axis")


@pytest.fixture(params=["shield", "pose"])
def send(request: pytest.FixtureRequest, shield: JointShield, seeking: EndEffectorStep) -> Sending:
    """An episode behind the shield, or of the step that seeks a pose, which none tells where."""
    shield.reset()
    seeking.reset()
    pose = {f"ee.{name}": 0.1 for name in ("x", "y", "z", "wx", "wy", "wz")}

    def behind_shield(shown: NDArray[Any], told: NDArray[Any]) -> NDArray[Any]:
        return np.degrees(joints(shield(to_action(shown), to_action(told))))

    def to_pose(shown: NDArray[Any], _: NDArray[Any]) -> NDArray[Any]:
        transition = {TransitionKey.OBSERVATION: to_action(shown), TransitionKey.ACTION: pose}
        return np.degrees(joints(seeking(transition)[TransitionKey.ACTION]))

    send = behind_shield if request.param == "shield" else to_pose
    with pytest.raises(KeyError):  # one reading is none
        send(HOME, HOME)
    return send


def begin(shield: JointShield, q: NDArray[Any] = HOME) -> None:
    """Show where the arm stands for the first time, which is not acted upon."""
    shield.reset()
    assert shield(to_action(q), to_action(q)) == {}


def with_one(shown: NDArray[Any], joint: int, value: float) -> NDArray[Any]:
    """What motors show ``(5,)``, but for one of them."""
    wrong = shown.copy()
    wrong[joint] = value
    return wrong


@pytest.mark.parametrize("value", WRONG)
def test_one_wrong_reading_holds_the_arm_for_one_step(send: Sending, value: float) -> None:
    told = np.array([40.0, -60.0, 50.0, 30.0, 0.0])
    q = last = HOME
    for t in range(12):
        joint = t // 2 % 5
        is_wrong = t % 2 == 1 and not abs(value - q[joint]) < 30.0
        sent = send(with_one(q, joint, value) if is_wrong else q, told)
        if is_wrong:
            assert sent == pytest.approx(last)
        assert np.abs(sent - last).max() <= STEP + 1e-6
        q, last = q + 0.7 * (sent - q), sent
    assert np.abs(q - HOME).max() > 5.0


def test_what_is_sent_stays_above_the_table_with_any_one_wrong_reading(shield: JointShield) -> None:
    above_table, generator = AboveTable(), np.random.default_rng(0)
    into_it = np.array([0.0, 60.0, -30.0, 60.0, 0.0])
    begin(shield)
    q = last = HOME
    for t in range(150):
        shown = q
        if t % 7 == 6:
            joint, value = generator.integers(5), generator.uniform(-180.0, 180.0)
            away = 30.0 * np.sign(value - q[joint])
            shown = with_one(q, joint, value + away)
        q = np.degrees(joints(shield(to_action(shown), to_action(into_it))))
        assert np.abs(q - last).max() <= STEP + 1e-6
        assert above_table(np.radians(q)) > 0
        last = q
    assert above_table(np.radians(q)) < 0.03


def test_an_arm_that_was_moved_is_followed_no_faster_than_it_goes(
    shield: JointShield, caplog: pytest.LogCaptureFixture
) -> None:
    elsewhere = np.array([50.0, -40.0, 60.0, 10.0, 0.0])
    begin(shield)
    last = np.degrees(joints(shield(to_action(HOME), to_action(HOME))))
    for t in range(40):
        sent = np.degrees(joints(shield(to_action(elsewhere), to_action(HOME))))
        assert np.abs(sent - last).max() <= STEP + 1e-6
        assert (t >= 3) or sent == pytest.approx(last)
        last = sent
    assert sent == pytest.approx(elsewhere, abs=10.1 + STEP)
    assert "The arm was moved" in caplog.text

    # Then it goes where it is told.
    q = elsewhere
    for _ in range(60):
        q = np.degrees(joints(shield(to_action(q), to_action(HOME))))
    assert q == pytest.approx(HOME, abs=0.1)


def test_a_place_that_nothing_agrees_on_is_never_believed(shield: JointShield) -> None:
    begin(shield)
    first = shield(to_action(HOME), to_action(HOME))
    for t in range(20):
        shown = with_one(HOME, 0, 60.0 if t % 2 else -60.0)
        assert shield(to_action(shown), to_action(HOME)) == pytest.approx(first)
        assert shield.is_changed() and shield.explain() is None


def test_a_servo_that_lags_and_is_held_and_pushed_is_believed() -> None:
    """Its readings have noise, and the hand goes as fast as the joint can."""
    generator = np.random.default_rng(0)
    commanded = CommandedJoints(arm().chain, ShieldOptions(urdf="so101"))
    q = reference = np.zeros(5)
    lead = np.radians(10.0)
    commanded.look(to_action(q))
    for t in range(200):
        shown = q + generator.normal(0.0, 0.003, 5)
        state = commanded.look(to_action(np.degrees(shown)))
        reference = np.clip(reference if t else shown, shown - lead, shown + lead)
        assert not state.is_held and not state.is_displaced
        assert state.commanded == pytest.approx(reference)

        velocity = 1.5 * np.sign(np.sin(t / 5 + np.arange(5)))
        commanded.moved(state.commanded, velocity)
        reference = reference + velocity / 30
        q = q + (0.0 if 60 < t < 120 else 0.25) * (reference - q)
        if 80 < t < 100:
            q = q - 1.5 / 30 * np.sign(velocity)


@pytest.mark.parametrize(
    ("joint", "value", "message"),
    [
        (1, 150.0, r"shoulder_lift seems to stand at 150°, beyond its stops, .* is not moved"),
        (1, 60.0, r"the arm seems to be \d+ cm within its margin, so it is not moved"),
        (2, np.nan, r"elbow_flex: its motor shows nan, .* so the arm is not moved"),
    ],
)
def test_an_arm_that_does_not_stand_as_described_is_never_moved(
    shield: JointShield, joint: int, value: float, message: str
) -> None:
    if message.startswith("the arm"):
        begin(shield, with_one(HOME, joint, value))
    else:
        shield.reset()
    for _ in range(3):
        with pytest.raises(ValueError, match=message):
            shield(to_action(with_one(HOME, joint, value)), to_action(HOME))
    assert shield.explain() is None
    shield(to_action(HOME), to_action(HOME))
    sent = np.degrees(joints(shield(to_action(HOME), to_action(HOME))))
    assert sent == pytest.approx(HOME, abs=0.1)
