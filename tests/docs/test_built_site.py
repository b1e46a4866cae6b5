"""The site as it is built: nothing comes from elsewhere, and nothing is cut."""

import re
from pathlib import Path

import pytest

import aicon_torch

pytestmark = pytest.mark.slow


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        loaded = re.findall(
            r'<(?:script|link|img|iframe)[^>]*(?:src|href)="(.*?)"', page.read_text()
        )
        assert not [address for address in loaded if re.match(r"(https?:)?//", address)], page


def test_flowcharts_and_formulas_are_pictures(site: Path) -> None:
    graphs, concepts = (site / name for name in ("graphs.html", "concepts.html"))
    assert '<div class="flowchart"><svg' in graphs.read_text()
    assert "flowchart LR" not in graphs.read_text()
    assert '<div class="formula"><svg' in concepts.read_text()
    assert "MathJax" not in concepts.read_text()


def test_the_pages_to_play_with_are_in_it(site: Path) -> None:
    links = re.findall(r'href="(try/.*?)"', (site / "try.html").read_text())
    assert len(links) == 4
    for link in links:
        assert 'id="data"' in (site / link).read_text()


def test_the_names_of_the_library_are_links_beside_whole_sentences(site: Path) -> None:
    page = (site / "api" / "index.html").read_text()
    for name in aicon_torch.__all__:
        assert re.search(
            rf'<a class="reference internal" href="[a-z]+.html#[\w.]*\.{name}"', page
        ), name
    assert not re.search(r"\b(Eq|Eqs|Sect)\.\s*</p>", page)


def test_the_foot_of_a_page_says_whose_it_is(site: Path) -> None:
    foot = re.search(r"Copyright &#169; (.*)", (site / "index.html").read_text())
    assert foot and re.match(r"\d{4}, the aicon-torch", foot.group(1))
