"""What somebody else put into a survey's folder: nothing hangs, fills memory or leads outside.

What is not a survey's file keeps no survey from going on or ending, and is named.
"""

import contextlib
import os
import re
import resource
import shutil
import struct
from pathlib import Path

import pytest
from fault_kit import raises_fault
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from log_examples import NOW, marker
from reopening_kit import TRACES, trace_file, tree
from run_seed import draws
from storage_kit import Kit, with_bag
from trace_examples import SURVEY

from gpr20_analysis.read.checks import is_sealed, manifest_differences
from gpr20_survey.errors import ProcessingError, StorageFailedError, SurveyRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.folder.log_record import Kind, LogRecord
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.survey_folder import LOG_FILES
from gpr20_vna_processing.mid.stored_surveys import StoredSurveys

MEMORY_BYTES = 100 << 20
HUGE_BYTES = 160 << 20
FOREIGN = "somebody else's"
# Where what counts ends in a recording of which the index was written: the end of the data.
DATA_END = struct.pack("<BQ", 0x0F, 4)
ONE = st.none() | st.booleans() | st.integers() | st.text(max_size=20)
JSON = ONE | st.lists(ONE, max_size=4) | st.dictionaries(st.text(max_size=8), ONE)
KEYS = st.sampled_from(
    ["survey_id", "started", "ended", "outcome", "parameters", "planned_traces", "resumed"]
    + ["report", "simulated", "stored_traces", "format", "axes", "settings", "instrument"]
)


@pytest.fixture
def folder(copies):
    """A survey that was stopped."""
    return with_bag(copies("stopped"))


@pytest.fixture
def data(folder):
    return folder.parent


def path_of(folder, part):
    return trace_file(folder, 1) if part == "trace" else folder / part


def go_on_and_close(kit):
    """Reopen the survey, finish it, and return what was repaired."""
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == tuple(range(6))
    kit.finish(TRACES, reopened.stored_indices)
    return [(one.values.get("file"), one.fault_code) for one in reopened.repairs]


def refusal_of(action):
    """Return what an action refuses with, or None; one that hangs is ended with the test."""
    try:
        action()
    except ProcessingError as error:
        return error
    return None


def put_folder(path):
    path.mkdir()
    (path / "inside").write_text(FOREIGN)


def put_link(path):
    path.symlink_to("/nowhere")


def put_pipe(path):
    os.mkfifo(str(path))


def put_file(path):
    path.write_text(FOREIGN)


def differences(folder):
    recovered = recover(folder, asking_manifest=True)
    assert is_sealed(recovered)
    return manifest_differences(folder, recovered)


@pytest.mark.parametrize(
    "part", ["survey.json", "log.jsonl", "log.copy.jsonl", "traces", "survey.bag", "damaged"]
)
def test_a_survey_part_of_which_lies_elsewhere_is_not_gone_on_with(kit, folder, tmp_path, part):
    outside = tmp_path / "outside"
    if part == "damaged":
        outside.mkdir()
    else:
        (folder / part).rename(outside)
    (folder / part).symlink_to(outside)
    # These would be cleared away or moved, were the link followed.
    if outside.is_dir():
        (outside / ".torn.json.0123abcd.tmp").write_text(FOREIGN)
        (outside / "000001_wrong.json").write_text(FOREIGN)
    before = tree(tmp_path)
    with raises_fault("file.damaged", part, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    "part", ["survey.json", "log.jsonl", "log.copy.jsonl", "survey.mcap", "survey.bag", "trace"]
)
def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(kit, folder, part):
    path = path_of(folder, part)
    path.unlink()
    put_pipe(path)
    assert refusal_of(lambda: StoredSurveys(folder.parent).traces(SURVEY, range(3))) is None
    assert refusal_of(lambda: kit.add_marker(SURVEY, marker(3))) is None
    refused = refusal_of(lambda: kit.processing.reopen_survey(SURVEY))
    if part == "survey.mcap":
        assert refused.message.fault_code == "file.damaged"
    else:
        assert refused is None  # another file holds the same
        assert path.is_file() or part == "survey.bag"  # made when the survey ends
    assert refusal_of(lambda: StoredSurveys(folder.parent).list("", 10)) is None


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


@pytest.mark.parametrize("part", ["log.jsonl", "log.copy.jsonl", "trace"])
def test_a_huge_file_does_not_fill_the_memory(kit, folder, part):
    os.truncate(str(path_of(folder, part)), HUGE_BYTES)  # without taking the space
    with little_memory():
        refusal_of(lambda: StoredSurveys(folder.parent).list("", 10))
        refusal_of(lambda: StoredSurveys(folder.parent).traces(SURVEY, range(10)))
        refusal_of(lambda: kit.processing.reopen_survey(SURVEY))


def test_a_record_that_says_it_is_huge_does_not_fill_the_memory(kit, folder):
    with (folder / "survey.mcap").open("r+b") as file:
        # In the place of the index, which is behind all that counts.
        file.seek(file.read().rindex(DATA_END))
        file.write(struct.pack("<BQ", 0x0C, HUGE_BYTES))
        file.truncate(2 * HUGE_BYTES)
    with little_memory():
        refusal_of(lambda: StoredSurveys(folder.parent).traces(SURVEY, range(3)))
        refused = refusal_of(lambda: kit.processing.reopen_survey(SURVEY))
    # A file that is mostly a hole is not read; the JSON files hold the traces.
    assert refused.message.fault_code == "file.damaged"
    (folder / "survey.mcap").unlink()
    assert kit.processing.reopen_survey(SURVEY).stored_indices == tuple(range(6))


@settings(max_examples=draws(5), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.dictionaries(KEYS, JSON, min_size=1, max_size=4))
def test_no_description_writes_outside_its_folder_or_ends_the_storage(copies, description):
    folder = copies("stopped")
    data, top = folder.parent, folder.parent.parent
    kit = Kit(data)
    values = {**recover(folder).found.records[0].values, **description}
    plan = LogRecord.after(None, Kind.PLAN, values, NOW)
    for name in LOG_FILES:
        (folder / name).write_bytes(plan.line())
    try:
        refusal_of(lambda: kit.processing.reopen_survey(SURVEY))
        refusal_of(lambda: StoredSurveys(data).list("", 10))
        refusal_of(lambda: StoredSurveys(data).survey(SURVEY))
        refusal_of(lambda: StoredSurveys(data).traces(SURVEY, range(10)))
        assert (list(data.iterdir()), list(top.iterdir())) == ([folder], [data])
        assert trace_file(folder, 0).is_file()
    finally:
        kit.processing.shut_down()
        shutil.rmtree(str(top))


@pytest.mark.parametrize("put", [put_folder, put_link, put_pipe])
def test_what_is_named_like_a_trace_file_is_put_aside_and_the_survey_ends(kit, folder, put):
    trace, more = trace_file(folder, 1), "000009_X0001.00_Y0001.00_Z+000.00.json"
    trace.unlink()
    put(trace)
    put(folder / "traces" / more)
    assert (trace.name, "survey.damaged") in go_on_and_close(kit)
    aside = sorted(one.name for one in (folder / "damaged").iterdir())
    assert aside == [trace.name, more]
    assert len(list((folder / "traces").iterdir())) == len(TRACES)
    assert not differences(folder)


def test_a_folder_put_aside_takes_the_place_of_nothing(tmp_path):
    aside = tmp_path / "damaged"
    kept = []
    for number in range(3):
        (tmp_path / "trace.json").mkdir()
        (tmp_path / "trace.json" / str(number)).touch()
        kept.append(durable_files.move_aside(tmp_path / "trace.json", aside))
    assert [one.name for one in kept] == ["trace.json", "trace.json.1", "trace.json.2"]
    assert [next(one.iterdir()).name for one in kept] == ["0", "1", "2"]


def test_another_users_file_of_which_no_second_name_may_be_made_is_moved(folder, monkeypatch):
    def refuse(*_names, **_options):
        raise PermissionError(1, "Operation not permitted")

    torn = trace_file(folder, 1)
    torn.write_bytes(b"")
    monkeypatch.setattr(os, "link", refuse)
    target = durable_files.move_aside(torn, folder / "damaged")
    assert target.read_bytes() == b"" and not torn.exists()


def test_foreign_things_that_are_no_obstacle_are_left_alone_or_told(kit, folder):
    never_finished = [folder / place / ".survey.json.0123abcd.tmp" for place in (".", "traces")]
    for path in never_finished:
        put_folder(path)
    with open(os.fsencode(str(folder / "traces")) + b"/\xff\xfe.json", "wb") as stream:
        stream.write(b"x")
    put_link(folder / "link.txt")
    put_pipe(folder / "pipe.txt")
    assert (r"\xff\xfe.json", "survey.damaged") in go_on_and_close(kit)
    assert all((path / "inside").is_file() for path in never_finished)
    assert sorted(one.values["file"] for one in differences(folder)) == [
        "link.txt",
        "pipe.txt",
    ]


@pytest.mark.parametrize(
    ("part", "put", "code"),
    [
        ("survey.bag", put_folder, "file.damaged"),
        ("traces", put_file, "storage.file_exists"),
        ("damaged", put_file, "storage.file_exists"),
    ],
)
def test_what_is_in_the_way_is_named(kit, folder, part, put, code):
    trace_file(folder, 1).write_bytes(b"")
    if (folder / part).is_dir():
        shutil.rmtree(str(folder / part))
    elif part != "damaged":
        (folder / part).unlink()
    put(folder / part)
    with raises_fault(code, part, error=StorageFailedError):
        kit.processing.reopen_survey(SURVEY)
