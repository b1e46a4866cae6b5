"""The README keeps what it announces: a graph of one's own is short, and has these paths."""

import re

import pytest
from _documents import ROOT, blocks

README = ROOT / "README.md"
GRAPHS = [block for block in blocks(README, "python") if "WorldModel(" in block.code]


def test_a_user_s_graph_takes_less_than_30_lines() -> None:
    assert GRAPHS
    for block in GRAPHS:
        assert sum(bool(line.strip()) for line in block.code.splitlines()) < 30


def test_the_graph_s_paths_are_those_that_it_announces(capsys: pytest.CaptureFixture[str]) -> None:
    """`print(model.paths())  # a → b → c,  …` prints these paths."""
    for block in GRAPHS:
        exec(compile(block.code, str(block), "exec"), {"__name__": "__main__"})
        printed = capsys.readouterr().out.splitlines()

        announced = re.search(r"print\(model\.paths\(\)\)\s*#(.*)", block.code)
        assert announced
        for path in announced.group(1).split(","):
            assert path.strip() in printed


def test_every_block_of_python_is_a_program_that_runs() -> None:
    """Fragments, which do not run by themselves, are for pages that explain them."""
    assert not blocks(README, "py")
    for block in blocks(README, "python"):
        assert "import " in block.code, f"{block} imports nothing"
