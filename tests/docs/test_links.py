"""Documents are finished, and what they name is there: links, headings, files, make's targets."""

import re
from pathlib import Path

from _documents import DOCUMENTS, ROOT, headings
from _inputs import for_each

NAMED = {str(path.relative_to(ROOT)): path for path in DOCUMENTS}
PRESENT = {name: path for name, path in NAMED.items() if path.name != "CHANGELOG.md"}

every_document = for_each("document", NAMED)
every_present_document = for_each("document", PRESENT)

# Files are named from the root, or from where the code of the library lies.
FOLDERS = (ROOT, ROOT / "aicon_torch", ROOT / "baselines" / "aicon_baselines")
TOP_LEVEL = "aicon_torch|envs|baselines|examples|scripts|tests|docs|control|graph|resolution"
FILE = re.compile(rf"`((?:{TOP_LEVEL})/[\w./-]*\w\.(?:py|md|png|sh|toml))`")


@every_document
def test_links_lead_somewhere(document: Path) -> None:
    for target, anchor in re.findall(r"\]\((?!https?:)([^)#]*)#?([^)]*)\)", document.read_text()):
        path = (document.parent / target).resolve() if target else document
        assert path.exists(), f"{target} is not there"

        if anchor:
            assert anchor in headings(path), f"{target} has no heading #{anchor}"


@every_present_document
def test_files_that_are_named_are_there(document: Path) -> None:
    for name in FILE.findall(document.read_text()):
        if "NAME" in name:
            continue  # stands for any task
        assert any((folder / name).exists() for folder in FOLDERS), f"{name} is not there"


@every_document
def test_no_placeholder_was_left(document: Path) -> None:
    assert not re.search(r"^[A-Z]{4,}$|\bTODO\b|\bXXX\b", document.read_text(), re.MULTILINE)


@every_present_document
def test_targets_of_make_are_there(document: Path) -> None:
    targets = set(re.findall(r"^([a-z_-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    commands = re.findall(r"(?:^|`)make ([a-z][a-z_ -]*[a-z])", document.read_text(), re.MULTILINE)
    for command in commands:
        assert set(command.split()) <= targets, f"make {command}"


# Pages of the site that a reader of the repository has no use for: they include what is there.
ONLY_SITE = (
    "index.md",
    "examples.md",
    "security.md",
    "ppo_nav2d.md",
    "ppo_pusht.md",
    "student.md",
    "lerobot_arms.md",
    "api/",
)


def test_every_page_is_in_the_table_of_contents() -> None:
    contents = (ROOT / "docs" / "README.md").read_text()
    for page in (ROOT / "docs").rglob("*.md"):
        name = str(page.relative_to(ROOT / "docs"))
        if name != "README.md" and not name.startswith(ONLY_SITE):
            assert f"({page.relative_to(ROOT / 'docs')})" in contents, f"{page} is not listed"
