"""What somebody else put into a survey's folder: nothing hangs, fills memory or leads outside."""

from __future__ import annotations

import contextlib
import json
import os
import re
import resource
import shutil
import struct
import threading
from pathlib import Path

import pytest
from fault_kit import raises_fault
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_examples import make_former, marker
from storage_kit import Kit
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import ProcessingError, SurveyRefusedError
from gpr20_survey.recording.bag_writer import EMPTY_CHUNK
from gpr20_survey.recording.recordings import open_recordings
from gpr20_vna_processing.mid.survey_archive import SurveyArchive

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(3)]
LIMIT_S = 30.0
MEMORY_BYTES = 100 << 20
HUGE_BYTES = 160 << 20
# Where what counts ends in a recording of which the index was written.
RECORDING_ENDS = {
    "survey.mcap": lambda content: content.rindex(struct.pack("<BQ", 0x0F, 4)),  # end of data
    "survey.bag": lambda content: content.rindex(EMPTY_CHUNK),
}

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=12,
)
KEYS = st.sampled_from(
    ["survey_id", "started", "ended", "outcome", "parameters", "planned_traces", "resumed"]
    + ["report", "simulated", "stored_traces", "format", "axes", "settings", "instrument"]
)


@pytest.fixture
def data(tmp_path):
    return tmp_path / "data"


@pytest.fixture
def folder(data):
    """A survey of three traces that was stopped."""
    kit = Kit(data, open_recordings)
    folder = kit.open(metadata_json=json.dumps({"parameters": {"x_points": 3}}))
    for trace in TRACES:
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    return folder


@pytest.fixture
def kit(data, folder):
    kit = Kit(data, open_recordings)
    yield kit
    kit.processing.shut_down()


def in_time(action):
    """Return what an action refuses with, or None; fail if it does not come back."""
    ended = []

    def run():
        try:
            action()
            ended.append(None)
        except ProcessingError as error:
            ended.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(LIMIT_S)
    assert ended, "it did not come back, or failed otherwise"
    return ended[0]


def tree(folder):
    """Return the content of a folder, links as links."""
    return {
        str(path.relative_to(folder)): os.readlink(path) if path.is_symlink() else path.read_bytes()
        for path in folder.rglob("*")
        if path.is_symlink() or path.is_file()
    }


@pytest.mark.parametrize("part", ["survey.json", "log.jsonl", "traces", "survey.bag", "damaged"])
def test_a_survey_part_of_which_lies_elsewhere_is_not_gone_on_with(kit, folder, tmp_path, part):
    outside = tmp_path / "outside"
    if part == "damaged":
        outside.mkdir()
    else:
        (folder / part).rename(outside)
    (folder / part).symlink_to(outside)
    # These would be cleared away or moved, were the link followed.
    if outside.is_dir():
        (outside / ".torn.json.0123abcd.tmp").write_text("somebody else's")
        (outside / "000001_wrong.json").write_text("somebody else's")
    before = tree(tmp_path)
    with raises_fault("storage.not_a_file", part, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    assert tree(tmp_path) == before


@pytest.mark.parametrize("part", ["survey.json", "log.jsonl", "survey.mcap", "survey.bag"])
def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(kit, data, folder, part):
    (folder / part).unlink()
    os.mkfifo(str(folder / part))
    assert in_time(lambda: SurveyArchive(data).traces(SURVEY, range(3))) is None
    refused = in_time(lambda: kit.processing.reopen_survey(SURVEY))
    if part == "survey.mcap":
        assert refused.message.fault_code == "storage.not_a_file"
    else:
        assert refused is None  # another file holds the same
        assert (folder / part).is_file()
    assert in_time(lambda: SurveyArchive(data).list("", 10)) is None


@pytest.mark.parametrize("part", ["survey.json", "log.jsonl", "manifest.json"])
def test_a_pipe_in_the_place_of_a_file_is_not_waited_for_by_an_annotation(kit, folder, part):
    (folder / part).unlink()
    os.mkfifo(str(folder / part))
    refused = in_time(lambda: kit.processing.add_marker(SURVEY, marker(1)))
    assert (refused is None) is (part != "manifest.json")


def test_a_pipe_among_the_traces_is_put_aside_and_the_trace_written_again(kit, data, folder):
    trace = next((folder / "traces").glob("000001_*.json"))
    trace.unlink()
    os.mkfifo(str(trace))
    assert in_time(lambda: SurveyArchive(data).traces(SURVEY, range(10))) is None
    assert in_time(lambda: kit.processing.reopen_survey(SURVEY)) is None
    assert trace.is_file()
    assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2)


@contextlib.contextmanager
def little_memory():
    """Let this process take a bounded amount more; beyond it there is a MemoryError."""
    status = Path("/proc/self/status").read_text()
    (now_kib,) = re.findall(r"^VmData:\s+(\d+) kB", status, re.MULTILINE)
    limits = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (int(now_kib) * 1024 + MEMORY_BYTES, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, limits)


@pytest.mark.parametrize("part", ["survey.json", "log.jsonl", "trace"])
def test_a_huge_file_does_not_fill_the_memory(kit, data, folder, part):
    path = next((folder / "traces").iterdir()) if part == "trace" else folder / part
    os.truncate(str(path), HUGE_BYTES)  # without taking the space
    with little_memory():
        in_time(lambda: SurveyArchive(data).list("", 10))
        in_time(lambda: SurveyArchive(data).traces(SURVEY, range(10)))
        in_time(lambda: kit.processing.reopen_survey(SURVEY))


@pytest.mark.parametrize(
    ("part", "record"),
    [
        ("survey.mcap", struct.pack("<BQ", 0x0C, HUGE_BYTES)),
        ("survey.bag", struct.pack("<I", HUGE_BYTES)),
        ("survey.bag", struct.pack("<I", 0) + struct.pack("<I", HUGE_BYTES)),
    ],
)
def test_a_record_that_says_it_is_huge_does_not_fill_the_memory(kit, folder, part, record):
    with (folder / part).open("r+b") as file:
        # In the place of the index, which is behind all that counts.
        file.seek(RECORDING_ENDS[part](file.read()))
        file.write(record)
        file.truncate(2 * HUGE_BYTES)
    with little_memory():
        in_time(lambda: SurveyArchive(folder.parent).traces(SURVEY, range(3)))
        refused = in_time(lambda: kit.processing.reopen_survey(SURVEY))
    if part == "survey.mcap":
        # A file that is mostly a hole is not read; the JSON files hold the traces.
        assert refused.message.fault_code == "storage.not_a_file"
        (folder / part).unlink()
    else:
        assert refused is None
    assert kit.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2)


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.dictionaries(KEYS, JSON, min_size=1, max_size=4))
def test_no_description_writes_outside_its_folder_or_ends_the_storage(
    tmp_path_factory, folder, description
):
    top = tmp_path_factory.mktemp("described")
    shutil.copytree(str(folder.parent), str(top / "data"))
    folder = top / "data" / folder.name
    kit = Kit(top / "data", open_recordings)
    # Of a survey of this version the log shows that it was changed.
    values = make_former(folder)
    (folder / "survey.json").write_text(json.dumps({**values, **description}))
    try:
        in_time(lambda: kit.processing.reopen_survey(SURVEY))
        in_time(lambda: SurveyArchive(top / "data").list("", 10))
        in_time(lambda: SurveyArchive(top / "data").survey(SURVEY))
        in_time(lambda: SurveyArchive(top / "data").traces(SURVEY, range(10)))
        assert list((top / "data").iterdir()) == [folder]
        assert list(top.iterdir()) == [top / "data"]
        assert list((folder / "traces").glob("000000_*.json"))
    finally:
        kit.processing.shut_down()
        shutil.rmtree(str(top))
