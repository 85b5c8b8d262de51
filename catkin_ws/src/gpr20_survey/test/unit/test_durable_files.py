"""Files that are on the disk before a call returns, or are not there; a folder as a ZIP file."""

import errno
import io
import json
import os
import subprocess
import sys
import zipfile

import pytest
from case_kit import each_case

from gpr20_survey.errors import ProcessingError
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import PIECE_BYTES
from gpr20_survey.recording.mcap_writer import McapFile, RecordedMessage
from gpr20_web.mid.surveys_page import zip_parts

# Prints the size of each part of a folder, and the most memory that was held meanwhile.
MEASURE = """
import json, pathlib, sys, tracemalloc
from gpr20_web.mid.surveys_page import zip_parts
tracemalloc.start()
sizes = [len(part) for part in zip_parts(pathlib.Path(sys.argv[1]))]
print(json.dumps([sizes, tracemalloc.get_traced_memory()[1]]))
"""


def full_disk(*_arguments):
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_new_file_never_overwrites_another(tmp_path):
    path = tmp_path / "a.json"
    path.write_bytes(b"first")
    with pytest.raises(FileExistsError):
        durable_files.write_new_file(path, b"second")
    durable_files.write_new_file(path, b"first")  # the same again is no error
    assert path.read_bytes() == b"first"
    assert os.listdir(tmp_path) == ["a.json"]


@each_case("write", [durable_files.write_new_file, durable_files.replace_file])
def test_a_full_disk_leaves_no_part_of_a_file_and_the_former_one(tmp_path, monkeypatch, write):
    path = tmp_path / write.__name__ / "a.json"
    path.parent.mkdir()
    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(OSError, match="No space"):
        write(path, b"content")
    assert os.listdir(path.parent) == []
    path.write_bytes(b"former")
    with pytest.raises(OSError):
        write(path, b"content")
    assert path.read_bytes() == b"former"


def test_a_file_and_its_name_are_on_the_disk_before_the_call_returns(tmp_path, monkeypatch):
    synced = []
    seen = []
    real_fsync = os.fsync

    def fsync(descriptor):
        synced.append(os.readlink(f"/proc/self/fd/{descriptor}"))
        seen.append(list(tmp_path.glob("*.json")))
        real_fsync(descriptor)

    monkeypatch.setattr(os, "fsync", fsync)
    durable_files.write_new_file(tmp_path / "a.json", b"content")
    content, folder = synced
    assert content.startswith(str(tmp_path / ".a.json."))
    assert folder == str(tmp_path)
    # Until its content is durable nothing has the name of a trace.
    assert seen == [[], [tmp_path / "a.json"]]


@each_case("make", [durable_files.make_new_folder, McapFile])
def test_the_name_of_a_new_folder_or_recording_is_durable(tmp_path, monkeypatch, make):
    synced = []
    monkeypatch.setattr(
        os, "fsync", lambda descriptor: synced.append(os.readlink(f"/proc/self/fd/{descriptor}"))
    )
    make(tmp_path / make.__name__)
    assert synced == [str(tmp_path)]


def test_a_failed_commit_is_repeated_whole(tmp_path, monkeypatch):
    first, second, third = (
        RecordedMessage("/t", "a/T", 32 * "0", "", data, 1) for data in (b"abc", b"defghi", b"jk")
    )
    (tmp_path / "g").mkdir()
    file, other = McapFile(tmp_path / "f"), McapFile(tmp_path / "g" / "f")
    file.write(first)
    assert (tmp_path / "f").read_bytes() == b""
    file.commit()
    file.write(second)
    real_pwrite, before = os.pwrite, os.stat(tmp_path / "f").st_size

    def half_then_full(descriptor, data, offset):
        if offset > before:
            full_disk()
        return real_pwrite(descriptor, data[:2], offset)

    with monkeypatch.context() as patch:
        patch.setattr(os, "pwrite", half_then_full)
        with pytest.raises(OSError, match="No space"):
            file.commit()
    assert os.stat(tmp_path / "f").st_size == before + 2
    assert file.collected_bytes > 2
    for one in (first, second, third):
        other.write(one)
        other.commit()
    file.commit()
    file.write(third)
    file.commit()
    assert file.collected_bytes == 0
    assert (tmp_path / "f").read_bytes() == (tmp_path / "g" / "f").read_bytes()
    file.finish()
    with pytest.raises(FileExistsError):
        McapFile(tmp_path / "f")


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
    # In a process of its own: the memory of threads that other tests left would be counted, too.
    printed = subprocess.check_output([sys.executable, "-c", MEASURE, str(folder)])
    sizes, most = json.loads(printed)
    assert sum(sizes) > 20 * PIECE_BYTES and max(sizes) < 3 * PIECE_BYTES
    assert most < 8 * PIECE_BYTES


def test_no_zip_file_comes_of_a_folder_that_changes_meanwhile(folder):
    parts, taken = zip_parts(folder), []
    taken.append(next(parts))
    (folder / "traces" / "1.json").write_bytes(b"another")
    with pytest.raises(ProcessingError):
        taken.extend(parts)
    with pytest.raises(zipfile.BadZipFile):
        zipfile.ZipFile(io.BytesIO(b"".join(taken)))


def test_a_link_in_it_is_not_followed(folder, tmp_path):
    (tmp_path / "secret").write_text("secret")
    (folder / "traces" / "link.json").symlink_to(tmp_path / "secret")
    with pytest.raises(ProcessingError, match="link.json"):
        list(zip_parts(folder))
