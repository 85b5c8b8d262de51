import errno
import json
import os

import numpy as np
import pytest
from fault_kit import raises_fault
from storage_kit import OTHER_SURVEY, Kit, text_message
from trace_examples import STARTED_US, SURVEY, assert_same_numbers, make_trace, read_json
from wait_kit import wait_until

from gpr20_common.message import Fault, Message, in_a_row, received_message, verbatim
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError, TraceRefusedError
from gpr20_survey.faults import OTHER_DATA_FOLDER
from gpr20_survey.folder.recovery import recover
from gpr20_vna_processing.mid.new_survey import describe
from gpr20_vna_processing.mid.storage_thread import LARGEST_LATCHED_BYTES

LOST_ZERO = Fault("axis.lost_zero", Message("Home the axis."), can_continue=False)
DISK_FULL = OSError(errno.ENOSPC, "No space left on device")


class MemoryRecording:
    """A recording whose disk can be full."""

    def __init__(self):
        self.collected, self.durable = [], []
        self.error, self.finished = None, False

    @property
    def collected_bytes(self):
        return sum(len(message.data) for message in self.collected)

    def write(self, message):
        self.collected.append(message)

    write_alone = write

    def commit(self):
        if self.error is not None:
            raise self.error
        self.durable += self.collected
        self.collected = []

    def finish(self):
        self.commit()
        self.finished = True

    def texts(self, topic):
        # Behind the length of the text.
        return [one.data[4:].decode() for one in self.durable if one.topic == topic]


@pytest.fixture
def memory():
    return MemoryRecording()


@pytest.fixture
def kit(tmp_path, memory):
    kit = Kit(tmp_path / "data", lambda *_: memory)
    yield kit
    memory.error = None
    kit.processing.shut_down()


def trace_files(folder):
    return sorted(os.listdir(folder / "traces"))


def traces_in(memory):
    return [message for message in memory.durable if message.topic == "/trace"]


def test_a_survey_has_its_folder_and_says_so_once(kit, memory):
    folder = kit.open(metadata_json='{"parameters": {"x_points": 3}}')
    assert folder.name == "20260921T141320_0f8fad5b"
    survey = read_json(folder / "survey.json")
    (plan,) = recover(folder).found.records
    assert plan.values == survey
    assert survey == {
        "format": "gpr20-survey/1",
        "survey_id": SURVEY,
        "started": "2026-09-21T14:13:20.123456+00:00",
        "ended": None,
        "outcome": None,
        "reason": "",
        "reason_message": None,
        "fault_code": "",
        "stored_traces": 0,
        "software_revision": "1.2.3",
        "parameters": {"x_points": 3},
    }
    kit.processing.store(make_trace(0))
    assert kit.open(metadata_json='{"parameters": {"x_points": 3}}') == folder
    assert [json.loads(one) for one in kit.opened] == [survey]
    assert memory.texts("/survey_metadata") == kit.opened
    with raises_fault("robot.in_use", error=SurveyRefusedError):
        kit.open(metadata_json='{"other": 1}')


def test_a_stored_trace_is_in_json_and_recording_before_the_answer(kit, memory):
    folder = kit.open()
    traces = [make_trace(index) for index in range(3)]
    for count, trace in enumerate(traces, 1):
        path = kit.processing.store(trace)
        assert_same_numbers(trace, read_json(path))
        assert len(traces_in(memory)) == count
    assert len(trace_files(folder)) == 3
    assert [one.fingerprint() for one in kit.stored] == [one.fingerprint() for one in traces]


def test_a_trace_that_contradicts_a_stored_one_is_refused(kit, memory):
    folder = kit.open()
    path = kit.processing.store(make_trace(0))
    content = path.read_bytes()
    for other, *expected in [
        (make_trace(0, x_coord_mm=50.0000001), "survey.damaged", 0),
        (make_trace(0, sample_id="another"), "survey.damaged", "another"),
        (make_trace(1, sample_id="sample-0"), "survey.damaged", "sample-0", 0, 1),
        (make_trace(1, survey_id=OTHER_SURVEY), "robot.in_use", SURVEY, OTHER_SURVEY),
    ]:
        with raises_fault(*expected, error=TraceRefusedError):
            print(kit.processing.store(other))
    assert path.read_bytes() == content
    assert (len(trace_files(folder)), len(traces_in(memory)), len(kit.stored)) == (1, 1, 1)


def test_a_foreign_file_in_the_place_of_a_trace_is_left_alone(kit, memory):
    folder = kit.open()
    path = folder / "traces" / "000000_X0050.00_Y0012.35_Z+090.00.json"
    assert kit.processing.store(make_trace(1)).name.endswith(path.name[6:])
    path.write_text("precious")
    with raises_fault("storage.file_exists", error=StorageFailedError):
        kit.processing.store(make_trace(0))
    assert path.read_text() == "precious"
    assert len(traces_in(memory)) == 1


def test_other_topics_are_dropped_not_kept_while_the_disk_is_full(kit, memory):
    kit.open()
    memory.error = DISK_FULL
    for number in range(6):
        kit.processing.record(text_message("/t", "x" * 500_000))
        wait_until(lambda: kit.processing.state().queues.messages == 0)
        kit.processing.record(text_message("/t", str(number)))
    wait_until(lambda: kit.processing.state().unrecorded > 0)
    assert memory.collected_bytes < 3_000_000


def test_latched_topics_published_before_the_survey_are_recorded(kit, memory):
    kit.processing.record(text_message("/status", "old", latching=True))
    kit.processing.record(text_message("/status", "idle", latching=True))
    kit.processing.record(text_message("/status", "x" * LARGEST_LATCHED_BYTES, latching=True))
    kit.processing.record(text_message("/plain", "before"))
    kit.open()
    assert memory.texts("/status") == ["idle"]
    assert memory.texts("/plain") == []
    assert memory.texts("/survey_metadata") == kit.opened
    assert all(message.time_ns == kit.now_ns for message in memory.durable)


@pytest.mark.parametrize("x_mm", [12.5, float("nan")])  # strict JSON has no NaN
def test_closing_writes_how_the_survey_ended_with_its_fault(kit, memory, x_mm):
    folder = kit.open()
    kit.processing.store(make_trace(0))
    reason = Message("stopped at {x} mm", x=x_mm).with_fault(LOST_ZERO)
    closed = kit.processing.close_survey(SURVEY, "failed", in_a_row([Message("Failed"), reason]))
    survey = read_json(folder / "survey.json")
    assert (closed.stored_traces, survey["stored_traces"]) == (1, 1)
    assert (survey["outcome"], survey["fault_code"]) == ("failed", "axis.lost_zero")
    kept = received_message(survey["reason"], survey["reason_message"])
    assert (str(kept), kept.cause) == (survey["reason"], LOST_ZERO)
    assert survey["ended"] == "2026-09-21T14:15:00.000000+00:00"
    assert memory.finished


def test_a_wrong_close_is_refused(kit):
    kit.open()
    for arguments, *expected in [
        ((OTHER_SURVEY, "finished"), "robot.in_use", SURVEY, OTHER_SURVEY),
        ((SURVEY, "complete"), "value.not_allowed", "complete", "finished"),
        ((SURVEY, "stopped", verbatim("x" * 20_000)), "value.not_allowed", 20_000, 16_384),
        (("..", "stopped"), "value.not_allowed", ".."),
    ]:
        with raises_fault(*expected, error=SurveyRefusedError):
            print(kit.processing.close_survey(*arguments))
    assert kit.processing.state().survey_id == SURVEY


def test_traces_that_cannot_be_recorded_do_not_fill_the_memory(kit, memory):
    kit.open()
    memory.error = DISK_FULL
    ramp = np.arange(1.0, 4002.0)
    for index in range(40):
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.store(make_trace(index, frequency_hz=ramp, s21_real=ramp, s21_imag=ramp))
    assert memory.collected_bytes < 1_300_000


def test_traces_are_stored_after_a_commit_that_failed_as_nobody_expected(kit, memory, fault_log):
    kit.open()
    memory.error = ZeroDivisionError("a fault of our own")
    wait_until(lambda: kit.processing.state().failing)
    memory.error = None
    assert len(fault_log) == 1
    kit.processing.store(make_trace(0))
    assert len(kit.stored) == 1


def test_a_full_disk_is_told_and_the_trace_is_stored_once_after_space_was_made(kit, memory):
    kit.open()
    memory.error = DISK_FULL
    for _ in range(2):
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.store(make_trace(0))
    assert kit.stored == []
    assert kit.processing.state().failing
    memory.error = None
    kit.processing.store(make_trace(0))
    assert (len(traces_in(memory)), len(kit.stored)) == (1, 1)
    assert not kit.processing.state().failing


def test_a_computer_without_a_clock_opens_no_survey(tmp_path):
    kit = Kit(tmp_path, lambda *_: MemoryRecording(), now_ns=1_000)
    with raises_fault("clock.wrong", 1970, error=SurveyRefusedError):
        kit.open()
    kit.processing.shut_down()


def test_metadata_may_not_contradict_the_storage():
    for key, value in (("started", "yesterday"), ("report", {})):
        with raises_fault("value.not_allowed", key, error=SurveyRefusedError):
            describe(SURVEY, STARTED_US, json.dumps({key: value}), "1.0.0")


def test_neither_a_new_nor_an_old_survey_is_opened_in_another_data_folder(tmp_path):
    def refuse():
        raise SurveyRefusedError(Message("gone").with_fault(OTHER_DATA_FOLDER))

    for check_data in (None, refuse):
        kit = Kit(tmp_path, lambda *_: MemoryRecording(), check_data=check_data)
        if check_data is None:
            kit.open()
        else:
            for action in (kit.processing.reopen_survey, kit.open):
                with raises_fault(OTHER_DATA_FOLDER):
                    action(SURVEY)
        kit.processing.shut_down()
