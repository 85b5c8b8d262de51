from PyQt5.QtWidgets import QApplication
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
from gpr20_user_interface.look.look import TOUCH_PX
from gpr20_user_interface.pages.surveys.view import AREA, VERDICT, WHAT
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


def cell(window, row, column):
    return window.past.table.item(row, column).text()


def test_the_list_says_what_became_of_each_survey(window, storage):
    window.show_tab(TabName.SURVEYS)
    assert storage.asked == [("list", "")]
    damaged = past_survey(
        started="",
        problem=verbatim("survey.json cannot be read"),
        folder="20261120T051000_0f8fad5b",
    )
    window.on_event(listed(past_survey(), damaged, past_survey(outcome="finished", complete=True)))
    assert cell(window, 0, WHAT) == past_survey().local_time()
    assert "INCOMPLETE" in cell(window, 0, VERDICT)
    assert cell(window, 0, AREA).endswith("7 / 40")
    assert "UNREADABLE" in cell(window, 1, VERDICT)
    assert cell(window, 1, WHAT) == damaged.local_time()
    assert cell(window, 2, VERDICT).startswith("complete")


def test_only_an_unfinished_survey_can_be_resumed_and_none_while_one_runs(window):
    view = window.past
    window.show_tab(TabName.SURVEYS)
    window.on_event(
        listed(
            past_survey(),
            past_survey(outcome="finished", complete=True),
            past_survey(started="", problem=verbatim("torn")),
        )
    )
    allowed = []
    for row in range(3):
        view.table.selectRow(row)
        allowed.append((view.resume.isEnabled(), view.open.isEnabled()))
    assert allowed == [(True, True), (False, True), (False, False)]
    view.table.selectRow(0)
    click(view.resume)
    assert wishes(window) == []
    hold_to_start(window)
    assert wishes(window) == [f"resume {FOLDER}"]
    show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=OTHER)))
    assert not view.resume.isEnabled()
    assert "running" in cell(window, 0, VERDICT)


def test_a_past_survey_is_opened_and_the_live_one_goes_on_behind_it(window, storage):
    window.on_event(SurveyDescribed(description()))
    window.show_tab(TabName.SURVEYS)
    window.on_event(listed(past_survey()))
    window.past.table.selectRow(0)
    click(window.past.open)
    assert storage.asked[-1] == ("survey", FOLDER)
    window.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), (0, 1, 5)))
    assert window.tabs.currentWidget() is window.radar_page
    window.draw()
    window.draw()
    assert storage.asked[-1] == ("traces", OTHER, (0, 1, 5))
    window.on_event(read(0, 0, 1, 5, grid=make_grid(survey_id=OTHER)))
    window.on_event(trace_at(GRID, 0))
    window.draw()
    assert (window.traces.shown.radar.count, window.traces.live.radar.count) == (3, 1)
    for tab in (TabName.MAP, TabName.RADAR):
        window.show_tab(tab)
        band = window.tabs.currentWidget().band
        assert band.isVisible() and f"{past_survey().local_time()}, 7c9e6679" in band.text.whole
    click(window.radar_page.band.back)
    assert window.traces.shown is window.traces.live
    assert not window.radar_page.band.isVisible()
    window.show_tab(TabName.MAP)
    assert not window.map_page.band.isVisible()


def test_the_counts_of_a_past_survey_are_never_those_of_the_one_that_runs(window):
    window.traces.open_survey(FOLDER)
    window.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), tuple(range(40))))
    window.show_tab(TabName.MAP)
    done = window.map.legend[StopState.DONE]
    assert done.text() == "Done: 20" and window.map_page.band.isVisible()
    show(window, snapshot(state=state_of(SurveyState.CHECKING, survey_id=SURVEY)))
    assert done.text() == "Done: —" and not window.map_page.band.isVisible()
    window.on_event(SurveyDescribed(description()))
    window.on_event(stored(2))
    window.draw()
    assert done.text() == "Done: 1"
    assert window.tabs.currentWidget() is window.map_page


def test_pages_of_the_list_are_joined(window, storage):
    window.show_tab(TabName.SURVEYS)
    window.on_event(listed(past_survey(), more=True))
    assert storage.asked[-1] == ("list", FOLDER)
    older = past_survey(folder="20261120T051000_0f8fad5b")
    window.on_event(listed(older, before=FOLDER))
    assert window.past.table.rowCount() == 2
    assert storage.asked.count(("list", FOLDER)) == 1


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


def test_map_and_radar_have_room_for_the_band(window):
    window.traces.open_survey(FOLDER)
    window.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), tuple(range(40))))
    for tab, page in ((TabName.MAP, window.map_page), (TabName.RADAR, window.radar_page)):
        window.show_tab(tab)
        QApplication.processEvents()
        assert page.band.isVisible()
        assert page.view.minimumSizeHint().height() <= page.view.height()
        assert page.band.back.height() >= TOUCH_PX
