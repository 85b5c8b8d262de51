"""Which survey GROUND shows: the one that runs, or a stored one that was opened."""

from view_kit import (
    FOLDER,
    PAST,
    SURVEY,
    description,
    make_grid,
    past_survey,
    snapshot,
    state_of,
    trace_at,
)
from window_helpers import click, hold_to_start, show, wishes

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.robot.events import CurrentPosition, TargetPosition
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace_block import TraceBlock
from gpr20_user_interface.window.rail import TabName

OTHER = PAST
GRID = make_grid()


def stored(count, survey=SURVEY, planned=40):
    return CoverageRuns(survey, planned, (0, count), (1, 0), {}, verbatim(f"{count} are stored"))


def read(first_index, *indices, unreadable=None, grid=GRID):
    traces = [trace_at(grid, index) for index in indices]
    return TracesRead(first_index, TraceBlock.of(grid.survey_id, traces), unreadable or {})


def listed(*surveys, before="", more=False):
    return SurveysListed(before, surveys, more)


def test_only_an_unfinished_survey_can_be_resumed_and_none_while_one_runs(window):
    page = window.past
    window.show_tab(TabName.SURVEYS)
    surveys = (
        past_survey(),
        past_survey(outcome="finished", complete=True),
        past_survey(started="", problem=verbatim("torn")),
    )
    window.on_event(listed(*surveys))
    allowed = []
    for one in surveys:
        page.choose(one)
        allowed.append((page.resume.isEnabled(), page.open.isEnabled()))
    assert allowed == [(True, True), (False, True), (False, False)]
    page.choose(surveys[0])
    click(page.resume)
    assert wishes(window) == []
    hold_to_start(window)
    assert wishes(window) == [f"resume {FOLDER}"]
    show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=OTHER)))
    assert not page.resume.isEnabled()


def test_a_past_survey_is_opened_and_the_live_one_goes_on_behind_it(window, storage):
    window.on_event(SurveyDescribed(description()))
    window.show_tab(TabName.SURVEYS)
    window.on_event(listed(past_survey()))
    window.past.choose(past_survey())
    click(window.past.open)
    assert storage.asked[-1] == ("survey", FOLDER)
    window.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), (0, 1, 5)))
    view = window.ground.view
    assert view.isVisible()
    window.draw()
    window.draw()
    assert storage.asked[-1] == ("traces", OTHER, (0, 1, 5))
    window.on_event(read(0, 0, 1, 5, grid=make_grid(survey_id=OTHER)))
    window.on_event(trace_at(GRID, 0))
    window.draw()
    assert (window.traces.shown.radar.count, window.traces.live.radar.count) == (3, 1)
    assert view.band.isVisible()
    assert f"{past_survey().local_time()}, 7c9e6679" in view.band.whole
    click(view.back)
    assert window.traces.shown is window.traces.live
    assert not view.band.isVisible()


def test_the_counts_of_a_past_survey_are_never_those_of_the_one_that_runs(window):
    def done():
        counts = window.ground.model.survey.map.counts()
        return None if counts is None else counts[StopState.DONE]

    view = window.ground.view
    window.traces.open_survey(FOLDER)
    window.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), tuple(range(40))))
    window.show_tab(TabName.GROUND)
    assert done() == 20 and view.band.isVisible()
    show(window, snapshot(state=state_of(SurveyState.CHECKING, survey_id=SURVEY)))
    assert done() is None and not view.band.isVisible()
    window.on_event(SurveyDescribed(description()))
    window.on_event(stored(2))
    window.draw()
    assert done() == 1
    assert view.isVisible()


def test_why_the_list_cannot_be_read_is_shown(window):
    window.on_event(ReadingFailed(verbatim("the storage did not answer")))
    assert "did not answer" in window.past.details.text()


def test_the_target_is_the_current_stop(window):
    window.on_event(SurveyDescribed(description()))
    there = {
        "target": TargetPosition(125.0, 70.0, 0.0),
        "current": CurrentPosition(120.0, 70.0, 0.0),
    }
    show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY), **there))
    assert window.traces.live.map.current == Stop(1, 1)
    show(window, snapshot(state=state_of(SurveyState.FINISHED, survey_id=SURVEY)))
    assert window.traces.live.map.current is None
