"""What has no translation to C is compiled by TorchInductor, or runs as it is and says why."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from _asserts import assert_same_steps
from _inputs import drifting, lean
from _inputs.following import Readings, bold_when_far, follower, passing, wandering
from _inputs.hand import readable_hand, turn
from torch import Tensor

from aicon_torch import Policy
from aicon_torch.dampers import PlaceEscape

with_compiler = pytest.mark.skipif(
    not shutil.which(os.environ.get("CXX", "g++")), reason="there is no C++ compiler"
)


@with_compiler
@pytest.mark.slow
@pytest.mark.parametrize(
    ("policy", "readings"),
    [
        pytest.param(follower(), wandering(6, (3,)), id="follower"),
        pytest.param(lean("nav2d"), drifting(20, (3,)), id="nav2d"),
        pytest.param(lean("pusht"), passing(6, (3,)), id="pusht"),
    ],
)
def test_what_has_no_translation_to_c_is_compiled_otherwise(
    policy: Policy, readings: Readings
) -> None:
    """By TorchInductor, as on other devices."""
    compiled = policy.compile()
    compiled._native = None
    assert_same_steps(policy, compiled, readings)


@with_compiler
@pytest.mark.slow
def test_behind_a_stop_it_stays_where_torch_reads_a_sum_too_early() -> None:
    """A gap's slope is the gradient of a selection, which TorchInductor 2.10 gets wrong fused."""
    readable = readable_hand(PlaceEscape())
    compiled = readable.compile()
    compiled._native = None
    ways = [turn(policy, 2.5, -2.8, steps=60)[0] for policy in (readable, compiled)]
    torch.testing.assert_close(*ways)


def test_what_cannot_be_traced_runs_uncompiled() -> None:
    policy = follower(bold_when_far)
    compiled = policy.compile()
    with pytest.warns(RuntimeWarning, match="runs uncompiled.*branch on values") as warned:
        assert_same_steps(policy, compiled, wandering(6))
    assert len(warned) == 1


def in_numpy(p: Tensor) -> Tensor:
    """No function of tensors alone: what it reads would be a constant of the compiled step."""
    return torch.as_tensor(np.linalg.norm(p.detach().numpy(), axis=-1)) + 0.0 * p.sum(-1)


def test_what_reads_numbers_in_numpy_runs_uncompiled() -> None:
    """TorchInductor would compile it with the numbers of the first step."""
    policy = follower(in_numpy)
    compiled = policy.compile()
    with pytest.warns(RuntimeWarning, match=r"runs uncompiled.*Tensor\.numpy asks"):
        assert_same_steps(policy, compiled, wandering(4))


@pytest.mark.slow
def test_without_a_compiler_it_runs_uncompiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # nothing was compiled before
    config = pytest.importorskip("torch._inductor.config")
    policy = follower()
    compiled = policy.compile()

    with (
        config.patch({"cpp.cxx": ("no-such-compiler",), "force_disable_caches": True}),
        pytest.warns(RuntimeWarning, match=r"runs uncompiled.*C\+\+ compiler") as warned,
    ):
        assert_same_steps(policy, compiled, wandering(6))

    assert len(warned) == 1
