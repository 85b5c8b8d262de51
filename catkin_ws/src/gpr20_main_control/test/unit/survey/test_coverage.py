"""What a survey has measured and what it has not."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from cut_off_surveys import reopened_survey, stored_trace
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import Fault, Message
from gpr20_common.sent_message import received_message
from gpr20_main_control import faults
from gpr20_main_control.errors import SurveyError
from gpr20_main_control.mid.survey.repeats import Repeated
from gpr20_main_control.mid.survey.survey_coverage import Coverage
from gpr20_main_control.mid.survey.survey_report import (
    AnalyzerRecord,
    FormerReport,
    SurveyReport,
    former_report,
)
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_survey.plan.survey_state import COVERAGE_LETTERS, SampleState, reported_verdict

NO_ANSWER = Message("no answer")


def trace(real, imag):
    return stored_trace(
        7,
        frequency_hz=np.array([1.0e9, 2.0e9]),
        s21_real=np.array(real),
        s21_imag=np.array(imag),
    )


STORED, AGAIN = trace([3.0, 0.0], [0.0, 4.0]), trace([3.0, 0.0], [0.5, 4.0])


def again(height_m):
    return Repeated(STORED, (replace(AGAIN, antennae_height_m=height_m),))


def report_of(coverage, former=""):
    found = former_report(reopened_survey((), former)) if former else FormerReport()
    return SurveyReport(coverage, AnalyzerRecord(()), ZeroRecord([], {}), found)


def test_nothing_is_complete_until_every_sample_is_stored():
    coverage = Coverage(3)
    for index in range(3):
        assert not coverage.verdict().complete
        assert "complete:" not in str(coverage.verdict().message)
        coverage.note_stored(index)
    assert coverage.verdict().complete and "complete:" in str(coverage.verdict().message)


def test_a_failed_sample_keeps_its_reason_until_it_is_stored_and_never_fails_afterwards():
    coverage = Coverage(3)
    coverage.note_failed(1, NO_ANSWER)
    assert coverage.reasons == {1: NO_ANSWER}
    coverage.note_stored(1)
    coverage.note_failed(1, NO_ANSWER)
    assert coverage.reasons == {} and coverage.states[1] is SampleState.MEASURED


@given(st.lists(st.sampled_from(SampleState), max_size=40))
def test_the_runs_spell_out_every_state(states):
    coverage = Coverage(len(states))
    coverage._states = list(states)
    runs = coverage.runs()
    ends = [*(start for start, _state in runs[1:]), len(states)]
    spelled = [state for (start, state), end in zip(runs, ends) for _ in range(start, end)]
    assert spelled == states
    assert all(a[1] is not b[1] for a, b in zip(runs, runs[1:]))


@given(st.lists(st.sampled_from(SampleState), min_size=1, max_size=50))
def test_a_verdict_is_read_as_it_was_given(states):
    coverage = Coverage(len(states))
    for index, state in enumerate(states):
        if state in (SampleState.MEASURED, SampleState.REMEASURED):
            coverage.note_stored(index)
        if state is SampleState.REMEASURED:
            coverage.note_remeasured(index)
        if state is SampleState.FAILED:
            coverage.note_failed(index, Message("lost"))
    letters = "".join(COVERAGE_LETTERS[state] for state in coverage.states)
    assert reported_verdict({"coverage": letters}) == coverage.verdict()


@pytest.mark.parametrize("height_m, shown", [(0.21, "+10.0 mm"), (math.nan, "20.0 dB")])
def test_a_control_measurement_is_told_relative_to_the_stored_trace(height_m, shown):
    control = again(height_m)
    assert control.difference_db == pytest.approx(10.0 * math.log10(0.25 / 25.0))
    assert control.height_difference_m == pytest.approx(height_m - 0.2, nan_ok=True)
    assert shown in str(control.message) and "nan" not in str(control.message)


def test_a_report_goes_on_where_the_former_one_ended():
    first = report_of(Coverage(9, [7]))
    first.note_repeat(again(0.21), 1_700_000_000 * 10**6)
    second = report_of(Coverage(9, [7]), first.to_json())
    assert second.coverage.states[7] is SampleState.REMEASURED
    assert second.to_json() == first.to_json()


@pytest.mark.parametrize("number", [50.0, math.nan, math.inf])
def test_a_report_has_its_sentences_as_text_and_as_template_with_values(number):
    coverage = Coverage(2, [0])
    reason = Message("the level is {level_db:.1f} dB", level_db=number)
    coverage.note_failed(1, reason.with_fault(Fault("vna.points")))
    report = json.loads(report_of(coverage).to_json())
    json.dumps(report, allow_nan=False)
    verdict = coverage.verdict().message
    assert (report["complete"], report["verdict"]) == (False, str(verdict))
    assert received_message("", report["verdict_message"]) == verdict
    (failed,) = report["failed"]
    assert (failed["index"], failed["fault_code"]) == (1, "vna.points")
    restored = received_message("", failed["reason_message"])
    assert str(restored) == failed["reason"] == f"the level is {number:.1f} dB"


@pytest.mark.parametrize("former", ["{", "[]", '{"controls": 3}', '{"controls": [{"index": "x"}]}'])
def test_a_former_report_that_is_none_is_refused(former):
    with raises_fault(faults.RECORD_DAMAGED, error=SurveyError):
        report_of(Coverage(1), former)
