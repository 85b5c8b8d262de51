"""A folder as a ZIP file that is made while it is sent."""

import io
import os
import tracemalloc
import zipfile

import pytest

from gpr20_survey.errors import ProcessingError
from gpr20_survey.files.folder_zip import PIECE_BYTES, FolderChangedError, zip_parts


@pytest.fixture
def folder(tmp_path):
    """A folder with a large file, many small ones and an empty one."""
    folder = tmp_path / "20260921T141320_0f8fad5b"
    (folder / "traces").mkdir(parents=True)
    for number in range(50):
        (folder / "traces" / f"{number}.json").write_bytes(os.urandom(100 * number))
    (folder / "survey.mcap").write_bytes(os.urandom(20 * PIECE_BYTES + 7))
    return folder


def test_it_holds_every_file_as_it_is(folder):
    with zipfile.ZipFile(io.BytesIO(b"".join(zip_parts(folder)))) as archive:
        assert archive.testzip() is None
        content = {one: archive.read(one) for one in archive.namelist()}
        assert {one.compress_type for one in archive.infolist()} == {zipfile.ZIP_STORED}
    files = [one for one in folder.rglob("*") if one.is_file()]
    assert content == {str(one.relative_to(folder.parent)): one.read_bytes() for one in files}


def test_it_comes_in_parts_and_is_never_held_as_a_whole(folder):
    tracemalloc.start()
    sizes = [len(part) for part in zip_parts(folder)]
    _now, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert sum(sizes) > 20 * PIECE_BYTES and max(sizes) < 3 * PIECE_BYTES
    assert most < 8 * PIECE_BYTES


def test_no_zip_file_comes_of_a_folder_that_changes_meanwhile(folder):
    parts, taken = zip_parts(folder), []
    taken.append(next(parts))
    (folder / "traces" / "1.json").write_bytes(b"another")
    with pytest.raises(FolderChangedError):
        taken.extend(parts)
    with pytest.raises(zipfile.BadZipFile):
        zipfile.ZipFile(io.BytesIO(b"".join(taken)))


def test_a_link_in_it_is_not_followed(folder, tmp_path):
    (tmp_path / "secret").write_text("secret")
    (folder / "traces" / "link.json").symlink_to(tmp_path / "secret")
    with pytest.raises(ProcessingError, match="link.json"):
        list(zip_parts(folder))


def test_it_can_be_left_at_any_time(folder):
    parts = zip_parts(folder)
    next(parts)
    parts.close()
    assert list(parts) == []
