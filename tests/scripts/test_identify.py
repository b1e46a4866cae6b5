"""Constants of the arm are learned from a log."""

import pytest

pytest.importorskip("mujoco")

import identify
from aicon_baselines.agents.registry import make
from aicon_torch.export.codegen import has_compiler


@pytest.mark.slow
@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_an_offset_of_five_millimetres_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(identify, "SEEDS", range(1000, 1012))  # six leave the angle's offset open
    log = identify.record("bias", 60)
    policy = make("arm_push", "aicon", "bias")
    learner = identify.learn(policy, identify.LEARNED["bias"], log)
    x, y, _ = learner.model.numbers[identify.OFFSET].tolist()
    assert abs(x - 0.005) < 0.001 and abs(y - 0.005) < 0.001
