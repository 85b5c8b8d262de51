"""Going on with a survey that was cut off or stopped."""

from __future__ import annotations

import json
import os

import pytest
from fault_kit import raises_fault
from log_examples import make_former
from mcap.reader import make_reader
from planned_survey import METADATA as PLANNED
from planned_survey import planned_trace
from reopening_kit import (
    FIRST,
    METADATA,
    TRACES,
    data,
    fill,
    finish,
    folder,
    kit,
    messages_in_mcap,
)
from rosbags.rosbag1 import Reader
from storage_kit import OTHER_SURVEY, Kit
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace, read_json

from gpr20_common.message import Fault, verbatim
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recordings import open_recordings
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

__all__ = ["data", "folder", "kit"]


@pytest.mark.parametrize("by_folder", [False, True])
def test_a_survey_that_was_cut_off_goes_on_where_it_was(kit, folder, by_folder):
    reopened = kit.processing.reopen_survey(folder.name if by_folder else SURVEY)
    assert (reopened.survey_id, reopened.folder) == (SURVEY, str(folder))
    assert json.loads(reopened.metadata_json) == json.loads(METADATA)
    assert reopened.report_json == ""
    assert reopened.stored_indices == (0, 1, 2, 3)
    assert reopened.recent[-1].index == 3
    assert_same_numbers(TRACES[3], read_json(sorted((folder / "traces").iterdir())[3]))
    assert read_json(folder / "survey.json")["resumed"] == ["2026-09-21T14:15:00.000000+00:00"]
    finish(kit, folder, reopened)
    # The last trace may not have been published before the cut.
    assert [trace.index for trace in kit.stored] == [3, 4, 5, 6]
    texts = [message.data for message in messages_in_mcap(folder, "/t")]
    assert texts == ["first", *(f"before {index}" for index in range(7))]


@pytest.mark.parametrize("content", [None, b"", b"no bag at all" * 1000])
def test_a_bag_is_not_believed_but_written_again_from_the_mcap(kit, folder, content):
    if content is None:
        (folder / "survey.bag").unlink()
    else:
        (folder / "survey.bag").write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2, 3)
    assert reopened.repairs == ()
    finish(kit, folder, reopened)
    messages = [(channel.topic, message.data) for channel, message in raw_messages(folder)]
    with Reader(str(folder / "survey.bag")) as reader:
        found = [(connection.topic, data) for connection, _, data in reader.messages()]
    assert sorted(found) == sorted(messages)


def raw_messages(folder):
    with open(folder / "survey.mcap", "rb") as stream:
        return [(channel, one) for _, channel, one in make_reader(stream).iter_messages()]


def test_a_bag_that_went_on_can_still_be_repaired_by_stock_tools(kit, folder, tmp_path):
    rosbag = pytest.importorskip("rosbag")  # part of ROS; all else here runs without it
    kit.processing.reopen_survey(SURVEY)
    fill(kit, TRACES[FIRST:])
    path = tmp_path / "cut.bag"
    path.write_bytes((folder / "survey.bag").read_bytes() + b"torn")
    with rosbag.Bag(str(path), "a", allow_unindexed=True) as bag:
        for _ in bag.reindex():
            pass
    with rosbag.Bag(str(path)) as bag:
        found = [message for _, message, _ in bag.read_messages(topics=["/trace"])]
    assert [one.index for one in found] == list(range(7))


def test_a_finished_and_complete_survey_is_refused_and_unchanged(kit, folder):
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with raises_fault("survey.complete", 7, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert kit.processing.state().survey_id == ""


def test_a_finished_survey_with_an_unreadable_trace_may_go_on(kit, folder):
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))
    path = sorted((folder / "traces").iterdir())[2]
    path.write_bytes(path.read_bytes()[:-10])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == tuple(range(7))
    assert "survey.repaired" in {one.fault_code for one in reopened.repairs}
    finish(kit, folder, reopened)


def test_only_surveys_in_the_data_folder_can_be_reopened(kit):
    for name, code in [
        ("", "survey.wrong_name"),
        ("..", "survey.wrong_name"),
        ("../before", "survey.wrong_name"),
        ("/etc", "survey.wrong_name"),
        ("20260921T141320_0f8fad5b/..", "survey.wrong_name"),
        ("20260921T141320_0f8fad5b\n", "survey.wrong_name"),
        (OTHER_SURVEY, "survey.unknown"),
        ("20260921T141320_7c9e6679", "survey.unknown"),
        (SURVEY[:8] + OTHER_SURVEY[8:], "survey.unknown"),
    ]:
        with raises_fault(code, error=SurveyRefusedError):
            print(kit.processing.reopen_survey(name))
    assert kit.processing.state().survey_id == ""


def test_a_link_out_of_the_data_folder_is_no_survey(kit, data, folder, tmp_path):
    folder.rename(tmp_path / folder.name)
    (data / folder.name).symlink_to(tmp_path / folder.name)
    with raises_fault("survey.unknown", error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


def test_reopening_the_open_survey_answers_what_is_stored_by_now(kit, folder):
    for _ in range(3):
        kit.processing.reopen_survey(SURVEY)
        # A repeated request is one resumption.
        assert len(read_json(folder / "survey.json")["resumed"]) == 1
    fill(kit, TRACES[FIRST:6])
    kit.processing.report(SURVEY, '{"verdict": "INCOMPLETE"}')
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == (0, 1, 2, 3, 4, 5)
    assert reopened.recent[-1].index == 5
    assert json.loads(reopened.report_json) == {"verdict": "INCOMPLETE"}
    assert len(read_json(folder / "survey.json")["resumed"]) == 2
    finish(kit, folder, reopened)


def test_the_first_traces_are_answered_beside_the_latest(tmp_path):
    kit = Kit(tmp_path, open_recordings)
    kit.open(metadata_json=METADATA.replace("7", "20"))
    traces = [make_trace(index, timestamp_us=STARTED_US + 10**6 * index) for index in range(14)]
    fill(kit, traces)
    expected = [0, 1, 2, 3, *range(6, 14)]
    assert [one.index for one in kit.processing.reopen_survey(SURVEY).recent] == expected
    kit.processing.shut_down()
    again = Kit(tmp_path, open_recordings)
    assert [one.index for one in again.processing.reopen_survey(SURVEY).recent] == expected
    fill(again, [make_trace(14, timestamp_us=STARTED_US + 10**6 * 20)])
    later = [0, 1, 2, 3, *range(7, 15)]
    assert [one.index for one in again.processing.reopen_survey(SURVEY).recent] == later
    again.processing.shut_down()


def test_a_survey_that_is_half_closed_is_not_resumed(kit, folder, monkeypatch):
    kit.processing.reopen_survey(SURVEY)

    def refuse(_self):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(McapFile, "finish", refuse)
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.close_survey(SURVEY, "stopped")
    with raises_fault("survey.closing", error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    kit.processing.close_survey(SURVEY, "stopped")
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))


@pytest.mark.parametrize(
    "wanted", [{"if_bandwidth_hz": 500.0}, {"averages": 1}, {"output_power": "LOW"}]
)
def test_traces_with_other_settings_than_the_survey_asked_for_are_refused_by_name(tmp_path, wanted):
    described = json.loads(PLANNED)
    described["parameters"].update(wanted)
    kit = Kit(tmp_path, open_recordings)
    kit.open(metadata_json=json.dumps(described))
    kit.processing.store(planned_trace(0, analyzer=AnalyzerSettings(500.0, 1, "LOW")))
    kit.processing.store(planned_trace(1, analyzer=AnalyzerSettings(1000.0, 4, "HIGH")))
    kit.processing.close_survey(SURVEY, "stopped")
    shown = (1, 1000, 4, "HIGH")
    with raises_fault("survey.traces_not_planned", *shown, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)
    kit.processing.shut_down()


@pytest.mark.parametrize("ending", ["cut off", "failed"])
def test_a_survey_of_the_version_before_the_fault_codes_is_resumed(kit, folder, ending):
    if ending == "failed":
        kit.processing.reopen_survey(SURVEY)
        reason = verbatim("lost").with_fault(Fault("axis.lost_zero"))
        kit.processing.close_survey(SURVEY, "failed", reason)
    make_former(folder, without=("fault_code", "reason_message"))
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.repairs == ()
    values = read_json(folder / "survey.json")
    assert (values["outcome"], values["fault_code"], values["reason_message"]) == (None, "", None)
    finish(kit, folder, reopened)


def test_a_disk_that_refuses_while_reopening_leaves_a_survey_to_reopen(kit, folder, monkeypatch):
    calls = []
    real_fsync = os.fsync
    path = sorted((folder / "traces").iterdir())[1]
    path.unlink()
    (folder / "survey.json").write_bytes(b"")
    content = (folder / "survey.mcap").read_bytes()
    (folder / "survey.mcap").write_bytes(content[:-40] + bytes(40))

    def fail_at(number):
        def fsync(descriptor):
            calls.append(descriptor)
            if len(calls) == number:
                raise OSError(28, "No space left on device")
            real_fsync(descriptor)

        return fsync

    failures = 0
    for number in range(1, 200):
        calls.clear()
        with monkeypatch.context() as patch:
            patch.setattr(os, "fsync", fail_at(number))
            try:
                reopened = kit.processing.reopen_survey(SURVEY)
                break
            except StorageFailedError as error:
                assert error.message.fault_code == "disk.full"
                failures += 1
    assert failures > 8
    assert path.is_file()
    assert reopened.stored_indices == (0, 1, 2, 3)
    finish(kit, folder, reopened)
