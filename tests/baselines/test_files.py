"""Files that are whole or not there at all."""

from pathlib import Path

import pytest

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.files import only_writer, read_json, replacing, write_json


def test_a_file_is_replaced_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "numbers.json"
    write_json(path, {"a": 1})

    with replacing(path) as place:
        place.write_text("half")
        assert read_json(path) == {"a": 1}
        place.write_text('{"a": 2}')

    assert read_json(path) == {"a": 2}
    assert list(tmp_path.iterdir()) == [path]


def test_what_stops_the_writing_leaves_the_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "picture.png"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), replacing(path) as place:
        assert place.suffix == ".png"
        place.write_text("half")
        raise KeyboardInterrupt

    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_where_nothing_can_be_written_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="cannot write .*new.json: No such file or directory"):
        write_json(tmp_path / "nowhere" / "new.json", {})

    (tmp_path / "file").touch()
    message = "cannot write .*file: File exists"
    with pytest.raises(ComparisonError, match=message), only_writer(tmp_path / "file"):
        pass


def test_what_is_no_json_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ComparisonError, match="cannot read .*none.json: No such file"):
        read_json(tmp_path / "none.json")

    (tmp_path / "deep.json").write_text('{"a": ' + "[" * 100_000 + "]" * 100_000 + "}")
    with pytest.raises(ComparisonError, match=r"deep.json holds no JSON \(it is nested too deeply"):
        read_json(tmp_path / "deep.json")

    (tmp_path / "list.json").write_text("[1]")
    with pytest.raises(ComparisonError, match="list.json holds a list, no names with values"):
        read_json(tmp_path / "list.json")
