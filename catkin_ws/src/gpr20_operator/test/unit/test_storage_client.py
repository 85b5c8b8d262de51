"""The clients of the services: answers become events or reach their job, never late ones."""

import threading
from types import SimpleNamespace

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

from candidate_examples import candidate_list
from map_kit import focused
from result_examples import a_map
from result_kit import BLUE
from topics_kit import LIMIT_S, taken
from view_kit import SURVEY

from gpr20_common.faults import PART_SILENT
from gpr20_common.high.answers import message_fields
from gpr20_common.high.service_client import ServiceUnavailableError
from gpr20_common.message import Message, verbatim
from gpr20_main_control.high.main_control_node import analyzer_test_fields
from gpr20_msgs.srv import ReadTracesResponse
from gpr20_operator.high.storage_client import StorageClient
from gpr20_operator.jobs.job import JobState, Service
from gpr20_operator.jobs.pictures import Imaging, StoredSurvey, SurveysListed
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.service_model import HeightTested
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.results.answers import AnalyzerTest, focus_fields
from gpr20_survey.results.hiding_map import hiding_json

TESTED = AnalyzerTest("10.0.0.1", "Anritsu,MS2026C", "HIGH", 51, 0.02, -40.0)
READ = ReadTracesResponse(success=True, survey_id="id")
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


def deliver(events):
    """Hand the next answer over, as the window does in its thread."""
    events.get(timeout=LIMIT_S).deliver()


def test_the_answers_are_what_pages_work_with_and_delivered_in_their_thread(
    imaging, services, events
):
    found, threads = {}, []
    for service in Service:
        job = imaging.job(service, lambda _result: threads.append(threading.current_thread()))
        job.ask(survey=SURVEY, **FIELDS.get(service, {}))
        assert job.running
        deliver(events)
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
    assert str(found[Service.FACT]) == "noted"
    assert str(found[Service.MOVE]) == "The y axis is at 20 mm."
    assert found[Service.HEIGHT] == HeightTested(0.2, 0.001, 1.3)
    assert found[Service.ANALYZER] == TESTED


def test_a_request_that_is_cancelled_is_ended_at_the_node_and_its_answer_counts_for_nothing(
    imaging, services, events
):
    services.answers["focus_survey"].insert(0, services.hung)
    job = imaging.job(Service.FOCUS)
    job.ask(survey=SURVEY)
    job.end()
    asked = dict(taken(services.asked, 2))
    services.hung.set()
    deliver(events)
    assert (job.state, job.result) == (JobState.READY, None)
    assert asked["cancel_imaging"]["request_id"] == asked["focus_survey"]["request_id"]


def test_only_the_progress_of_the_export_that_runs_is_shown(imaging, services, events):
    services.answers["export_survey"].insert(0, services.hung)
    job = imaging.job(Service.EXPORT)
    job.ask(survey=SURVEY)
    client = imaging._requests
    stage = message_fields(verbatim("copying"))
    assert client._on_progress(SimpleNamespace(request_id="another", **stage)) is None
    own = services.asked.get(timeout=LIMIT_S)[1]["request_id"]
    client._on_progress(SimpleNamespace(request_id=own, **stage)).deliver()
    assert str(job.stage) == "copying" and events.empty()
    services.hung.set()
    deliver(events)
    assert job.state is JobState.DONE


@each_case("what", [*Service])
def test_answers_arrive_and_silence_and_refusals_are_failures_with_a_reason(
    imaging, services, events, what
):
    def asked():
        """Return the reason of a failure."""
        job = imaging.job(what)
        job.ask(survey=SURVEY, **FIELDS.get(what, {}))
        deliver(events)
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
