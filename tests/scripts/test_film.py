"""Films: where they are saved is refused before anything is filmed."""

import argparse
from pathlib import Path

import numpy as np
import pytest

from film import add_film, beside_each_other, save_film


def film_of(*words: str) -> Path:
    parser = argparse.ArgumentParser()
    add_film(parser, "runs/some.webp")
    path: Path = parser.parse_args(words).out
    return path


@pytest.mark.parametrize("name", ["film.gif", "film", "film.none"])
def test_another_ending_is_refused(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        film_of("--out", name)
    assert "a film ends in .webp or .mp4, not " in capsys.readouterr().err


def test_films_beside_each_other_end_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert film_of() == Path("runs/some.webp")
    films = [[np.full((2, 2, 3), 50 * number, np.uint8) for number in range(n)] for n in (1, 3)]
    frames = list(beside_each_other(films, stays=2))
    assert [frame[0, :, 0].tolist() for frame in frames[1:]] == [
        [0, 0, 50, 50],
        *[[0, 0, 100, 100]] * 3,
    ]

    save_film(frames, tmp_path / "films" / "some.webp", interval=0.1)
    assert (tmp_path / "films" / "some.webp").is_file()
    assert "saved" in capsys.readouterr().out
