"""What stays on this machine computes several numbers at a time, and the same ones."""

from pathlib import Path

import pytest
import torch
from _inputs.clutter import POST, START, TARGET, policy

from aicon_torch import load_exported
from aicon_torch.export.codegen import compiler, has_compiler
from aicon_torch.parts import reading_of

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


@pytest.mark.slow
def test_a_compiled_step_and_an_exported_one_agree_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "policy.so"
    policy().export(path)
    exported, compiled = load_exported(path), policy()
    q, memory, other = START, None, None
    for _ in range(50):
        seen = {"q": q, "target_position": TARGET, "obstacles": reading_of([POST], 2)}
        action, memory = compiled.predict(seen, memory)
        again, other = exported.predict(seen, other)
        assert torch.equal(torch.as_tensor(again), action)
        q = q + 0.02 * action


def test_another_processor_takes_no_library_of_this_one(monkeypatch: pytest.MonkeyPatch) -> None:
    names = set()
    monkeypatch.setattr(compiler.platform, "machine", lambda: "x86_64")
    for widest in ("DEFAULT", "AVX2", "AVX512"):
        monkeypatch.setattr(torch.backends.cpu, "get_cpu_capability", lambda widest=widest: widest)
        names.add(compiler.identity("int a;", stays_here=True))
    assert len(names) == 3
    assert compiler.identity("int a;") in names
