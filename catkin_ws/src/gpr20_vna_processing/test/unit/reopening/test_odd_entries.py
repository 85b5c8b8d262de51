"""What is in a survey's folder without being its file keeps no survey from going on or ending."""

from __future__ import annotations

import os
import shutil
import socket

import pytest
from fault_kit import raises_fault
from storage_kit import Kit
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_analysis.read.manifest_check import Seal, check_manifest
from gpr20_survey.errors import StorageFailedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder.recovery import recover
from gpr20_survey.recording.recordings import open_recordings

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(4)]


@pytest.fixture
def folder(tmp_path):
    """A survey of which three traces are stored and that was stopped."""
    kit = Kit(tmp_path / "data", open_recordings)
    folder = kit.open()
    for trace in TRACES[:3]:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    return folder


@pytest.fixture
def kit(tmp_path, folder):
    kit = Kit(tmp_path / "data", open_recordings)
    yield kit
    kit.processing.shut_down()


def go_on_and_close(kit):
    """Reopen the survey, store its last trace and close it; return what was repaired."""
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2)
    kit.processing.store(TRACES[3])
    kit.processing.close_survey(SURVEY, "finished")
    return [(one.values.get("file"), one.fault_code) for one in reopened.repairs]


def put_folder(path):
    path.mkdir()
    (path / "inside").write_text("somebody else's")


def put_link(path):
    path.symlink_to("/nowhere")


def put_socket(path):
    with socket.socket(socket.AF_UNIX) as unix:
        here = os.getcwd()
        os.chdir(str(path.parent))  # the name of a socket may not be long
        try:
            unix.bind(path.name)
        finally:
            os.chdir(here)


def put_pipe(path):
    os.mkfifo(str(path))


def checked(folder):
    return check_manifest(folder, SURVEY, recover(folder).found.records)


def differences(folder):
    found = checked(folder)
    assert found.seal is Seal.VALID
    return found.differences


KINDS = [put_folder, put_link, put_socket, put_pipe]


@pytest.mark.parametrize("put", KINDS)
def test_what_is_named_like_a_trace_file_is_put_aside_and_the_survey_ends(kit, folder, put):
    trace = next((folder / "traces").glob("000001_*.json"))
    trace.unlink()
    put(trace)
    put(folder / "traces" / "000009_X0001.00_Y0001.00_Z+000.00.json")
    repairs = go_on_and_close(kit)
    assert (trace.name, "survey.repaired") in repairs
    aside = sorted(one.name for one in (folder / "damaged").iterdir())
    assert aside == [trace.name, "000009_X0001.00_Y0001.00_Z+000.00.json"]
    assert len(list((folder / "traces").iterdir())) == 4
    assert differences(folder) == []


def test_a_folder_put_aside_takes_the_place_of_nothing(tmp_path):
    aside = tmp_path / "damaged"
    kept = []
    for number in range(3):
        (tmp_path / "trace.json").mkdir()
        (tmp_path / "trace.json" / str(number)).touch()
        kept.append(durable_files.move_aside(tmp_path / "trace.json", aside))
    assert [one.name for one in kept] == ["trace.json", "trace.json.1", "trace.json.2"]
    assert [next(one.iterdir()).name for one in kept] == ["0", "1", "2"]


def test_another_users_file_of_which_no_second_name_may_be_made_is_moved(kit, folder, monkeypatch):
    def refuse(*_names, **_options):
        raise PermissionError(1, "Operation not permitted")

    torn = next((folder / "traces").glob("000001_*.json"))
    torn.write_bytes(b"")
    with monkeypatch.context() as patched:
        patched.setattr(os, "link", refuse)
        target = durable_files.move_aside(torn, folder / "damaged")
    assert target.read_bytes() == b"" and not torn.exists()
    go_on_and_close(kit)


@pytest.mark.parametrize("place", [".", "traces"])
def test_a_folder_named_like_a_file_that_was_never_finished_is_left_alone(kit, folder, place):
    put_folder(folder / place / ".survey.json.0123abcd.tmp")
    go_on_and_close(kit)
    assert (folder / place / ".survey.json.0123abcd.tmp" / "inside").is_file()


@pytest.mark.parametrize("put", [put_folder, put_link])
def test_what_stands_in_the_place_of_the_manifest_is_no_obstacle(kit, folder, put):
    (folder / "manifest.json").unlink()
    put(folder / "manifest.json")
    go_on_and_close(kit)
    assert differences(folder) == []


def test_a_name_that_is_no_text_is_told_in_text(kit, folder):
    with open(os.fsencode(str(folder / "traces")) + b"/\xff\xfe.json", "wb") as stream:
        stream.write(b"x")
    (printed,) = go_on_and_close(kit)
    assert printed == (r"\xff\xfe.json", "survey.repaired")
    assert differences(folder) == []


@pytest.mark.parametrize("put", [put_link, put_pipe])
def test_a_strange_thing_beside_the_data_does_not_keep_a_survey_open_but_is_told(kit, folder, put):
    put(folder / "notes.txt")
    go_on_and_close(kit)
    (printed,) = differences(folder)
    assert "notes.txt" in str(printed)
    (folder / "notes.txt").unlink()
    (folder / "notes.txt").touch()
    (printed,) = differences(folder)
    assert str(printed).startswith("notes.txt has no SHA-256 in the manifest")


@pytest.mark.parametrize("put", [put_folder, put_pipe])
def test_a_check_does_not_wait_for_what_stands_in_the_place_of_the_manifest(folder, put):
    (folder / "manifest.json").unlink()
    put(folder / "manifest.json")
    assert checked(folder).damage.fault_code == "storage.not_a_file"


def test_a_strange_thing_among_the_data_keeps_a_survey_open_until_it_is_moved(kit, folder):
    kit.processing.reopen_survey(SURVEY)
    strange = folder / "traces" / "notes.txt"
    put_link(strange)
    with raises_fault("storage.not_a_file", "notes.txt", error=StorageFailedError):
        kit.processing.close_survey(SURVEY, "stopped")
    strange.unlink()
    kit.processing.close_survey(SURVEY, "stopped")


@pytest.mark.parametrize(
    ("part", "code"),
    [
        ("survey.bag", "storage.not_a_file"),
        ("survey.mcap", "storage.not_a_file"),
        ("traces", "storage.file_exists"),
        ("damaged", "storage.file_exists"),
    ],
)
def test_what_is_in_the_way_is_named(kit, folder, part, code):
    if part in ("traces", "damaged"):
        next((folder / "traces").glob("000001_*.json")).write_bytes(b"")
        shutil.rmtree(str(folder / part), ignore_errors=True)
        (folder / part).write_text("somebody else's")
    else:
        (folder / part).unlink()
        (folder / part).mkdir()
    with raises_fault(code, part, error=StorageFailedError):
        kit.processing.reopen_survey(SURVEY)
