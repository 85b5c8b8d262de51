"""Every tab shows the survey that runs; another one says that it is another one."""

import dataclasses

import pytest
from asked_storage import Storage
from imported_kit import imported_folder
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
from window_helpers import click

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.trace_events import (
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.trace.trace_block import TraceBlock
from gpr20_user_interface.window.rail import TabName

NEXT = "1b4e28ba-2fa1-41d2-883f-0016d3cca427"
ALL_STORED = tuple(range(40))


@pytest.fixture
def traces():
    problems = []
    traces = TracePresenter(Storage(), problems.append)
    traces.problems = problems
    traces.on_event(SurveysListed("", (past_survey(outcome="finished", complete=True),), False))
    return traces


def note(traces, code, survey=SURVEY, replay=None):
    traces.note_state(snapshot(code, state=state_of(code, survey_id=survey), replay=replay))


def open_past(traces):
    traces.open_survey(FOLDER)
    traces.on_event(SurveyRead(FOLDER, description(survey_id=PAST), ALL_STORED))


def done(traces):
    """Return how many stops the tabs show as done; None: they show no survey."""
    counts = traces.shown.map.counts()
    return None if counts is None else counts[StopState.DONE]


@pytest.mark.parametrize("code", sorted(RUNNING - {SurveyState.PAUSED}))
def test_a_survey_that_begins_anywhere_takes_the_place_of_a_past_one(traces, code):
    note(traces, SurveyState.FINISHED)
    open_past(traces)
    assert (done(traces), traces.shown.survey_id) == (20, PAST)
    note(traces, code, NEXT)
    assert traces.opened_folder == "" and traces.band is None and done(traces) is None
    traces.on_event(SurveyDescribed(description(survey_id=NEXT)))
    traces.on_event(CoverageRuns(NEXT, 40, (0, 2), (1, 0), {}, verbatim("")))
    traces.refresh()
    assert (done(traces), traces.shown.survey_id) == (1, NEXT)


def test_a_survey_that_is_resumed_takes_the_place_of_a_past_one(traces):
    for code, opened in ((SurveyState.PAUSED, FOLDER), (SurveyState.HOMING, "")):
        note(traces, SurveyState.PAUSED)
        open_past(traces)
        note(traces, code)
        assert traces.opened_folder == opened


def test_a_survey_is_never_shown_as_the_next_one_whichever_comes_first(traces):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(CoverageRuns(SURVEY, 40, (0,), (1,), {}, verbatim("")))
    traces.refresh()
    note(traces, SurveyState.FINISHED)
    assert done(traces) == 20
    # The storage describes the next survey only after the checks and the homing.
    note(traces, SurveyState.CHECKING, NEXT)
    assert done(traces) is traces.shown.radar.grid is None
    # Its description and its first trace may come before its status.
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(trace_at(make_grid(), 0))
    traces.refresh()
    note(traces, SurveyState.CHECKING, SURVEY)
    assert (traces.shown.survey_id, traces.shown.radar.count) == (SURVEY, 1)


def test_a_past_survey_that_was_asked_for_before_a_survey_began_does_not_come_up(traces):
    note(traces, SurveyState.IDLE)
    traces.open_survey(FOLDER)
    note(traces, SurveyState.CHECKING, NEXT)
    traces.on_event(SurveyRead(FOLDER, description(survey_id=PAST), ALL_STORED))
    assert (traces.opened_folder, traces.problems) == ("", [])


def test_a_past_survey_says_so_and_which_one_it_is(traces):
    note(traces, SurveyState.IDLE)
    open_past(traces)
    (listed,) = traces.past.surveys
    assert str(traces.band) == f"PAST SURVEY: {listed.local_time()}, 7c9e6679"
    named = dataclasses.replace(listed, name="field 3, east")
    traces.on_event(SurveysListed("", (named,), False))
    assert str(traces.band).endswith(", field 3, east")
    note(traces, SurveyState.SURVEYING)
    open_past(traces)
    note(traces, SurveyState.SURVEYING)
    assert "NOT THE RUNNING SURVEY" in str(traces.band)
    assert traces.shown.survey_id == PAST
    traces.show_live()
    assert traces.band is None


def test_a_replay_is_shown_without_a_band_and_without_a_list_of_surveys(traces):
    replay = ReplayView(ReplayMark(PAST, folder=FOLDER, rate=1.0), state=SurveyState.SURVEYING)
    note(traces, SurveyState.SURVEYING, PAST, replay)
    traces.on_event(SurveyDescribed(description(survey_id=PAST)))
    assert (traces.shown.survey_id, traces.band, traces.past.replay) == (PAST, None, True)
    # The traces come with the replay: no storage has them.
    assert traces.source.asked == []


@pytest.mark.parametrize("columns,rows", [(1, 5), (6, 4), (1, 1)])
def test_an_imported_survey_opens_without_a_fault_and_is_not_resumed(
    window, tmp_path, columns, rows
):
    folder, count = imported_folder(tmp_path / "imported", columns, rows), columns * rows
    counts = {"stored_traces": count, "planned_traces": 0, "verdict": None, "simulated": False}
    imported = past_survey(folder=folder.name, outcome="imported", **counts)
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (imported,), False))
    window.past.choose(imported)
    assert not window.past.resume.isEnabled()
    click(window.past.open)
    text = (folder / "survey.json").read_text("ascii")
    window.on_event(SurveyRead(folder.name, text, tuple(range(count))))
    shown = window.traces.shown
    traces = tuple(map(read_trace, sorted((folder / "traces").iterdir())))
    window.on_event(TracesRead(0, TraceBlock.of(shown.map.grid.survey_id, traces), {}))
    window.refresh()
    assert shown.map.counts()[StopState.DONE] == shown.radar.count == count
    assert shown.map.grid.simulated is False and shown.map.grid.plan is None
    window.show_tab(TabName.GROUND)
    window.grab()
    assert not window.ground.view.finer.isEnabled()
    assert window.traces.past.problem is None
    assert str(window.traces.band).startswith("IMPORTED SURVEY: ")
