"""The README's examples run, and a graph of one's own is short."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parent.parent / "README.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", README.read_text(), re.DOTALL | re.MULTILINE) if README.exists() else []
GRAPHS = [block for block in BLOCKS if "WorldModel(" in block]

pytestmark = pytest.mark.skipif(not README.exists(), reason="there is no README.md")


@pytest.mark.parametrize("block", BLOCKS, ids=[f"block {i}" for i in range(len(BLOCKS))])
def test_every_example_runs(block: str) -> None:
    exec(compile(block, str(README), "exec"), {"__name__": "__main__"})


def test_a_user_s_graph_takes_less_than_30_lines() -> None:
    assert GRAPHS
    for block in GRAPHS:
        assert sum(bool(line.strip()) for line in block.splitlines()) < 30


def test_the_graph_s_paths_are_those_that_it_announces(capsys: pytest.CaptureFixture[str]) -> None:
    """`print(model.paths())  # a → b → c,  …` prints these paths."""
    for block in GRAPHS:
        exec(compile(block, str(README), "exec"), {"__name__": "__main__"})
        printed = capsys.readouterr().out
        announced = re.search(r"print\(model\.paths\(\)\)\s*#(.*)", block)
        assert announced
        for path in announced.group(1).split(","):
            assert path.strip() in printed.splitlines()


DOCUMENTS = [README, *README.parent.glob("docs/*.md"), *README.parent.glob("*.md")]


@pytest.mark.parametrize("document", dict.fromkeys(DOCUMENTS), ids=lambda path: path.name)
def test_documents_are_finished_and_their_links_lead_somewhere(document: Path) -> None:
    text = document.read_text()
    assert not re.search(r"^[A-Z]{4,}$", text, re.MULTILINE), "a placeholder was left"
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", text):
        assert (document.parent / target).exists(), f"{target} is not there"
