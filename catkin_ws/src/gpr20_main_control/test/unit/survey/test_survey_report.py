"""What is kept of a survey beside its traces: coverage, sentences, and steps of the clock."""

import json

import pytest
from cut_off_surveys import stored_trace
from fake_robot import ManualClock
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import AXES

from gpr20_common.message import Message
from gpr20_main_control.errors import RECORD_DAMAGED, SurveyError
from gpr20_main_control.mid.survey.survey_report import (
    LARGEST_CORRECTION_S,
    ClockSteps,
    SurveyReport,
)
from gpr20_main_control.mid.survey.survey_status import Coverage
from gpr20_survey.faults import CLOCK_WRONG
from gpr20_survey.plan.survey_state import SampleState, reported_verdict

NO_ANSWER = Message("no answer")


@given(st.lists(st.sampled_from(SampleState), min_size=1, max_size=50))
def test_the_coverage_is_what_was_noted_and_is_read_as_it_was(states):
    coverage = Coverage(len(states))
    for index, state in enumerate(states):
        if state is not SampleState.NOT_VISITED:
            coverage.note_failed(index, NO_ANSWER)
        if state is SampleState.MEASURED:
            coverage.note_stored(index)
            # What is stored never fails afterwards.
            coverage.note_failed(index, NO_ANSWER)
    assert coverage.states == states
    failed = [index for index, state in enumerate(states) if state is SampleState.FAILED]
    assert coverage.reasons == dict.fromkeys(failed, NO_ANSWER)
    complete = set(states) == {SampleState.MEASURED}
    assert coverage.verdict().complete is complete
    assert ("complete:" in str(coverage.verdict().message)) is complete
    report = json.loads(SurveyReport(coverage, AXES).to_json(ended=True))
    assert reported_verdict(report) == coverage.verdict()
    # The runs spell out every state.
    runs = coverage.runs()
    ends = [*(start for start, _state in runs[1:]), len(states)]
    assert [state for (start, state), end in zip(runs, ends) for _ in range(start, end)] == states
    assert all(a[1] is not b[1] for a, b in zip(runs, runs[1:]))


def test_a_report_goes_on_where_the_former_one_ended_and_refuses_what_is_none():
    first = SurveyReport(Coverage(9), AXES)
    first.note_warning(NO_ANSWER)
    first.analyzers.check("Anritsu,MS2026C,1", 0, 0)
    stored = first.to_json(ended=False)
    # What is not measured yet is no verdict.
    assert reported_verdict(json.loads(stored)) is None
    assert SurveyReport(Coverage(9), AXES, stored).to_json(ended=False) == stored
    for former in ("{", "[]", '{"zeros": 3}', '{"analyzers": [{"from_index": "x"}]}'):
        with raises_fault(RECORD_DAMAGED, error=SurveyError):
            SurveyReport(Coverage(9), AXES, former)


class Steps:
    """Checks at every trace, a second after the one before."""

    def __init__(self, last=None):
        self.clock, self.said = ManualClock(), []
        self.steps = ClockSteps(self.clock, last, self.said.append)

    def shown_after(self, step_s=0.0):
        self.clock.set_s += step_s
        self.clock.time_s += 1.0
        self.steps.check()
        shown, self.said[:] = [(one.fault_code, one.values["step_s"]) for one in self.said], []
        return shown


def test_a_clock_that_is_set_is_said_once_with_the_step():
    steps, code = Steps(), CLOCK_WRONG.as_warning().code
    for step_s in (-3600.0, 86400.0, -LARGEST_CORRECTION_S - 0.1):
        assert steps.shown_after() == []
        assert steps.shown_after(step_s) == [(code, pytest.approx(step_s, abs=0.01))]
    behind = Steps(stored_trace(0, timestamp_us=round(1e6 * (1.8e9 + 5000))))
    assert behind.shown_after() == [(code, pytest.approx(-5000, abs=0.1))]
    assert behind.shown_after() == []
