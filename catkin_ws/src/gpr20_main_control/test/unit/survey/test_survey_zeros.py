"""Zeros of the axes that change during a survey, and who owns the axes meanwhile."""

from __future__ import annotations

from gpr20_analysis.read.doubts import unproven_zeros
from gpr20_main_control.errors import MOVED_BY_OTHERS
from gpr20_main_control.mid.survey.survey import Accepted
from gpr20_survey.axes import ZeroEpoch
from gpr20_survey.faults import NOT_HOMED, OTHER_ZEROS
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState as State

ACCEPT = Accepted(zeros=True)


def marked(bench):
    return [one.index for one in bench.storage.samples if "not proven" in " ".join(one.quality)]


def proofs(bench):
    return [one["proof"] for one in bench.storage.reports[-1]["zeros"]]


STORED = 5


def until_it_asks_about_a_zero(bench):
    """Let somebody set the zero of z in a sweep, and resume until the operator must decide."""
    bench.at_sweep(STORED, bench.z.begin_zero)
    bench.start()
    bench.wait_for_fault(MOVED_BY_OTHERS)
    bench.wait_for_visited(STORED)
    bench.control.resume("")
    # The known point agrees: the antennas were at their mark. That proves nothing.
    bench.wait_for_fault(OTHER_ZEROS)
    bench.wait_for(State.PAUSED)
    assert len(bench.storage.samples) == STORED


def test_an_axis_that_somebody_homed_is_homed_again_and_compared(bench):
    bench.at_sweep(5, bench.x.begin_zero)
    bench.start()
    bench.wait_for(State.PAUSED)
    homings = bench.x.homings
    bench.control.resume("")
    bench.complete()
    assert (bench.x.homings, marked(bench)) == (homings + 1, [])
    assert proofs(bench) == ["start", "measured"]
    # The last complete stop was measured twice; the repeats are not among the traces.
    epochs = [one.values for one in bench.storage.notes if one.kind is Kind.EPOCH]
    assert [[one["index"] for one in epoch["compared"]] for epoch in epochs] == [[], [2, 3]]


def test_a_known_point_that_does_not_agree_asks_the_operator(bench):
    def lose_zero():
        bench.x.homed = False
        bench.analyzer.level *= -1.0

    bench.at_sweep(5, lose_zero)
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.resume("")
    bench.wait_for_fault(OTHER_ZEROS)
    # Without an answer it compares again.
    bench.wait_for(State.PAUSED)
    bench.control.resume("")
    bench.wait_for_fault(OTHER_ZEROS)
    bench.wait_for(State.PAUSED)
    bench.control.resume("", ACCEPT)
    bench.complete()
    assert proofs(bench) == ["start", "accepted"]
    assert marked(bench)


def test_what_the_operator_accepted_are_those_zeros_and_no_later_ones(bench):
    until_it_asks_about_a_zero(bench)
    bench.z.begin_zero()
    bench.control.resume("", ACCEPT)
    bench.wait_for_fault(OTHER_ZEROS)
    bench.wait_for(State.PAUSED)
    assert marked(bench) == []


def test_agreeing_with_traces_that_nothing_proves_proves_nothing(bench):
    until_it_asks_about_a_zero(bench)
    bench.at_sweep(16, lambda: setattr(bench.x, "homed", False))
    bench.control.resume("", ACCEPT)
    bench.wait_for_fault(NOT_HOMED)
    bench.control.resume("")
    bench.complete()
    assert proofs(bench) == ["start", "accepted", "accepted"]
    assert marked(bench) == list(range(STORED, 24))


def test_zeros_of_a_start_without_a_trace_are_not_those_of_the_survey(bench):
    """Only traces without proof are marked, and verify counts no more than are marked."""
    bench.at_sweep(0, bench.control.stop)
    survey_id = bench.start()
    bench.wait_for(State.STOPPED)
    assert proofs(bench) == ["start"] and not bench.storage.samples
    first = bench.storage.reports[-1]["zeros"]
    bench.at_sweep(2, bench.control.stop)
    bench.control.resume(survey_id)
    bench.wait_for(State.STOPPED)
    assert bench.storage.samples and bench.storage.reports[-1]["zeros"] != first
    bench.control.resume(survey_id)
    bench.complete()
    assert proofs(bench) == ["start", "measured"]
    measured = [one.zeros for one in bench.storage.samples]
    assert len(set(measured)) == 2
    assert (unproven_zeros(bench.storage.reports[-1], measured), marked(bench)) == (set(), [])


def test_zeros_are_unproven_by_the_traces_alone_if_the_report_is_lost():
    one, other = ((ZeroEpoch(number, number),) * 3 for number in (1, 2))
    assert unproven_zeros(None, [(), one, one]) == set()
    for lost in (None, {}, {"zeros": "?"}, {"zeros": [{"epochs": 7}]}):
        assert unproven_zeros(lost, [one, other, one]) == {other}
