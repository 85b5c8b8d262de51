"""The verdict of a report in survey.json is that of the coverage which it holds."""

from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.message import Message
from gpr20_survey.plan.coverage import COVERAGE_LETTERS, Coverage, SampleState, reported_verdict


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


@each_case("report", [None, [], "m", {}, {"coverage": ""}, {"coverage": ["m"]}])
def test_a_report_without_coverage_has_no_verdict(report):
    assert reported_verdict(report) is None


@given(st.text(min_size=1).filter(lambda text: set(text) - set("mrf-")))
def test_letters_that_no_version_wrote_are_no_coverage(text):
    assert reported_verdict({"coverage": text}) is None
