"""Which survey is shown; its stored traces are read once, the whole area first, none is lost."""

import dataclasses

import numpy as np
import pytest
from asked_storage import Storage
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from view_kit import (
    FOLDER,
    PAST,
    SURVEY,
    depth_echo,
    description,
    make_grid,
    snapshot,
    state_of,
    trace_at,
)
from window_helpers import show

from gpr20_common.message import verbatim
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.grid import Stop
from gpr20_operator.ground.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    TracesRead,
)
from gpr20_operator.ground.traces import RETRY_REFRESHES, TracePresenter
from gpr20_operator.robot.events import CurrentPosition, TargetPosition
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace_block import TraceBlock

OTHER = PAST
GRID = make_grid()


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
    text = description(survey_id=OTHER, parameters=parameters)
    traces.on_event(SurveyRead(FOLDER, text, tuple(range(1000))))
    loading = traces.shown.loading
    assert (loading.loaded, loading.stored, loading.step) == (0, 1000, 2)
    assert loading.waiting.sum() == 1000 and not loading.waiting[0, 20:].any()
    requested, shown = [], traces.shown
    refresh(traces, 2)
    while storage.asked[-1] != ("answered",):
        _name, _survey, indices = storage.asked[-1]
        requested += indices
        storage.asked.append(("answered",))
        # The last but one cannot be read.
        some = [one for one in indices if one != 998]
        why = {998: verbatim("torn")} if 998 in indices else None
        traces.on_event(read(indices[0], *some, unreadable=why, grid=shown.map.grid))
        here = len(requested) - (998 in requested)
        assert (shown.loading.loaded, shown.loading.waiting.sum()) == (here, 1000 - len(requested))
    assert sorted(requested) == list(range(1000))
    coarse = requested[:250]
    row, column, _polarization = shown.map.grid.cells(np.array(coarse))
    assert set(row % 2) == set(column % 2) == {0}
    assert requested[250:] == sorted(set(range(1000)).difference(coarse))
    assert (shown.loading.loaded, shown.loading.stored) == (999, 999)


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


@settings(max_examples=draws(10), deadline=None)
@given(st.lists(st.tuples(st.integers(0, 4), st.booleans()), max_size=6))
def test_traces_that_come_at_once_are_shown_as_if_they_came_one_by_one(drawn):
    found = []
    for at_once in (True, False):
        traces = TracePresenter(Storage(), lambda _problem: None)
        traces.on_event(SurveyDescribed(description()))
        for number, (index, own) in enumerate(drawn):
            s21 = depth_echo(0.1, level=1.0 + number)
            grid = GRID if own else make_grid(survey_id=OTHER)
            traces.on_event(trace_at(grid, index, s21))
            if not at_once:
                traces.refresh()
        traces.refresh()
        found.append(traces.live.radar)
    assert np.array_equal(found[0].present, found[1].present)
    assert np.allclose(found[0].echoes, found[1].echoes, rtol=0.0, atol=1e-4)
    assert found[0].count == found[1].count


def test_a_file_that_cannot_be_read_or_is_not_there_is_told_once(traces, storage):
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


def test_a_new_survey_begins_an_empty_picture_and_a_resumed_one_does_not(traces):
    traces.on_event(SurveyDescribed(description()))
    traces.on_event(trace_at(GRID, 0))
    traces.refresh()
    traces.on_event(SurveyDescribed(description(resumed=["2026-11-21T05:10:00+00:00"])))
    assert traces.shown.radar.count == 1
    # Its coverage waits for its plan.
    traces.on_event(stored(4, OTHER))
    traces.refresh()
    assert traces.shown.map.counts() is None
    traces.on_event(SurveyDescribed(description(survey_id=OTHER)))
    assert traces.shown.radar.count == 0
    traces.refresh()
    assert traces.shown.map.counts()[StopState.DONE] == 2


def test_what_cannot_be_shown_is_told_and_the_window_goes_on(storage):
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
    traces.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), (0, 1, 5)))
    refresh(traces, 2)
    assert storage.asked[-1] == ("traces", OTHER, (0, 1, 5))
    traces.on_event(read(0, 0, 1, 5, grid=make_grid(survey_id=OTHER)))
    traces.on_event(trace_at(GRID, 0))
    refresh(traces)
    assert (traces.shown.radar.count, traces.live.radar.count) == (3, 1)
    assert traces.shown is not traces.live


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
