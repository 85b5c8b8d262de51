"""What a survey has measured and what it has not."""

import json
import math

import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import Fault, Message
from gpr20_common.sent_message import received_message
from gpr20_main_control import faults
from gpr20_main_control.errors import SurveyError
from gpr20_main_control.mid.survey.known_point import compare
from gpr20_main_control.mid.survey.survey_report import AnalyzerRecord, SurveyReport
from gpr20_main_control.mid.survey.zero_record import ZeroRecord
from gpr20_survey.plan.coverage import Coverage, SampleState
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

MOMENT_US = 1_800_000_000_000_000
NO_ANSWER = Message("no answer")
NONE = AnalyzerRecord(())
NO_ZEROS = ZeroRecord([], {})


def numbers(real, imag):
    return {
        "frequency_hz": np.array([1.0e9, 2.0e9]),
        "s21_real": np.array(real),
        "s21_imag": np.array(imag),
        "sweep_started_us": MOMENT_US,
        "sweep_ended_us": MOMENT_US,
        "quality": (),
        "analyzer": AnalyzerSettings(),
    }


STORED = Trace(
    **numbers([3.0, 0.0], [0.0, 4.0]),
    survey_id="5ec1a5d2-0000-4000-8000-000000000000",
    sample_id="1",
    index=7,
    timestamp_us=MOMENT_US,
    x_coord_mm=0.0,
    y_coord_mm=0.0,
    z_coord_deg=0.0,
    antennae_height_m=0.2,
)


def sweep(real, imag):
    return Sweep(**numbers(real, imag))


def test_nothing_is_complete_until_every_sample_is_stored():
    coverage = Coverage(3)
    for index in range(3):
        assert not coverage.verdict().complete
        assert "complete:" not in str(coverage.verdict().message)
        coverage.note_stored(index)
    assert coverage.verdict().complete
    assert str(coverage.verdict().message) == "complete: all 3 planned traces are stored"


def test_a_failed_sample_keeps_its_reason_until_it_is_stored():
    coverage = Coverage(3)
    coverage.note_failed(1, NO_ANSWER)
    assert coverage.reasons == {1: NO_ANSWER}
    verdict = str(coverage.verdict().message)
    assert "0 of 3 planned traces are stored, 1 failed, 2 not visited" in verdict
    coverage.note_stored(1)
    assert coverage.reasons == {}
    assert coverage.states[1] is SampleState.MEASURED


def test_a_stored_sample_never_becomes_failed():
    coverage = Coverage(3, stored=[0])
    coverage.note_failed(0, NO_ANSWER)
    assert coverage.states[0] is SampleState.MEASURED
    assert coverage.reasons == {}


def test_a_sample_measured_again_still_counts_as_stored():
    coverage = Coverage(1, stored=[0])
    coverage.note_remeasured(0)
    assert coverage.verdict().complete


@given(st.lists(st.sampled_from(SampleState), max_size=40))
def test_the_runs_spell_out_every_state(states):
    coverage = Coverage(len(states))
    coverage._states = list(states)
    runs = coverage.runs()
    ends = [*(start for start, _state in runs[1:]), len(states)]
    spelled = [state for (start, state), end in zip(runs, ends) for _ in range(start, end)]
    assert spelled == states
    assert all(a[1] is not b[1] for a, b in zip(runs, runs[1:]))


def test_a_control_measurement_is_told_relative_to_the_stored_trace():
    control = compare(STORED, sweep([3.0, 0.0], [0.5, 4.0]), 0.21)
    assert control.index == 7
    assert control.difference_db == pytest.approx(10.0 * math.log10(0.25 / 25.0))
    assert control.height_difference_m == pytest.approx(0.01)
    assert "point 7 was measured again; the difference is 20.0 dB below" in str(control.message)
    assert "+10.0 mm" in str(control.message)


def test_a_control_measurement_without_height_tells_none():
    control = compare(STORED, sweep([3.0, 0.0], [0.5, 4.0]), math.nan)
    assert "mm" not in str(control.message)


def test_a_report_goes_on_where_the_former_one_ended():
    first = SurveyReport(Coverage(9, [7]), NONE, NO_ZEROS)
    first.note_repeat(compare(STORED, sweep([3.0, 0.0], [0.5, 4.0]), 0.21), 1_700_000_000 * 10**6)
    second = SurveyReport(Coverage(9, [7]), NONE, NO_ZEROS, first.to_json())
    assert second.coverage.states[7] is SampleState.REMEASURED
    assert second.to_json() == first.to_json()


def test_a_report_has_its_sentences_as_text_and_as_template_with_values():
    coverage = Coverage(2, [0])
    reason = Message("{points} points instead of 51", points=50)
    reason = reason.with_fault(Fault("vna.points"))
    coverage.note_failed(1, reason)
    report = json.loads(SurveyReport(coverage, NONE, NO_ZEROS).to_json())
    verdict = coverage.verdict().message
    assert (report["complete"], report["verdict"]) == (False, str(verdict))
    assert received_message("", json.dumps(report["verdict_message"])) == verdict
    (failed,) = report["failed"]
    assert (failed["index"], failed["reason"]) == (1, "50 points instead of 51")
    assert failed["fault_code"] == "vna.points"
    assert received_message("", json.dumps(failed["reason_message"])) == reason


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_reason_with_a_number_that_is_not_finite_leaves_the_report_strict_json(number):
    coverage = Coverage(1)
    coverage.note_failed(0, Message("the level is {level_db:.1f} dB", level_db=number))
    report = json.loads(SurveyReport(coverage, NONE, NO_ZEROS).to_json())
    json.dumps(report, allow_nan=False)
    (failed,) = report["failed"]
    restored = received_message("", json.dumps(failed["reason_message"]))
    assert str(restored) == failed["reason"] == f"the level is {number} dB"


def test_every_change_of_the_coverage_is_announced_once():
    coverage = Coverage(3, [0])
    announced = []
    coverage.on_change = lambda one: announced.append(one.states)
    coverage.note_stored(1)
    coverage.note_remeasured(0)
    coverage.note_failed(2, NO_ANSWER)
    coverage.note_failed(1, NO_ANSWER)
    assert announced == [
        [SampleState.MEASURED, SampleState.MEASURED, SampleState.NOT_VISITED],
        [SampleState.REMEASURED, SampleState.MEASURED, SampleState.NOT_VISITED],
        [SampleState.REMEASURED, SampleState.MEASURED, SampleState.FAILED],
    ]


def test_a_sample_that_is_measured_again_before_it_is_stored_is_not_counted_as_stored():
    coverage = Coverage(1)
    coverage.note_remeasured(0)
    assert coverage.states == [SampleState.NOT_VISITED]
    coverage.note_stored(0)
    assert coverage.states == [SampleState.REMEASURED]


@pytest.mark.parametrize("former", ["{", "[]", '{"controls": 3}', '{"controls": [{"index": "x"}]}'])
def test_a_former_report_that_is_none_is_refused(former):
    with raises_fault(faults.RECORD_DAMAGED, error=SurveyError):
        SurveyReport(Coverage(1), NONE, NO_ZEROS, former)
