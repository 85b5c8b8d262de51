"""Messages of the graph reach the window with their templates, or as plain text without them."""

import pytest

pytest.importorskip("gpr20_msgs.msg")
pytest.importorskip("diagnostic_updater")

from annotation_examples import annotations
from hypothesis import given, settings

from gpr20_common.high.raw_message import deserialized, serialized
from gpr20_common.message import Fault, Message, verbatim
from gpr20_common.sent_message import message_fields
from gpr20_msgs.msg import Annotation as AnnotationMessage
from gpr20_msgs.msg import ControlStatus, SurveyCoverage, SurveySummary
from gpr20_msgs.srv import ListSurveysResponse, ReadTracesResponse
from gpr20_operator.high import conversions
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.plan.annotation import from_fields

FULL = Message("the disk is full", details="errno 28")
PAUSED = Message("Paused: {reason}", reason=FULL)


def test_status_of_the_survey_has_its_template_values_and_details_or_its_text():
    status = ControlStatus(code=ControlStatus.PAUSED, survey_id="id", **message_fields(PAUSED))
    state = conversions.control_state(status)
    assert state.message == PAUSED
    assert state.message.all_details == ("errno 28",)
    plain = ControlStatus(code=ControlStatus.PAUSED, message="Paused: why")
    assert conversions.control_state(plain).message == verbatim("Paused: why")


def test_coverage_has_a_reason_for_each_trace_that_failed():
    coverage = conversions.coverage_runs(
        SurveyCoverage(
            planned=9,
            run_starts=[0],
            run_states=[3],
            failures=[f"4: {FULL}", "7: no template: as it is"],
            failures_json=[FULL.to_json(), ""],
            verdict="incomplete",
            verdict_json=Message("incomplete").to_json(),
        )
    )
    assert coverage.failures == {4: FULL, 7: verbatim("no template: as it is")}
    assert coverage.verdict == Message("incomplete")
    assert conversions.coverage_runs(SurveyCoverage()).verdict is None


def test_past_survey_has_a_verdict_or_a_problem_or_neither():
    summaries = [
        SurveySummary(folder="a", verdict="as it was"),
        SurveySummary(folder="b", problem=str(FULL), problem_json=FULL.to_json()),
    ]
    listed = conversions.surveys_listed("", ListSurveysResponse(surveys=summaries))
    found = [(one.verdict, one.problem) for one in listed.surveys]
    assert found == [(verbatim("as it was"), None), (None, FULL)]


def test_traces_that_cannot_be_read_have_their_reasons():
    response = ReadTracesResponse(
        survey_id="id", unreadable=[f"3: {FULL}", "5: torn"], unreadable_json=[FULL.to_json()]
    )
    read = conversions.traces_read(3, response)
    assert (read.first_index, read.block.survey_id, read.block.indices.size) == (3, "id", 0)
    assert read.unreadable == {3: FULL, 5: verbatim("torn")}


def test_traces_that_contradict_themselves_are_refused():
    response = ReadTracesResponse(frequency_hz=[1e9, 2e9], indices=[3], s21=bytes(15))
    with pytest.raises(TraceRefusedError) as refusal:
        conversions.traces_read(3, response)
    assert refusal.value.message.fault_code == "trace.damaged"


@given(annotations)
@settings(max_examples=50)
def test_an_annotation_comes_out_of_a_ros_message_as_it_went_in(annotation):
    data = serialized(conversions.annotation_message(annotation))
    assert repr(from_fields(deserialized(AnnotationMessage, data))) == repr(annotation)


REMEDY = Message("Free some space on the disk.")
FAULTY = FULL.with_fault(Fault("disk.full", REMEDY))


def test_why_something_of_a_survey_failed_has_its_fault_and_remedy():
    text, sent = str(FAULTY), FAULTY.to_json()
    coverage = SurveyCoverage(
        planned=9, failures=[f"4: {text}"], failures_json=[sent], verdict=text, verdict_json=sent
    )
    runs = conversions.coverage_runs(coverage)
    read = conversions.traces_read(
        3, ReadTracesResponse(unreadable=[f"3: {text}"], unreadable_json=[sent])
    )
    summary = SurveySummary(
        verdict=text,
        verdict_json=sent,
        problem=text,
        problem_json=sent,
        fault_code="axis.lost_zero",
    )
    (listed,) = conversions.surveys_listed("", ListSurveysResponse(surveys=[summary])).surveys
    assert listed.fault_code == "axis.lost_zero"
    for one in (runs.failures[4], runs.verdict, read.unreadable[3], listed.verdict, listed.problem):
        assert (one.fault_code, one.remedy) == ("disk.full", REMEDY)
