"""Every page shows the survey that runs, or says that it is another; traces are read once."""

import dataclasses

import pytest
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

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.traces import (
    RETRY_REFRESHES,
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracePresenter,
    TracesRead,
)
from gpr20_operator.robot.events import Replay, TargetPosition
from gpr20_operator.words import local_time
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.trace.trace_block import TraceBlock

NEXT = "1b4e28ba-2fa1-41d2-883f-0016d3cca427"
ALL_STORED = tuple(range(40))
GRID = make_grid()


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
    # One that is paused does not, but one that is resumed.
    for before, survey in ((SurveyState.FINISHED, NEXT), (SurveyState.PAUSED, NEXT)):
        note(traces, before, survey)
        open_past(traces)
        note(traces, before, survey)
        assert (done(traces), traces.shown.survey_id) == (20, PAST)
        note(traces, code, survey)
    assert traces.opened_folder == "" and traces.band is None and done(traces) is None
    traces.on_event(SurveyDescribed(description(survey_id=NEXT)))
    traces.on_event(CoverageRuns(NEXT, 40, (0, 2), (1, 0), {}, verbatim("")))
    traces.refresh()
    assert (done(traces), traces.shown.survey_id) == (1, NEXT)


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
    listed = past_survey(outcome="finished", complete=True)
    traces.on_event(SurveysListed("", (listed,), False))
    assert str(traces.band) == f"PAST SURVEY: {local_time(listed.started)}, 7c9e6679"
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
    replay = Replay(PAST, folder=FOLDER, rate=1.0, state=SurveyState.SURVEYING)
    note(traces, SurveyState.SURVEYING, PAST, replay)
    traces.on_event(SurveyDescribed(description(survey_id=PAST)))
    assert (traces.shown.survey_id, traces.band, traces.past.replay) == (PAST, None, True)
    # The traces come with the replay: no storage has them.
    assert traces.source.asked == []


@pytest.fixture
def traces(storage):
    """What MAP and RADAR show, without a window."""
    problems = []
    traces = TracePresenter(storage, problems.append)
    traces.problems = problems
    return traces


def stored(count, survey=SURVEY, planned=40):
    return CoverageRuns(survey, planned, (0, count), (1, 0), {}, verbatim(f"{count} are stored"))


def read(first_index, *indices, unreadable=None, grid=GRID):
    traces = [trace_at(grid, index) for index in indices]
    return TracesRead(first_index, TraceBlock.of(grid.survey_id, traces), unreadable or {})


def refresh(traces, times=1):
    for _ in range(times):
        traces.refresh()


def test_a_window_that_comes_late_reads_what_was_measured_before(traces, storage):
    traces.on_event(stored(6))
    traces.on_event(SurveyDescribed(description()))
    refresh(traces, 2)
    assert storage.asked == [("traces", SURVEY, (0, 1, 2, 3, 4, 5))]
    assert traces.shown.map.counts()[StopState.DONE] == 3
    traces.on_event(read(0, 0, 1, 2))  # what is left is requested at once
    assert storage.asked[1:] == [("traces", SURVEY, (3, 4, 5))]
    traces.on_event(read(3, 3, 4, 5))
    refresh(traces, 5)
    assert traces.shown.radar.count == 6
    assert len(storage.asked) == 2


def test_what_is_stored_and_not_here_yet_is_loading(traces, storage):
    grid = make_grid(50, 25, rotations_deg=(0.0,))
    traces.open_survey(FOLDER)
    parameters = {**grid.plan[0].__dict__, "polarizations_deg": [0.0]}
    text = description(survey_id=PAST, parameters=parameters)
    traces.on_event(SurveyRead(FOLDER, text, tuple(range(1100))))
    requested, shown = [], traces.shown
    assert shown.loading.waiting.sum() == 1100 and not shown.loading.waiting[0, 22:].any()
    refresh(traces, 2)
    while storage.asked[-1] != ("answered",):
        _name, _survey, indices = storage.asked[-1]
        requested += indices
        storage.asked.append(("answered",))
        # The last but one cannot be read.
        some = [one for one in indices if one != 1098]
        why = {1098: verbatim("torn")} if 1098 in indices else None
        traces.on_event(read(indices[0], *some, unreadable=why, grid=shown.map.grid))
        here = len(requested) - (1098 in requested)
        assert (shown.loading.loaded, shown.loading.waiting.sum()) == (here, 1100 - len(requested))
    assert requested == list(range(1100))
    assert (shown.loading.loaded, shown.loading.stored) == (1099, 1099)


def test_only_what_does_not_come_on_the_topic_is_read(traces, storage):
    traces.on_event(SurveyDescribed(description()))
    for index in range(5):
        traces.on_event(stored(index + 1))
        traces.refresh()  # reported as stored, not received yet
        traces.on_event(trace_at(GRID, index))
        traces.refresh()
    assert storage.asked == []
    assert traces.shown.radar.count == 5
    # One that the topic has lost is.
    traces.on_event(trace_at(GRID, 6))
    traces.on_event(stored(7))
    refresh(traces, 2)
    assert storage.asked == [("traces", SURVEY, (5,))]


def test_a_file_that_cannot_be_read_or_is_not_there_is_said_once(traces, storage):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(stored(3))
    refresh(traces, 2)
    traces.on_event(read(0, 2, unreadable={1: verbatim("no strict JSON")}))
    refresh(traces, 4)
    assert storage.asked == [("traces", SURVEY, (0, 1, 2))]
    assert "trace 1: no strict JSON" in map(str, traces.problems)
    lost = traces.shown.radar.given_up
    assert set(lost) == {0, 1} and lost[1] == verbatim("no strict JSON")
    assert "no file" in str(lost[0])


def test_a_storage_that_does_not_answer_is_asked_again(traces, storage):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(stored(2))
    refresh(traces, 2)
    traces.on_event(ReadingFailed(verbatim("the storage did not answer")))
    refresh(traces, RETRY_REFRESHES + 2)
    assert storage.asked == [("traces", SURVEY, (0, 1))] * 2


def test_a_resumed_survey_keeps_its_picture(traces):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(trace_at(GRID, 0))
    traces.refresh()
    traces.on_event(SurveyDescribed(description(resumed=["2026-11-21T05:10:00+00:00"])))
    assert traces.shown.radar.count == 1


def test_what_cannot_be_shown_is_said_and_the_window_goes_on(storage):
    for event in (
        SurveyDescribed("{"),
        CoverageRuns(SURVEY, 40, (3,), (0,)),
        CoverageRuns(SURVEY, 41, (0,), (0,)),
        trace_at(GRID, 3, x_coord_mm=1.0),
        dataclasses.replace(trace_at(GRID, 3), index=99),
        SurveyRead(FOLDER, "{}", (0,)),
    ):
        problems = []
        traces = TracePresenter(storage, problems.append)
        traces.on_event(SurveyDescribed(description()))
        traces.open_survey(FOLDER)
        traces.on_event(event)
        traces.refresh()
        assert len(problems) == 1, event
        traces.on_event(trace_at(GRID, 0))
        traces.refresh()
        assert traces.shown.radar.count == 1


def test_a_past_survey_is_opened_and_the_live_one_goes_on_behind_it(traces, storage):
    traces.on_event(SurveyDescribed(description()))
    traces.open_survey(FOLDER)
    assert storage.asked[-1] == ("survey", FOLDER)
    traces.on_event(SurveyRead(FOLDER, description(survey_id=PAST), (0, 1, 5)))
    refresh(traces, 2)
    assert storage.asked[-1] == ("traces", PAST, (0, 1, 5))
    traces.on_event(read(0, 0, 1, 5, grid=make_grid(survey_id=PAST)))
    traces.on_event(trace_at(GRID, 0))
    refresh(traces)
    assert (traces.shown.radar.count, traces.live.radar.count) == (3, 1)
    assert traces.shown is not traces.live


def test_the_target_is_the_current_stop(traces):
    traces.on_event(SurveyDescribed(description()))
    state = state_of(SurveyState.SURVEYING, survey_id=SURVEY)
    traces.note_state(snapshot(state=state, target=TargetPosition(125.0, 70.0, 0.0)))
    assert traces.live.map.current == Stop(1, 1)
    note(traces, SurveyState.FINISHED)
    assert traces.live.map.current is None
