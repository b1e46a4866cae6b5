"""What a killed run has left, and files that are not as they should be."""

import multiprocessing
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from _inputs.comparison import POINTS, handmade_rows
from _writer import hold

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.rows_file import append_rows, read_rows
from aicon_baselines.evaluation.run_folder import RunFolder, keep

CONFIG = configure(POINTS)
ROWS = handmade_rows()


@contextmanager
def a_folder(path: Path) -> Iterator[Path]:
    """The episodes of a folder with the rows made by hand."""
    with RunFolder.open(path, CONFIG) as folder:
        folder.append(ROWS)
        yield path / "episodes.csv"


def test_a_second_writer_is_refused_until_the_first_has_ended(tmp_path: Path) -> None:
    with a_folder(tmp_path):
        message = rf"another process is writing into {tmp_path}: wait until it has ended"
        with pytest.raises(ComparisonError, match=message), RunFolder.open(tmp_path, CONFIG):
            pass

    with RunFolder.open(tmp_path, CONFIG) as folder:
        assert folder.rows() == ROWS


def test_a_killed_writer_keeps_nobody_out(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    opened, sender = context.Pipe(duplex=False)
    writer = context.Process(target=hold, args=(tmp_path, CONFIG, sender), daemon=True)
    writer.start()
    # With this end closed, a writer that has died ends the wait with an EOFError.
    sender.close()
    assert opened.poll(60), "the writer has not opened the folder"
    assert opened.recv()

    with pytest.raises(ComparisonError, match="another process"), a_folder(tmp_path):
        pass
    writer.kill()
    writer.join(timeout=60)
    with a_folder(tmp_path):
        pass


def test_rows_of_unfinished_chunks_come_back_once(tmp_path: Path) -> None:
    with RunFolder.open(tmp_path, CONFIG) as folder:
        folder.append(ROWS[:2])
        keep(folder.begin_chunk(), ROWS[1:3])
        keep(folder.begin_chunk(), ROWS[2:4])
        assert folder.count_ended() == 4

    with RunFolder.open(tmp_path, CONFIG) as folder:
        assert sorted(folder.rows()) == ROWS[:4]
    assert {path.name for path in tmp_path.iterdir()} == {".lock", "config.json", "episodes.csv"}


@pytest.mark.parametrize("torn", ["a,usual,0", "\0\0\0\0\n", "a,usual,0\na,usual,1,7,u\n"])
def test_what_is_torn_in_an_unfinished_chunk_is_left_out(tmp_path: Path, torn: str) -> None:
    with RunFolder.open(tmp_path, CONFIG) as folder:
        path = folder.begin_chunk()
        keep(path, ROWS[:2])
        with path.open("a") as file:
            file.write(torn)

    with RunFolder.open(tmp_path, CONFIG) as folder:
        assert folder.rows() == ROWS[:2]


def test_a_worker_that_does_not_see_the_folder_keeps_nothing(tmp_path: Path) -> None:
    keep(tmp_path / "elsewhere" / "chunk.csv", ROWS)
    assert not list(tmp_path.iterdir())


def test_a_row_that_is_there_twice_is_read_once(tmp_path: Path) -> None:
    with a_folder(tmp_path) as path:
        append_rows(path, ROWS)
        assert read_rows(path) == ROWS


def test_two_rows_that_contradict_each_other_are_named(tmp_path: Path) -> None:
    with a_folder(tmp_path) as path:
        append_rows(path, [ROWS[0]._replace(steps=101)])
        message = r"line 7 says something else.*\(a, usual, 0, 0\); without both, it is run again"
        with pytest.raises(ComparisonError, match=message):
            read_rows(path)


def test_a_broken_line_is_named(tmp_path: Path) -> None:
    with a_folder(tmp_path) as path:
        path.write_text(path.read_text().replace("300", "many"))
        with pytest.raises(ComparisonError, match="line 3 is not a row.*its episode is run again"):
            read_rows(path)


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n"])
def test_another_table_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "episodes.csv"
    path.write_text(text)
    with pytest.raises(ComparisonError, match="has the columns.*expected 'policy,condition"):
        read_rows(path)


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "episodes.csv"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(ComparisonError, match=r"cannot read .*episodes.csv: it is no text"):
        read_rows(path)


@pytest.mark.parametrize("name", ["config.json", "episodes.csv"])
def test_a_file_that_is_a_folder_is_a_sentence(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    message = rf"cannot read .*{name}: Is a directory"
    with pytest.raises(ComparisonError, match=message), a_folder(tmp_path):
        pass


@pytest.mark.skipif(os.getuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission_is_a_sentence(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    message = r"cannot write .*runs: Permission denied"
    with pytest.raises(ComparisonError, match=message), a_folder(tmp_path / "runs"):
        pass


def test_a_full_disk_is_a_sentence_and_loses_nothing_that_was_there(tmp_path: Path) -> None:
    with a_folder(tmp_path) as path:
        whole = path.read_bytes()

        # A limit on the size of files stands for the full disk.
        with (
            no_file_larger_than(len(whole) + 20),
            pytest.raises(ComparisonError, match=r"cannot write .*episodes.csv: File too large"),
        ):
            append_rows(path, ROWS)

    with RunFolder.open(tmp_path, CONFIG) as folder:
        assert folder.rows() == ROWS
        assert path.read_bytes() == whole


@contextmanager
def no_file_larger_than(size: int) -> Iterator[None]:
    """Limit what this process may write, in bytes."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
