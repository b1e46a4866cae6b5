"""The ten lines of the README: a URDF in, a target reached."""

import pytest
from _documents import ROOT, blocks

(PROGRAM,) = [block for block in blocks(ROOT / "README.md", "py") if '"reach"' in block.code]


def test_they_are_ten_lines() -> None:
    assert sum(bool(line.strip()) for line in PROGRAM.code.splitlines()) <= 10


def test_they_reach_the_target(capsys: pytest.CaptureFixture[str]) -> None:
    for module in ("pytorch_kinematics", "trimesh", "collada"):
        pytest.importorskip(module)
    robots = pytest.importorskip("_inputs.robots", exc_type=ImportError)
    file = robots.robot_file(robots.ROBOTS["ur5"].urdf)

    code = PROGRAM.code.replace("ur5.urdf", str(file))
    exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert "tensor(0.00" in printed, printed
