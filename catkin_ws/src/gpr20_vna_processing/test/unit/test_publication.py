"""Every trace and every record of the log is published once, whatever failed before that."""

from __future__ import annotations

import contextlib

import pytest
from annotation_examples import EXAMPLE
from log_examples import marker
from planned_survey import METADATA
from storage_kit import OTHER_SURVEY, Kit, bag_messages
from trace_examples import STARTED_US, SURVEY, make_trace

from gpr20_survey.errors import StorageFailedError
from gpr20_survey.folder.recovery import recover
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.recording.survey_topics import recorded_log

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(6)]


def end(kit: Kit) -> None:
    """End the thread of a storage, whose survey may be spoiled."""
    with contextlib.suppress(StorageFailedError):
        kit.processing.shut_down()


def published(kit: Kit):
    return [trace.index for trace in kit.stored]


@pytest.fixture
def kit(tmp_path):
    kit = Kit(tmp_path / "data", open_recordings)
    yield kit
    end(kit)


@pytest.fixture
def folder(kit):
    """A survey that is open, with three traces."""
    folder = kit.open()
    for trace in TRACES[:3]:
        kit.processing.store(trace)
    return folder


def spoil(folder, name="survey.mcap"):
    """Let the next commit of a recording fail: the trace has a JSON file by then."""
    (folder / name).unlink()


def test_a_trace_is_published_when_its_folder_was_moved_and_is_back(kit, folder, tmp_path):
    spoil(folder)
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    folder.rename(tmp_path / "away")
    # Another survey begins; the storage gives up the first one, which is not there.
    assert kit.processing.interrupt_other(OTHER_SURVEY) == folder.name
    kit.open(OTHER_SURVEY)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    (tmp_path / "away").rename(folder)
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2, 3]


def test_a_trace_that_is_not_stored_any_more_is_not_published(kit, folder, tmp_path):
    spoil(folder)
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    next((folder / "traces").glob("000003_*")).unlink()
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2]


def test_every_record_of_the_log_is_recorded_and_published_when_it_is_durable(kit, tmp_path):
    folder = kit.open(metadata_json=METADATA)
    kit.processing.annotate("", EXAMPLE)
    kit.processing.add_marker("", marker(1))
    kit.processing.add_marker("", marker(1))  # a repeated request says nothing new
    kit.processing.remove_marker(SURVEY, marker(1).marker_id, "Luis")
    kit.processing.report(SURVEY, '{"verdict": "none"}')
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.reopen_survey(SURVEY)
    kit.processing.close_survey(SURVEY, "stopped")
    kinds = ["annotation", "marker", "marker_removed", "report"]
    assert [record.kind for record in map(recorded_log, kit.logged)] == kinds
    added = recover(folder).found.records
    assert [one.kind for one in added] == ["plan", *kinds, "end", "resume", "end"]
    expected = list(added[:-1])  # the end is noted when nothing records any more
    mcap = [recorded_log(one) for one in StoredMcap(folder / "survey.mcap").messages()]
    bag = [recorded_log(one) for one in bag_messages(folder / "survey.bag")]
    assert [one for one in mcap if one] == [one for one in bag if one] == expected


def test_a_record_that_is_not_durable_is_not_published(kit, monkeypatch):
    kit.open(metadata_json=METADATA)

    def refuse(*_arguments):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", refuse)
        with pytest.raises(StorageFailedError):
            kit.processing.add_marker("", marker(1))
    assert kit.logged == []
    kit.processing.add_marker("", marker(2))
    (message,) = kit.logged
    assert recorded_log(message).values["marker_id"] == marker(2).marker_id


def test_a_clock_that_was_set_back_makes_no_trace_be_published_twice(kit):
    kit.open()
    for trace in (TRACES[1], make_trace(5, timestamp_us=STARTED_US + 10**6)):
        kit.processing.store(trace)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [1, 5]
