"""Another analyzer than the one that a survey began with: used only when it is accepted."""

import pytest
from fault_kit import raises_fault

from gpr20_common.faults import IN_USE
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import OtherAnalyzerError, RequestRefusedError
from gpr20_main_control.mid.survey.survey import Accepted
from gpr20_survey.faults import NONE_OPEN, VNA_REPLACED
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.survey_state import SurveyState as State

FORMER = "Anritsu,MS2026C/2,SIMULATED,1.0"
OTHER = "Anritsu,MS2026C/2,SIMULATED-2,1.0"
THIRD = "Anritsu,MS2026C/2,SIMULATED-3,1.0"
UPDATED = "Anritsu,MS2026C/2,SIMULATED,1.1"


@pytest.fixture
def bench(make_bench):
    # A request waits for the check of the analyzer, in real time.
    return make_bench(clock=Clock())


def pause_as(bench, identity):
    bench.analyzer.failures, bench.analyzer.identity = 1, identity


def pause_with(bench, identity, sweeps=5):
    """Pause a survey after some sweeps; the analyzer has another identity then."""
    bench.at_sweep(sweeps, lambda: pause_as(bench, identity))
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.wait_for_visited(sweeps)


def recorded(bench):
    return [(one["identity"], one["from_index"]) for one in bench.storage.reports[-1]["analyzers"]]


def test_a_survey_continues_only_with_an_analyzer_that_is_accepted_and_records_both(bench):
    # New firmware does not make another one.
    pause_with(bench, UPDATED)
    bench.at_sweep(7, lambda: pause_as(bench, OTHER))
    bench.control.resume("")
    bench.wait_for(State.PAUSED)
    bench.wait_for_visited(7)
    survey_id = bench.board.status.survey_id
    with raises_fault(VNA_REPLACED, OTHER, FORMER, error=OtherAnalyzerError):
        bench.control.resume("")
    bench.wait_for(State.PAUSED)
    assert bench.analyzer.sweeps == 7
    swept, add_fact = [], bench.storage.add_fact

    def note(survey, kind, values_json):
        if OTHER in values_json and kind is Kind.REPORT and not swept:
            swept.append(bench.analyzer.sweeps)
        return add_fact(survey, kind, values_json)

    bench.storage.add_fact = note
    bench.control.resume(survey_id, Accepted(OTHER))
    # A second request accepts nothing, whether the survey runs or has ended already.
    with raises_fault((IN_USE, NONE_OPEN), error=RequestRefusedError):
        bench.control.resume("", Accepted(THIRD))
    bench.complete()
    assert recorded(bench) == [(FORMER, 0), (OTHER, 7)]
    # The first report with both precedes the first trace of the other one.
    assert swept[-1] == 7
    assert all(one["accepted"] for one in bench.storage.reports[-1]["analyzers"])
