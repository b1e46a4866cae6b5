"""The documents of the repository, and what stands in them: links, code blocks, commands."""

import re
import shlex
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]

DOCUMENTS = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "baselines/**/*.md")
    for path in ROOT.glob(pattern)
    if not path.is_relative_to(ROOT / "docs" / "images")
)
NAMES = [str(path.relative_to(ROOT)) for path in DOCUMENTS]


class Block(NamedTuple):
    """A fenced block of code.

    Attributes:
        document: Where it stands.
        line: The line of its first row.
        code: Its content.
    """

    document: Path
    line: int
    code: str

    def __str__(self) -> str:
        """``docs/start.md:40``."""
        return f"{self.document.relative_to(ROOT)}:{self.line}"


def blocks(document: Path, language: str) -> list[Block]:
    """The blocks of a language in a document."""
    text = document.read_text()
    found = []
    for match in re.finditer(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        line = text[: match.start(1)].count("\n") + 1
        found.append(Block(document, line, match.group(1)))
    return found


def all_blocks(language: str) -> list[Block]:
    """The blocks of a language in all documents."""
    return [block for document in DOCUMENTS for block in blocks(document, language)]


def headings(document: Path) -> set[str]:
    """The anchors of a document, as GitHub makes them of its headings."""
    without_code = re.sub(r"^```.*?^```", "", document.read_text(), flags=re.DOTALL | re.MULTILINE)
    anchors = set()
    for title in re.findall(r"^#+ (.*)$", without_code, re.MULTILINE):
        words = re.sub(r"[^\w\- ]", "", title.lower())
        anchors.add(words.replace(" ", "-"))
    return anchors


class ShellCommand(NamedTuple):
    """A command of this repository in a document.

    Attributes:
        block: Where it stands.
        program: ``aicon compare`` or ``scripts/study.py``.
        arguments: What follows.
    """

    block: Block
    program: str
    arguments: list[str]

    def __str__(self) -> str:
        """``docs/start.md:40 aicon run``."""
        return f"{self.block} {self.program}"


def shell_commands() -> list[ShellCommand]:
    """The commands `aicon …` and `python scripts/…` of all documents."""
    found = []
    for block in all_blocks("bash"):
        variables: dict[str, str] = {}
        for line in block.code.replace("\\\n", " ").splitlines():
            for name, value in variables.items():
                line = line.replace(f"${name}", value)

            words = shlex.split(line, comments=True)
            if len(words) == 1 and re.match(r"[A-Z]+=", words[0]):
                name, _, variables[name] = words[0].partition("=")
            elif len(words) > 1 and Path(words[0]).name == "aicon":
                found.append(ShellCommand(block, f"aicon {words[1]}", words[2:]))
            elif len(words) > 1 and Path(words[0]).name == "python" and words[1] != "-m":
                found.append(ShellCommand(block, words[1], words[2:]))
    return found
