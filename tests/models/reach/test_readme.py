"""The ten lines of the README as they stand: a URDF in, a target reached."""

import pytest
from _documents import ROOT, blocks

(PROGRAM,) = [block for block in blocks(ROOT / "README.md", "python") if '"reach"' in block.code]


def test_they_are_ten_lines() -> None:
    assert sum(bool(line.strip()) for line in PROGRAM.code.splitlines()) <= 10


@pytest.mark.slow
def test_they_reach_the_target(capsys: pytest.CaptureFixture[str]) -> None:
    for module in ("pytorch_kinematics", "trimesh", "collada", "mujoco"):
        pytest.importorskip(module)

    exec(compile(PROGRAM.code, "README.md", "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert "tensor(0.00" in printed, printed
