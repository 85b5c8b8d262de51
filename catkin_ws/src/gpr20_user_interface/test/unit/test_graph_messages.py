"""Between the graph and the window: messages with their templates, calls, work in the background.

Without a ROS master: no topic and no real service.
"""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("gpr20_msgs.msg")
pytest.importorskip("diagnostic_updater")

from annotation_examples import annotations
from hypothesis import given
from topics_kit import LIMIT_S, taken

from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import Fault, Message, verbatim
from gpr20_msgs.msg import Annotation as AnnotationMessage
from gpr20_msgs.msg import SurveyCoverage, SurveySummary
from gpr20_msgs.srv import ListSurveysResponse, ReadTracesResponse
from gpr20_operator.files.newest import Newest
from gpr20_operator.high import conversions, ros_events
from gpr20_operator.high.control_client import WITHDRAWN, ControlClient
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Answer, Request
from gpr20_operator.robot.senders import Senders
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.plan.annotation import from_fields

REMEDY = Message("Free some space on the disk.")
FULL = Message("the disk is full", details="errno 28").with_fault(Fault("disk.full", REMEDY))
TEXT, SENT = str(FULL), FULL.to_json()


def test_why_something_of_a_survey_failed_has_its_fault_and_remedy_or_its_text():
    coverage = SurveyCoverage(
        planned=9,
        run_starts=[0],
        run_states=[3],
        failures=[f"4: {TEXT}", "7: no template: as it is"],
        failures_json=[SENT, ""],
        verdict=TEXT,
        verdict_json=SENT,
    )
    runs = conversions.coverage_runs(coverage)
    assert runs.failures == {4: FULL, 7: verbatim("no template: as it is")}
    response = ReadTracesResponse(
        survey_id="id", unreadable=[f"3: {TEXT}", "5: torn"], unreadable_json=[SENT]
    )
    read = conversions.traces_read(3, response)
    assert (read.first_index, read.block.survey_id, read.block.indices.size) == (3, "id", 0)
    assert read.unreadable == {3: FULL, 5: verbatim("torn")}
    summary = SurveySummary(problem=TEXT, problem_json=SENT, fault_code="axis.lost_zero")
    (failed,) = conversions.surveys_listed("", ListSurveysResponse(surveys=[summary])).surveys
    assert (failed.verdict, failed.fault_code) == (None, "axis.lost_zero")
    for one in (runs.failures[4], runs.verdict, read.unreadable[3], failed.problem):
        assert (one.fault_code, one.remedy) == ("disk.full", REMEDY)


def test_traces_that_contradict_themselves_are_refused():
    response = ReadTracesResponse(frequency_hz=[1e9, 2e9], indices=[3], s21=bytes(15))
    with pytest.raises(TraceRefusedError) as refusal:
        conversions.traces_read(3, response)
    assert refusal.value.message.fault_code == "trace.damaged"


@given(annotations)
def test_an_annotation_comes_out_of_a_ros_message_as_it_went_in(annotation):
    data = serialized(conversions.annotation_message(annotation))
    assert repr(from_fields(deserialized(AnnotationMessage, data))) == repr(annotation)


@pytest.fixture
def client(services, events):
    """A client whose request to set the parameters hangs."""
    estimated = SimpleNamespace(to_sec=lambda: 1.0)
    plan = {"plan_id": "0123", "total_points": 4, "estimated_time": estimated}
    services.answers["set_survey_parameters"] = [services.hung, plan]
    services.answers["start_survey"] = [{"survey_id": "s"}]
    client = ControlClient(events.put, Senders("/"))
    client._stop = SimpleNamespace(press=lambda: None, forget=lambda: None)
    return client


@pytest.mark.parametrize("withdraw", [ControlClient.stop, ControlClient.withdraw_start])
def test_a_survey_whose_parameters_are_not_accepted_yet_is_not_started_after_stop(
    client, services, events, withdraw
):
    client.start_survey(default_parameters())
    assert services.asked.get(timeout=LIMIT_S)[0] == "set_survey_parameters"
    withdraw(client)
    services.hung.set()
    assert events.get(timeout=LIMIT_S) == Answer(Request.START, False, WITHDRAWN)
    assert services.asked.empty()


def test_a_survey_is_started_after_an_earlier_stop(client, services, events):
    client.stop()
    services.hung.set()
    client.start_survey(default_parameters())
    (answer,) = [one for one in taken(events, 2) if isinstance(one, Answer)]
    assert answer.success
    # The plan that it has set, whatever another client has set meanwhile.
    assert dict(taken(services.asked, 2))["start_survey"]["plan_id"] == "0123"


def test_the_newest_value_is_taken_next_even_after_one_that_failed(fault_log):
    taken, begun, go_on = [], threading.Event(), threading.Event()

    def act(value):
        taken.append(value)
        begun.set()
        assert go_on.wait(LIMIT_S)
        raise ZeroDivisionError("a fault of our own")

    newest = Newest(act)
    newest.put(1)
    assert begun.wait(LIMIT_S)
    for value in (2, 3):
        newest.put(value)
    go_on.set()
    assert newest.wait(LIMIT_S)
    assert (taken, len(fault_log)) == ([1, 3], 2)


def test_a_request_that_fails_in_the_background_is_logged(fault_log):
    threads = []

    def work():
        threads.append(threading.current_thread())
        raise ZeroDivisionError("a fault of our own")

    before = set(threading.enumerate())
    ros_events.in_background(work)
    for thread in set(threading.enumerate()) - before:
        thread.join(LIMIT_S)
    assert len(threads) == 1 and "a fault of our own" in "".join(fault_log)
