"""What was fitted before is read again, if it is whole and nobody else's."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy", reason="hulls need the extra [robots]")
pytest.importorskip("trimesh", reason="meshes need the extra [robots]")

from aicon_torch.parts import kept_fits
from aicon_torch.parts.capsule_fit import Segment, around_surfaces
from aicon_torch.parts.kept_fits import fitted_once

TETRAHEDRON = np.array(
    [
        [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.1, 0.0]],
        [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.0, 0.1]],
        [[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
        [[0.3, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
    ]
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(kept_fits, "_FITTED", {})
    return tmp_path / "cache/aicon_torch"


@pytest.fixture
def kept(folder: Path) -> Path:
    """The file of what was fitted."""
    fitted_once([TETRAHEDRON], 2)
    (file,) = folder.iterdir()
    return file


def in_another_process(monkeypatch: pytest.MonkeyPatch, **given: Any) -> list[Segment]:
    """The capsules where this process has fitted none."""
    monkeypatch.setattr(kept_fits, "_FITTED", {})
    return fitted_once(**{"surfaces": [TETRAHEDRON], "count": 2} | given)


def rows(segments: list[Segment]) -> list[Any]:
    """All numbers of some capsules."""
    return [[*start, *end, radius] for start, end, radius in segments]


def forbidden(*given: Any) -> None:
    """No fit."""
    raise AssertionError("it is fitted again")


def test_another_process_reads_the_same_numbers(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_fits, "around_surfaces", forbidden)
    found = in_another_process(monkeypatch)
    assert rows(found) == rows(around_surfaces([TETRAHEDRON], 2))


def test_other_surfaces_counts_and_code_are_fitted_anew(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_another_process(monkeypatch, surfaces=[2.0 * TETRAHEDRON])
    in_another_process(monkeypatch, surfaces=[TETRAHEDRON[:2], TETRAHEDRON[2:]])
    in_another_process(monkeypatch, count=3)
    monkeypatch.setattr(kept_fits, "_code", lambda: "another version")
    in_another_process(monkeypatch)
    assert len(list(kept.parent.iterdir())) == 5


def digit_changed(file: Path) -> None:
    content = bytearray(file.read_bytes())
    place = content.rindex(b".") + 1
    content[place] = ord("7") if content[place] != ord("7") else ord("8")
    file.write_bytes(bytes(content))


@pytest.mark.parametrize(
    "spoil",
    [
        digit_changed,
        lambda file: file.write_bytes(file.read_bytes()[:-2]),
        lambda file: file.write_bytes(b""),
        lambda file: file.chmod(0o666),  # others may have written it
    ],
)
def test_what_is_not_whole_or_may_be_anothers_is_fitted_again(
    spoil: Callable[[Path], None], kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = kept.read_bytes()
    spoil(kept)
    assert rows(in_another_process(monkeypatch)) == rows(around_surfaces([TETRAHEDRON], 2))
    assert kept.read_bytes() == whole
    assert kept.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("lacks", ["a folder", "its sources"])
def test_where_nothing_can_be_kept_it_is_fitted(
    lacks: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if lacks == "a folder":
        folder.parent.write_text("")
    else:
        monkeypatch.setattr(kept_fits, "_code", lambda: None)
    assert rows(in_another_process(monkeypatch)) == rows(around_surfaces([TETRAHEDRON], 2))
    assert not folder.exists() or not list(folder.iterdir())
