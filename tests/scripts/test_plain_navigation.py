"""The library and its plain counterpart are two implementations of one law."""

import pytest
import torch
from _asserts import rollout
from _inputs import drifting

import plain_navigation as plain
from aicon_torch import make_policy
from aicon_torch.control import DirectDescent

LAW = DirectDescent(plain.GAIN, smoothing=plain.SMOOTHING)

PATHS = ["reach → p_tar → x_rob", "reach → P_tar → x_rob", "avoid → x_obs → x_rob"]
"""The order of the three gradients in the plain version."""

FIELDS = {
    "target": "p_tar",
    "target_cov": "P_tar",
    "obstacle": "x_obs",
    "obstacle_cov": "P_obs",
    "action": "a",
    "exploring": "x_rob/exploring",
    "average": "x_rob/average",
    "displacement": "x_rob/displacement",
}
"""Where the memory has what the plain version's state has."""


@pytest.mark.parametrize("closed_form", [False, True], ids=["autograd", "closed form"])
@pytest.mark.parametrize("batch", [(), (4,)], ids=str)
def test_the_plain_step_is_the_library_s(closed_form: bool, batch: tuple[int, ...]) -> None:
    """Over 120 steps on recorded readings, exploring a good part of the time.

    Each step starts from the library's memory: a difference in the last digit would grow along a
    chaotic run.
    """
    policy, recorded = make_policy("nav2d", law=LAW), drifting(120, batch, seed=3)
    state = plain.begin(recorded[0]["bearing"], recorded[0]["range"])
    memories = rollout(policy, recorded)

    # From an index in the plain version to that in the library, and back.
    labels = policy.trace(memories[0]).quantities["x_rob"].labels
    order = torch.tensor([labels.index(path) for path in PATHS])
    back = order.argsort()

    for reading, memory in zip(recorded, memories, strict=True):
        state = plain.step(state, reading["bearing"], reading["range"], closed_form)

        for field, name in FIELDS.items():
            torch.testing.assert_close(
                getattr(state, field),
                memory[name],
                rtol=1e-9,
                atol=1e-9,
                msg=lambda text, name=name: f"{name}: {text}",
            )
        rank = memory["x_rob/rank"]
        assert torch.equal(torch.where(state.rank >= 0, order[state.rank], -1), rank)

        known = {field: memory[name] for field, name in FIELDS.items()}
        state = plain.State(rank=torch.where(rank >= 0, back[rank], -1), **known)

    exploring = torch.stack([memory["x_rob/exploring"] for memory in memories])
    assert 0.1 < exploring.double().mean() < 0.9
