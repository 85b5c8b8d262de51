from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from rosbags.rosbag1 import Reader
from storage_kit import (
    OTHER_SURVEY,
    STARTED_US,
    SURVEY,
    TYPES,
    Kit,
    assert_same_numbers,
    make_trace,
    read_json,
    text_message,
)

from gpr20_vna_processing.errors import StorageFailedError, SurveyRefusedError
from gpr20_vna_processing.low.mcap_file import McapFile
from gpr20_vna_processing.low.stored_bag import StoredBag
from gpr20_vna_processing.low.stored_mcap import StoredMcap
from gpr20_vna_processing.mid.recordings import open_recordings

TRACES = [make_trace(index, timestamp_us=STARTED_US + 10**6 * (index + 2)) for index in range(7)]
FIRST = 4  # traces before the survey is cut off
METADATA = '{"planned_traces": 7, "simulated": true, "parameters": {"x_points": 3}}'


def fill(kit: Kit, traces) -> None:
    for trace in traces:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)


@pytest.fixture
def data(tmp_path):
    """A data folder with a survey that was cut off after four traces."""
    kit = Kit(tmp_path / "before", open_recordings)
    folder = kit.open(metadata_json=METADATA)
    kit.processing.record(text_message("/t", "first"))
    fill(kit, TRACES[:FIRST])
    # What a kill leaves is what is on the disk now.
    shutil.copytree(str(tmp_path / "before"), str(tmp_path / "data"))
    kit.processing.shut_down()
    assert read_json(tmp_path / "data" / folder.name / "survey.json")["ended"] is None
    return tmp_path / "data"


@pytest.fixture
def folder(data):
    (folder,) = data.iterdir()
    return folder


@pytest.fixture
def kit(data):
    kit = Kit(data, open_recordings)
    yield kit
    kit.processing.shut_down()


def traces_in_bag(folder):
    with Reader(str(folder / "survey.bag")) as reader:
        return [
            TYPES.deserialize_ros1(data, "gpr20_msgs/msg/Trace")
            for connection, _, data in reader.messages()
            if connection.topic == "/trace"
        ]


def messages_in_mcap(folder, topic="/trace"):
    with open(folder / "survey.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [one.decoded_message for one in reader.iter_decoded_messages(topics=[topic])]


def assert_whole(folder, traces) -> None:
    """Compare what the stock readers find in a survey that ended with what was stored."""
    files = sorted((folder / "traces").iterdir())
    for found in (map(read_json, files), traces_in_bag(folder), messages_in_mcap(folder)):
        by_index = sorted(
            found, key=lambda one: one["index"] if isinstance(one, dict) else one.index
        )
        assert len(by_index) == len(traces)
        for trace, values in zip(traces, by_index):
            assert_same_numbers(trace, values)


def finish(kit: Kit, folder: Path, reopened, traces=TRACES) -> None:
    """Store what is missing, end the survey, and check that it is whole."""
    stored = set(reopened.stored_indices)
    fill(kit, [trace for trace in traces if trace.index not in stored])
    assert kit.processing.close_survey(SURVEY, "finished", "").stored_traces == len(traces)
    assert_whole(folder, traces)


@pytest.mark.parametrize("by_folder", [False, True])
def test_a_survey_that_was_cut_off_goes_on_where_it_was(kit, folder, by_folder):
    reopened = kit.processing.reopen_survey(folder.name if by_folder else SURVEY)
    assert (reopened.survey_id, reopened.folder) == (SURVEY, folder)
    assert json.loads(reopened.metadata_json) == json.loads(METADATA)
    assert reopened.report_json == ""
    assert reopened.stored_indices == [0, 1, 2, 3]
    assert reopened.last.index == 3
    assert_same_numbers(TRACES[3], read_json(sorted((folder / "traces").iterdir())[3]))
    assert read_json(folder / "survey.json")["resumed"] == ["2026-09-21T14:15:00.000000+00:00"]
    finish(kit, folder, reopened)
    assert [trace.index for trace in kit.stored] == [4, 5, 6]
    texts = [message.data for message in messages_in_mcap(folder, "/t")]
    assert texts == ["first", *(f"before {index}" for index in range(7))]


def test_a_survey_that_was_stopped_goes_on_again_and_again(data, folder):
    for count in (4, 5, 6, 7):
        kit = Kit(data, open_recordings)
        reopened = kit.processing.reopen_survey(SURVEY)
        assert len(reopened.stored_indices) == min(count, 7)
        assert not (folder / "manifest.json").exists()
        assert read_json(folder / "survey.json")["ended"] is None
        kit.processing.store(TRACES[min(count, 6)])
        kit.processing.close_survey(SURVEY, "stopped", "for now")
        kit.processing.shut_down()
        assert_whole(folder, TRACES[: min(count + 1, 7)])
    assert len(read_json(folder / "survey.json")["resumed"]) == 4


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
    with pytest.raises(SurveyRefusedError, match="finished and complete with 7 traces"):
        kit.processing.reopen_survey(SURVEY)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert kit.processing.state().survey_id == ""


def test_a_finished_survey_with_an_unreadable_trace_may_go_on(kit, folder):
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))
    path = sorted((folder / "traces").iterdir())[2]
    path.write_bytes(path.read_bytes()[:-10])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == list(range(7))
    assert "wrote" in " ".join(reopened.repairs)
    finish(kit, folder, reopened)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "must be a survey's id"),
        ("..", "must be a survey's id"),
        ("../before", "must be a survey's id"),
        ("/etc", "must be a survey's id"),
        ("20260921T141320_0f8fad5b/..", "must be a survey's id"),
        ("20260921T141320_0f8fad5b\n", "must be a survey's id"),
        (OTHER_SURVEY, "there is no survey"),
        ("20260921T141320_7c9e6679", "there is no survey"),
        (SURVEY[:8] + OTHER_SURVEY[8:], "holds survey"),
    ],
)
def test_only_surveys_in_the_data_folder_can_be_reopened(kit, name, reason):
    with pytest.raises(SurveyRefusedError, match=reason):
        kit.processing.reopen_survey(name)
    assert kit.processing.state().survey_id == ""


def test_a_link_out_of_the_data_folder_is_no_survey(kit, data, folder, tmp_path):
    folder.rename(tmp_path / folder.name)
    (data / folder.name).symlink_to(tmp_path / folder.name)
    with pytest.raises(SurveyRefusedError, match="there is no survey"):
        kit.processing.reopen_survey(SURVEY)


def test_a_second_survey_is_not_reopened_beside_an_open_one(kit):
    kit.open(OTHER_SURVEY)
    with pytest.raises(SurveyRefusedError, match="is open"):
        kit.processing.reopen_survey(SURVEY)


def test_reopening_the_open_survey_answers_what_is_stored_by_now(kit, folder):
    kit.processing.reopen_survey(SURVEY)
    fill(kit, TRACES[FIRST:6])
    kit.processing.report(SURVEY, '{"verdict": "INCOMPLETE"}')
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 1, 2, 3, 4, 5]
    assert reopened.last.index == 5
    assert json.loads(reopened.report_json) == {"verdict": "INCOMPLETE"}
    assert len(read_json(folder / "survey.json")["resumed"]) == 2
    finish(kit, folder, reopened)


def test_a_trace_that_a_recording_refused_is_completed_before_the_answer(kit, folder, monkeypatch):
    kit.processing.reopen_survey(SURVEY)

    def refuse(_self):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(McapFile, "commit", refuse)
        for ask in (lambda: kit.processing.store(TRACES[4]),
                    lambda: kit.processing.reopen_survey(SURVEY)):  # fmt: skip
            with pytest.raises(StorageFailedError, match="make space"):
                ask()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 1, 2, 3, 4]
    finish(kit, folder, reopened)


def test_a_survey_that_is_half_closed_is_not_resumed(kit, folder, monkeypatch):
    kit.processing.reopen_survey(SURVEY)

    def refuse(_self):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(McapFile, "finish", refuse)
        with pytest.raises(StorageFailedError, match="make space"):
            kit.processing.close_survey(SURVEY, "stopped", "")
    with pytest.raises(SurveyRefusedError, match="call close_survey again"):
        kit.processing.reopen_survey(SURVEY)
    kit.processing.close_survey(SURVEY, "stopped", "")
    finish(kit, folder, kit.processing.reopen_survey(SURVEY))


def test_torn_temporary_files_are_removed_and_never_data(kit, folder):
    torn = [folder / "traces" / ".000004_X0050.00.json.0a.tmp", folder / ".survey.json.0a.tmp"]
    for path in torn:
        path.write_text("{")
    reopened = kit.processing.reopen_survey(SURVEY)
    assert "removed 2 files" in " ".join(reopened.repairs)
    assert not any(path.exists() for path in torn)
    assert reopened.stored_indices == [0, 1, 2, 3]


def test_a_trace_that_is_in_json_alone_is_put_into_the_recordings(data, folder, tmp_path):
    source = Kit(tmp_path / "other", open_recordings)
    source.open(metadata_json=METADATA)
    path = source.processing.store(TRACES[5])
    shutil.copy(str(path), str(folder / "traces"))
    source.processing.shut_down()
    kit = Kit(data, open_recordings)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 1, 2, 3, 5]
    assert reopened.last.index == 5
    finish(kit, folder, reopened)
    kit.processing.shut_down()


def test_a_trace_that_is_in_the_recordings_alone_gets_its_json(kit, folder):
    path = sorted((folder / "traces").iterdir())[1]
    content = path.read_bytes()
    path.unlink()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 1, 2, 3]
    assert path.read_bytes() == content
    finish(kit, folder, reopened)


def test_a_recording_that_is_gone_is_made_again(kit, folder):
    (folder / "survey.bag").unlink()
    reopened = kit.processing.reopen_survey(SURVEY)
    assert "added 4 traces to survey.bag" in reopened.repairs
    finish(kit, folder, reopened)


def test_an_unreadable_trace_of_which_there_is_no_copy_counts_as_not_stored(kit, folder):
    for name in ("survey.bag", "survey.mcap"):
        (folder / name).unlink()
    path = sorted((folder / "traces").iterdir())[1]
    path.write_bytes(path.read_bytes()[:-5])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 2, 3]
    assert (folder / "damaged" / path.name).exists()
    assert any("damaged" in repair for repair in reopened.repairs)
    finish(kit, folder, reopened)


@pytest.mark.parametrize("name", ["survey.bag", "survey.mcap"])
def test_a_recording_damaged_in_its_middle_is_rebuilt_and_the_old_one_kept(kit, folder, name):
    content = bytearray((folder / name).read_bytes())
    stored = (StoredBag if name == "survey.bag" else lambda path: StoredMcap(path, None))(
        folder / name
    )
    assert len(list(stored.messages())) == 4 + 4 + 2
    place = len(content) // 2
    if name == "survey.bag":
        place = content.index(TRACES[2].s21_real.tobytes()) + 3
    content[place] ^= 0x20
    (folder / name).write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert f"rebuilt {name}" in " ".join(reopened.repairs)
    assert (folder / "damaged" / name).read_bytes() == content
    assert reopened.stored_indices == [0, 1, 2, 3]
    finish(kit, folder, reopened)


@pytest.mark.parametrize(
    "text", [b"type=gpr20_msgs/Trace", b"float64[] s21_real", b"md5sum=", b"topic=/trace"]
)
def test_a_bag_whose_types_are_damaged_is_rebuilt_with_the_right_ones(kit, folder, text):
    content = bytearray((folder / "survey.bag").read_bytes())
    content[content.rindex(text) + len(text) - (text[-1:] != b"=")] ^= 0x01
    (folder / "survey.bag").write_bytes(content)
    reopened = kit.processing.reopen_survey(SURVEY)
    assert "rebuilt survey.bag" in " ".join(reopened.repairs)
    finish(kit, folder, reopened)


def test_a_digit_changed_in_a_json_file_is_found_by_the_recordings(kit, folder):
    path = sorted((folder / "traces").iterdir())[2]
    good = path.read_bytes()
    place = good.index(b"s21_real") + 20
    assert good[place : place + 1].isdigit()
    path.write_bytes(good[:place] + b"%d" % ((good[place] - 47) % 10) + good[place + 1 :])
    reopened = kit.processing.reopen_survey(SURVEY)
    assert path.read_bytes() == good
    assert reopened.stored_indices == [0, 1, 2, 3]
    finish(kit, folder, reopened)


def test_a_trace_on_which_no_two_sources_agree_is_not_called_stored(kit, folder):
    (folder / "survey.mcap").unlink()
    path = sorted((folder / "traces").iterdir())[2]
    values = read_json(path)
    values["s21_real"][0] += 1.0
    path.write_text(json.dumps(values) + "\n")
    reopened = kit.processing.reopen_survey(SURVEY)
    assert reopened.stored_indices == [0, 1, 3]
    finish(kit, folder, reopened)


def test_a_disk_that_refuses_while_reopening_leaves_a_survey_to_reopen(kit, folder, monkeypatch):
    calls = []
    real_fsync = os.fsync
    path = sorted((folder / "traces").iterdir())[1]
    content = path.read_bytes()
    path.unlink()
    (folder / "survey.bag").write_bytes(b"no bag at all" * 1000)

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
                assert "make space" in str(error)
                failures += 1
    assert failures > 10
    assert path.read_bytes() == content
    assert reopened.stored_indices == [0, 1, 2, 3]
    finish(kit, folder, reopened)


def test_a_report_is_kept_and_survives_everything(kit, folder):
    reopened = kit.processing.reopen_survey(SURVEY)
    kit.processing.report(SURVEY, '{"verdict": "old"}')
    kit.processing.report(SURVEY, '{"verdict": "new", "coverage": "mm-"}')
    expected = {"verdict": "new", "coverage": "mm-"}
    assert read_json(folder / "survey.json")["report"] == expected
    finish(kit, folder, reopened)
    survey = read_json(folder / "survey.json")
    assert (survey["report"], survey["outcome"]) == (expected, "finished")


@pytest.mark.parametrize(
    ("survey_id", "text", "reason"),
    [
        (SURVEY, "[]", "report_json is a list"),
        (SURVEY, "{", "report_json is not strict JSON"),
        (SURVEY, '{"a": NaN}', "NaN"),
        (SURVEY, '{"a": "' + "x" * (8 << 20) + '"}', "at most 8388608"),
        (OTHER_SURVEY, "{}", "is not open"),
        ("..", "{}", "UUID"),
    ],
)
def test_a_wrong_report_is_refused_and_the_former_kept(kit, folder, survey_id, text, reason):
    kit.processing.reopen_survey(SURVEY)
    kit.processing.report(SURVEY, '{"verdict": "old"}')
    with pytest.raises(SurveyRefusedError, match=reason):
        kit.processing.report(survey_id, text)
    assert read_json(folder / "survey.json")["report"] == {"verdict": "old"}


def test_a_report_without_a_survey_is_refused(kit):
    with pytest.raises(SurveyRefusedError, match="no survey is open"):
        kit.processing.report(SURVEY, "{}")
