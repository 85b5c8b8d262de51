"""Between the graph and the screens, without a graph: START, STOP, and what services answer."""

import threading
from types import SimpleNamespace

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

import rosgraph
from candidate_examples import candidate_list
from fake_clock import FakeClock
from map_kit import focused
from result_examples import a_map
from result_kit import BLUE
from topics_kit import LIMIT_S, taken
from view_kit import FULL, SURVEY

from gpr20_common.faults import PART_SILENT
from gpr20_common.high.answers import fault_of, message_fields
from gpr20_common.high.service_client import ServiceClient, ServiceUnavailableError
from gpr20_common.message import Message, verbatim
from gpr20_doctor.mid.robot_facts import AxisReport
from gpr20_main_control.high.main_control_node import analyzer_test_fields
from gpr20_msgs.msg import CurrentCoordinate, SurveyCoverage
from gpr20_msgs.srv import ReadTracesResponse
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.high import robot_stop
from gpr20_operator.high.control_client import WITHDRAWN, ControlClient
from gpr20_operator.high.storage_client import StorageClient, coverage_runs
from gpr20_operator.jobs.job import JobState, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey, SurveysListed
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.robot.events import Answer, AxisStopAnswer, Request, Senders, StartPlan
from gpr20_operator.robot.service_model import HeightTested
from gpr20_survey.axes import AxisId
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.answers import AnalyzerTest, focus_fields
from gpr20_survey.results.hiding_map import hiding_json


@pytest.fixture
def client(services, events):
    """A client whose request to set the parameters hangs."""
    services.answers["set_survey_parameters"] = [services.hung, {"plan_id": "0123"}]
    services.answers["start_survey"] = [{"survey_id": "s"}]
    client = ControlClient(events.put, Senders("/"))
    client._stop = SimpleNamespace(press=lambda: None, forget=lambda: None)
    return client


@pytest.mark.parametrize("withdraw", [ControlClient.stop, ControlClient.withdraw_start])
def test_a_survey_whose_parameters_are_not_accepted_yet_is_not_started_after_stop(
    client, services, events, withdraw
):
    client.start_survey(StartPlan(default_parameters()))
    assert services.asked.get(timeout=LIMIT_S)[0] == "set_survey_parameters"
    withdraw(client)
    services.hung.set()
    assert events.get(timeout=LIMIT_S) == Answer(Request.START, False, WITHDRAWN)
    assert services.asked.empty()
    # The next one is, with the plan that it has set, whatever another client has set meanwhile.
    client.start_survey(StartPlan(default_parameters()))
    assert events.get(timeout=LIMIT_S).success
    assert dict(taken(services.asked, 2))["start_survey"]["plan_id"] == "0123"


def test_what_axes_report_is_passed_on_as_it_is(client):
    for axis, homed, moving in zip(AxisId, (True, False, True), (False, True, True)):
        said = CurrentCoordinate(coordinate=1.5, homed=homed, moving=moving, owner="/o")
        assert client._measured(axis, said) == AxisReport(axis, 1.5, homed, moving, "/o")


SILENT = ServiceUnavailableError(Message("no answer"))


@pytest.fixture
def stop(services, events, monkeypatch):
    """STOP, with a clock of its own."""
    monkeypatch.setattr(robot_stop, "Clock", FakeClock)
    monkeypatch.setattr(robot_stop.rospy, "logwarn_throttle", lambda *_given: None)
    stop = robot_stop.RobotStop(events.put)
    yield stop
    stop.forget()


def test_a_stop_that_an_axis_or_the_main_control_did_not_hear_is_repeated_until_it_does(
    stop, services, events
):
    services.answers = {name: [SILENT] * 5 + [{}] for name in ("stop_survey", "x_axis/stop")}
    stop.press()
    found = taken(events, 6)
    of_x = [getattr(one, "answered", None) for one in found if getattr(one, "axis", "") is AxisId.X]
    assert of_x == [False, True]
    answers = [one for one in found if isinstance(one, Answer)]
    assert [(one.success, one.contact) for one in answers] == [(False, False), (True, True)]
    assert answers[0].message.cause == PART_SILENT
    asked = [name for name, _fields in taken(services.asked, 14)]
    assert asked.count("stop_survey") == asked.count("x_axis/stop") == 6
    assert services.asked.empty()


def test_every_press_asks_all_and_none_waits_for_one_that_hangs(stop, services, events):
    services.answers = {
        "x_axis/stop": [SILENT],
        "y_axis/stop": [{"success": False}],
        "stop_survey": [services.hung, {"success": False}],
    }
    for _press in range(2):
        stop.press()
        answers = [] if services.hung.is_set() else taken(events, 3)
        services.hung.set()
        answers += taken(events, 4 - len(answers))
        axes = {one.axis: one.answered for one in answers if isinstance(one, AxisStopAnswer)}
        assert axes == {AxisId.X: False, AxisId.Y: False, AxisId.Z: True}
        (control,) = [one for one in answers if isinstance(one, Answer)]
        assert (control.request, control.success, control.contact) == (Request.STOP, False, True)


def test_a_stop_is_repeated_no_more_when_something_was_started_since(stop, services, events):
    services.answers = {"stop_survey": [SILENT, services.hung, SILENT]}
    stop.press()
    taken(events, 4)
    asked = [name for name, _fields in taken(services.asked, 5)]
    stop.forget()
    services.hung.set()
    stop._services[-1]._repeating.acquire(timeout=LIMIT_S)
    assert asked.count("stop_survey") == 2 and services.asked.empty()


def test_stop_needs_no_master_once_it_knows_the_address(monkeypatch):
    # A service that is not there now has its last address; a silent master is said.
    answers = ["rosrpc://robot:1", rosgraph.MasterError("unknown service"), OSError("refused")]

    def look_up(name):
        assert name == "/stop_survey"
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    known = SimpleNamespace(lookupService=look_up)
    monkeypatch.setattr(robot_stop.rosgraph, "Master", lambda _name: known)
    monkeypatch.setattr(ServiceClient, "_look_up", lambda *_given: "asked the master")
    client = robot_stop.StopService(None, print, threading.Event())
    assert client._look_up(0, 1.0) == "asked the master"
    client.remember()
    client.remember()
    with pytest.raises(OSError):
        client.remember()
    assert client._look_up(0, 1.0) == "rosrpc://robot:1"
    # Where that fails, it may be a new one.
    assert client._look_up(1, 1.0) == "asked the master"


def test_why_a_trace_failed_is_its_fault_or_its_text():
    coverage = SurveyCoverage(
        planned=9,
        run_starts=[0, 4],
        run_states=[1, 3],
        failures=[f"4: {FULL}", "7: no template: as it is"],
        failure_faults=[fault_of(FULL)],
    )
    failures = {4: FULL, 7: verbatim("no template: as it is")}
    assert coverage_runs(coverage) == CoverageRuns("", 9, (0, 4), (1, 3), failures)


TESTED = AnalyzerTest("10.0.0.1", "Anritsu,MS2026C", "HIGH", 51, 0.02, -40.0)
READ = ReadTracesResponse(success=True, survey_id="id", unreadable=["3: torn"])
ANSWERS = {
    Service.FOCUS: focus_fields(focused()),
    Service.HIDE: {"hiding_json": hiding_json(a_map([[[1]]], [[[6]]]))},
    Service.EXPORT: {"files": ["GPR20/a.pdf"], "content": b""},
    Service.STICKS: {"computer": "server", "volumes": [BLUE]},
    Service.READ: {"metadata_json": "{}", "stored_indices": [0, 3]},
    Service.LIST: {"surveys": [], "more": False},
    Service.TRACES: {one: getattr(READ, one) for one in READ.__slots__ if one != "message"},
    Service.FACT: {
        **message_fields(verbatim("noted")),
        **{"survey_id": SURVEY, "markers_json": "[]"},
    },
    Service.MOVE: message_fields(verbatim("The y axis is at 20 mm.")),
    Service.DAILY: message_fields(verbatim("Swept twice.")),
    Service.HEIGHT: {"height_m": 0.2, "spread_m": 0.001, "voltage_v": 1.3},
    Service.ANALYZER: analyzer_test_fields(TESTED),
}
FIELDS = {Service.FACT: {"kind": Kind.FOUND, "values": {}}}
REFUSED = {"success": False, **message_fields(verbatim("refused"))}
# Of the other services of the storage.
STORED = {"survey_id": "id", "markers_json": "[]", "stored_indices": [0, 3]}
STORED.update(metadata_json="{}")


def answer_all(services):
    services.usual = STORED
    services.answers = {one.value: [found] for one, found in ANSWERS.items()}


@pytest.fixture
def imaging(services, events):
    answer_all(services)
    client = StorageClient(events.put, Senders("/"))
    yield Imaging(client, lambda: 0.0)
    client.close()


def test_the_answers_are_what_pages_work_with_and_delivered_in_their_thread(
    imaging, services, events
):
    found, threads = {}, []
    for service in Service:
        job = imaging.job(service, lambda _result: threads.append(threading.current_thread()))
        job.ask(survey=SURVEY, **FIELDS.get(service, {}))
        assert job.running
        events.get(timeout=LIMIT_S).deliver()
        assert job.state is JobState.DONE
        found[service] = job.result
        name, fields = services.asked.get()
        assert name == service.value and fields["survey"] == SURVEY
        assert ("request_id" in fields) == service.can_be_cancelled
    assert threads == [threading.current_thread()] * len(Service)
    candidates = candidate_list(focused().found.candidates, survey_id=SURVEY)
    assert found[Service.FOCUS].found == candidates
    assert found[Service.EXPORT].files == ("GPR20/a.pdf",)
    assert found[Service.STICKS].computer == "server"
    assert [one.path for one in found[Service.STICKS].volumes] == [BLUE.path]
    assert found[Service.READ] == StoredSurvey("{}", (0, 3))
    assert found[Service.LIST] == SurveysListed((), False)
    assert found[Service.TRACES].block.survey_id == "id"
    assert found[Service.TRACES].unreadable == {3: verbatim("torn")}
    assert str(found[Service.FACT]) == "noted"
    assert str(found[Service.MOVE]) == "The y axis is at 20 mm."
    assert found[Service.HEIGHT] == HeightTested(0.2, 0.001, 1.3)
    assert found[Service.ANALYZER] == TESTED


@each_case("what", [*Service])
def test_answers_arrive_and_silence_and_refusals_are_failures_with_a_reason(
    imaging, services, events, what
):
    def asked():
        """Return the reason of a failure."""
        job = imaging.job(what)
        job.ask(survey=SURVEY, **FIELDS.get(what, {}))
        events.get(timeout=LIMIT_S).deliver()
        return job.problem or job.result.failure

    services.answers.clear()
    services.usual = ServiceUnavailableError(Message("no answer"))
    silent = asked()
    assert silent.cause == PART_SILENT and silent.remedy is not None
    # A test that failed says what it has found before.
    services.usual = {**ANSWERS.get(what, {}), **REFUSED}
    refused = asked()
    assert str(refused) == "refused" and refused.cause is None
    if what is Service.HIDE:
        services.usual = {"hiding_json": "{}"}
        assert asked() is not None, "an answer that is not valid"
