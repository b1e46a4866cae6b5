"""The library and its plain counterpart are two implementations of one law."""

import pytest
import torch
from _asserts import rollout
from _inputs import drifting

import plain_navigation as plain
from aicon_torch import make_policy

PATHS = ["reach → p_tar", "reach → P_tar", "avoid → x_obs"]
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


@pytest.mark.parametrize("closed_form", [False, True], ids=["autograd", "closed form"])
@pytest.mark.parametrize("batch", [(), (4,)], ids=str)
def test_the_plain_step_is_the_library_s(closed_form: bool, batch: tuple[int, ...]) -> None:
    """Over 300 steps on recorded readings, exploring a good part of the time.

    Each step starts from the library's memory: a difference in the last digit would grow along a chaotic run.
    """
    policy, recorded = make_policy("nav2d"), drifting(300, batch, seed=3)
    order = torch.tensor(
        [[str(a) for a in policy.backward_pass.arrivals["x_rob"]].index(path) for path in PATHS]
    )
    state = plain.begin(recorded[0]["bearing"], recorded[0]["range"])
    memories = rollout(policy, recorded)
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
        state = plain.State(rank=torch.where(rank >= 0, order.argsort()[rank], -1), **known)
    share = torch.stack([memory["x_rob/exploring"] for memory in memories]).double().mean()
    assert 0.1 < share < 0.9
