"""Going on with a survey that was cut off or stopped, or that its control left open.

Every trace and every record of the log is published once, whatever failed before that.
"""

from __future__ import annotations

import json
import os
import shutil

import pytest
from annotation_examples import EXAMPLE
from fault_kit import raises_fault
from log_examples import NOW, marker
from mcap.reader import make_reader
from reopening_kit import (
    REPORT,
    TRACES,
    assert_whole,
    fill,
    messages_in_mcap,
    trace_file,
    tree,
)
from storage_kit import OTHER_SURVEY, bag_messages
from trace_examples import METADATA, SURVEY, make_trace, planned_trace, read_json

from gpr20_common.message import verbatim
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.folder.recovery import read_description, recover
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.survey_topics import recorded_log
from gpr20_survey.trace.sweep import AnalyzerSettings

STORED = (0, 1, 2, 3, 4, 5)


@pytest.fixture
def folder(copies):
    """A survey that was cut off after six traces."""
    return copies("cut off")


@pytest.fixture
def data(folder):
    return folder.parent


@pytest.fixture
def opened(kits):
    """A storage with a survey that is open, with three traces, and its folder."""
    kit = kits()
    folder = kit.open(metadata_json=METADATA)
    fill(kit, TRACES[:3])
    return kit, folder


def finish(kit, folder, reopened) -> None:
    """Store what is missing, end the survey, and check that it is whole."""
    fill(kit, [trace for trace in TRACES if trace.index not in reopened.stored_indices])
    assert kit.processing.close_survey(SURVEY, "finished").stored_traces == len(TRACES)
    assert_whole(folder, TRACES)


def full_disk(*_arguments):
    raise OSError(28, "No space left on device")


def published(kit):
    return [trace.index for trace in kit.stored]


@pytest.mark.parametrize("by_folder", [False, True])
def test_a_survey_that_was_cut_off_goes_on_where_it_was(kit, folder, by_folder):
    reopened = kit.processing.reopen_survey(folder.name if by_folder else SURVEY)
    assert (reopened.survey_id, reopened.path) == (SURVEY, str(folder))
    metadata = json.loads(reopened.metadata_json)
    assert metadata == {**json.loads(METADATA), "annotation": EXAMPLE.values()}
    assert json.loads(reopened.report_json) == REPORT
    assert (reopened.stored_indices, reopened.recent[-1].index) == (STORED, 5)
    resumed = ["2026-09-21T14:15:00.000000+00:00"]
    assert read_json(folder / "survey.json")["resumed"] == resumed
    finish(kit, folder, reopened)
    # The last trace may not have been published before the cut.
    assert published(kit) == [5, 6, 7, 8]
    found = [message.data for message in messages_in_mcap(folder, "/t")]
    assert found == [f"before {index}" for index in range(9)]
    with open(folder / "survey.mcap", "rb") as stream:
        messages = [(one.topic, raw.data) for _, one, raw in make_reader(stream).iter_messages()]
    in_bag = [(one.topic, one.data) for one in bag_messages(folder / "survey.bag")]
    assert sorted(in_bag) == sorted(messages)


def test_reopening_the_open_survey_answers_what_is_stored_by_now(kit, folder):
    for _ in range(3):
        kit.processing.reopen_survey(SURVEY)
        # A repeated request is one resumption.
        assert len(read_description(folder)["resumed"]) == 1
    fill(kit, TRACES[6:8])
    kit.report(SURVEY, '{"verdict": "INCOMPLETE"}')
    reopened = kit.processing.reopen_survey(SURVEY)
    assert (reopened.stored_indices, reopened.recent[-1].index) == ((*STORED, 6, 7), 7)
    assert json.loads(reopened.report_json) == {"verdict": "INCOMPLETE"}
    assert len(read_description(folder)["resumed"]) == 2
    finish(kit, folder, reopened)


def test_the_first_traces_are_answered_beside_those_of_the_largest_indices(kits):
    """Whatever the clock said: it was set back before the last one."""
    traces = [make_trace(index, timestamp_us=10**15 * 2 - 10**6 * index) for index in range(14)]
    first = kits()
    first.open()
    fill(first, traces)
    expected = [0, 1, 2, 3, *range(6, 14)]
    assert [one.index for one in first.processing.reopen_survey(SURVEY).recent] == expected
    assert published(first) == [*range(14)]
    first.processing.shut_down()
    again = kits()
    assert [one.index for one in again.processing.reopen_survey(SURVEY).recent] == expected
    assert published(again) == [13]
    fill(again, [make_trace(14)])
    later = [0, 1, 2, 3, *range(7, 15)]
    assert [one.index for one in again.processing.reopen_survey(SURVEY).recent] == later


def test_a_survey_that_is_half_closed_takes_no_traces_and_is_not_resumed(kit, folder, monkeypatch):
    kit.processing.reopen_survey(SURVEY)
    with monkeypatch.context() as patch:
        patch.setattr(McapFile, "finish", full_disk)
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.close_survey(SURVEY, "stopped")
    for action in (
        lambda: kit.processing.reopen_survey(SURVEY),
        lambda: kit.processing.store(TRACES[6]),
    ):
        with raises_fault("survey.closing"):
            action()
    kit.processing.close_survey(SURVEY, "stopped")
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))


def test_traces_with_other_settings_than_the_survey_asked_for_are_refused_by_name(kits):
    described = json.loads(METADATA)
    described["parameters"].update(if_bandwidth_hz=500.0)
    kit = kits()
    kit.open(metadata_json=json.dumps(described))
    kit.processing.store(planned_trace(0, analyzer=AnalyzerSettings(500.0, 1, "LOW")))
    kit.processing.store(planned_trace(1, analyzer=AnalyzerSettings(1000.0, 4, "HIGH")))
    kit.processing.close_survey(SURVEY, "stopped")
    shown = (1, 1000, 4, "HIGH")
    with raises_fault("survey.log_lost", *shown, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


def test_a_close_that_a_dead_process_did_not_answer_is_answered_by_the_next_one(kits):
    first, reason = kits(), verbatim("complete")
    folder = first.open(metadata_json=METADATA)
    fill(first, TRACES)
    closed = first.processing.close_survey(SURVEY, "finished", reason)
    first.processing.shut_down()
    second, content = kits(), tree(folder)
    assert second.processing.close_survey(SURVEY, "finished", reason) == closed
    assert tree(folder) == content
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        second.processing.close_survey(SURVEY, "stopped")  # it ended otherwise
    (folder / "manifest.json").unlink()  # as if the close was cut off
    with raises_fault("survey.none_open", error=SurveyRefusedError):
        second.processing.close_survey(SURVEY, "finished", reason)


def test_a_survey_that_another_process_writes_is_not_reopened(opened, kits):
    """As by a second robot with the same data folder and its own ROS master."""
    (writer, folder), other = opened, kits()
    before = tree(folder)
    with raises_fault("survey.locked", os.getpid(), error=SurveyRefusedError):
        other.processing.reopen_survey(SURVEY)
    with raises_fault("survey.locked", os.getpid(), error=SurveyRefusedError):
        other.add_marker(SURVEY, marker(3))
    assert tree(folder) == before
    assert other.processing.state().survey_id == ""
    fill(writer, TRACES[3:4])
    writer.processing.close_survey(SURVEY, "interrupted")
    # One that cannot be reopened can be reopened by another process later.
    whole = (folder / "survey.mcap").read_bytes()
    (folder / "survey.mcap").unlink()
    (folder / "survey.mcap").mkdir()
    with pytest.raises((SurveyRefusedError, StorageFailedError)):
        writer.processing.reopen_survey(SURVEY)
    (folder / "survey.mcap").rmdir()
    (folder / "survey.mcap").write_bytes(whole)
    assert other.processing.reopen_survey(SURVEY).stored_indices == (0, 1, 2, 3)
    with raises_fault("survey.locked", error=SurveyRefusedError):
        writer.processing.reopen_survey(SURVEY)


def replace_mcap(folder, away):
    shutil.copy(str(folder / "survey.mcap"), str(away))
    os.replace(str(away), str(folder / "survey.mcap"))


def replace_folder(folder, away):
    """As from another disk."""
    folder.rename(away)
    shutil.copytree(str(away), str(folder))


@pytest.mark.parametrize(
    "harm",
    [
        lambda folder, _away: (folder / "survey.mcap").unlink(),
        lambda folder, _away: shutil.rmtree(str(folder / "traces")),
        lambda folder, away: folder.rename(away),
        replace_mcap,
        replace_folder,
    ],
    ids=["mcap", "traces", "folder", "other mcap", "other folder"],
)
def test_no_trace_is_acknowledged_into_what_is_gone_and_the_survey_goes_on(opened, tmp_path, harm):
    (kit, folder), away = opened, tmp_path / "away"
    harm(folder, away)
    with raises_fault("storage.folder_moved", error=StorageFailedError):
        kit.processing.store(TRACES[3])
    if not folder.exists():
        with raises_fault("survey.unknown", error=SurveyRefusedError):
            kit.processing.reopen_survey(folder.name)
        away.rename(folder)
    elif (folder / "traces").exists():
        with raises_fault("storage.folder_moved", error=StorageFailedError):
            kit.processing.close_survey(SURVEY, "finished")
        assert not (folder / "manifest.json").exists()
    # What the control does when the survey is resumed: reopen, store again, close.
    reopened = kit.processing.reopen_survey(folder.name)
    assert reopened.stored_indices[:3] == (0, 1, 2)
    finish(kit, folder, reopened)
    assert published(kit) == [*range(9)]


@pytest.mark.parametrize("is_there", [True, False])
def test_a_trace_whose_recording_failed_is_published_if_it_is_there(opened, tmp_path, is_there):
    kit, folder = opened
    (folder / "survey.mcap").unlink()  # the trace has a JSON file by then
    with pytest.raises(StorageFailedError):
        kit.processing.store(TRACES[3])
    if not is_there:
        trace_file(folder, 3).unlink()
    folder.rename(tmp_path / "away")
    # Another survey begins; the storage gives up the first one, which is not there.
    assert kit.processing.interrupt_other(OTHER_SURVEY) == folder.name
    kit.open(OTHER_SURVEY)
    kit.processing.close_survey(OTHER_SURVEY, "stopped")
    (tmp_path / "away").rename(folder)
    kit.processing.reopen_survey(SURVEY)
    assert published(kit) == [0, 1, 2, 3][: 3 + is_there]


def test_every_record_of_the_log_is_recorded_and_published_when_it_is_durable(kits, monkeypatch):
    kit = kits()
    folder = kit.open(metadata_json=METADATA)
    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full_disk)
        with pytest.raises(StorageFailedError):
            kit.add_marker("", marker(2))
    assert kit.logged == []
    kit.annotate("", EXAMPLE)
    kit.add_marker("", marker(1))
    kit.add_marker("", marker(1))  # a repeated request says nothing new
    for _ in range(2):
        kit.processing.add_fact("", "pause", json.dumps({"time": NOW}))
    kit.remove_marker(SURVEY, marker(1).marker_id, "Luis")
    kit.report(SURVEY, '{"verdict": "none"}')
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.reopen_survey(SURVEY)
    kit.processing.close_survey(SURVEY, "stopped")
    kinds = ["annotation", "marker", "pause", "marker_removed", "report"]
    assert [record.kind for record in map(recorded_log, kit.logged)] == kinds
    added = recover(folder).found.records
    assert [one.kind for one in added] == ["plan", *kinds, "end", "resume", "end"]
    expected = list(added[:-1])  # the end is noted when nothing records any more
    mcap = [recorded_log(one) for one in StoredMcap(folder / "survey.mcap").messages()]
    assert [one for one in mcap if one] == expected
