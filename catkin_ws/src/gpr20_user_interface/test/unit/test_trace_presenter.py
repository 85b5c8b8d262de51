import dataclasses
import os

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from view_kit import SURVEY, description, make_grid, trace_at

from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.mid.events import ControlState, CurrentPosition, TargetPosition
from gpr20_user_interface.mid.map_coverage import CoverageRuns
from gpr20_user_interface.mid.map_grid import Stop
from gpr20_user_interface.mid.past_surveys import PastSurvey
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.mid.trace_events import (
    ReadingFailed,
    SurveyDescribed,
    SurveyRead,
    SurveysListed,
    TracesRead,
)
from gpr20_user_interface.mid.trace_presenter import PATIENCE_REFRESHES, TracePresenter

OTHER = "7c9e6679-7425-40de-944b-e07fc1f90ae7"
GRID = make_grid()
FOLDER = "20261121T051000_7c9e6679"


class Storage:
    """Remembers what it was asked."""

    def __init__(self):
        self.asked = []

    def list_surveys(self, before):
        self.asked.append(("list", before))

    def read_survey(self, folder):
        self.asked.append(("survey", folder))

    def read_traces(self, survey, first_index):
        self.asked.append(("traces", survey, first_index))


@pytest.fixture(scope="module")
def application():
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def storage():
    return Storage()


@pytest.fixture
def presenter(application, storage):
    presenter = TracePresenter(storage)
    presenter.problems = []
    presenter.problem.connect(presenter.problems.append)
    for view in (presenter.views.map, presenter.views.radar):
        view.show()
    yield presenter
    for view in (presenter.views.map, presenter.views.radar, presenter.views.past):
        view.close()


def stored(count, survey=SURVEY, planned=40):
    return CoverageRuns(survey, planned, (0, count), (1, 0), (), f"{count} are stored")


def page(first_index, *indices, unreadable=(), grid=GRID):
    traces = tuple(trace_at(grid, index) for index in indices)
    return TracesRead(grid.survey_id, first_index, traces, unreadable)


def refresh(presenter, times=1):
    for _ in range(times):
        presenter.refresh()


def test_a_window_that_comes_late_reads_what_was_measured_before(presenter, storage):
    presenter.on_event(stored(6))
    presenter.on_event(SurveyDescribed(description()))
    refresh(presenter, 2)
    assert storage.asked == [("traces", SURVEY, 0)]
    assert presenter.shown.map.counts().done == 3
    presenter.on_event(page(0, 0, 1, 2))
    refresh(presenter, 3)
    assert storage.asked[1:] == [("traces", SURVEY, 3)]
    presenter.on_event(page(3, 3, 4, 5))
    refresh(presenter, 5)
    assert presenter.shown.radar.count == 6
    assert len(storage.asked) == 2


def test_traces_on_their_way_on_the_topic_are_not_read(presenter, storage):
    presenter.on_event(SurveyDescribed(description()))
    for index in range(5):
        presenter.on_event(stored(index + 1))
        presenter.refresh()  # told as stored, not heard yet
        presenter.on_event(trace_at(GRID, index))
        presenter.refresh()
    assert storage.asked == []
    assert presenter.shown.radar.count == 5


def test_a_trace_that_the_topic_lost_is_read(presenter, storage):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(trace_at(GRID, 0))
    presenter.on_event(trace_at(GRID, 2))
    presenter.on_event(stored(3))
    refresh(presenter, 2)
    assert storage.asked == [("traces", SURVEY, 1)]


def test_a_file_that_cannot_be_read_is_told_once(presenter, storage):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(stored(3))
    refresh(presenter, 2)
    presenter.on_event(page(0, 0, 2, unreadable=("1: no strict JSON",)))
    refresh(presenter, 4)
    assert storage.asked == [("traces", SURVEY, 0)]
    assert presenter.problems == ["1: no strict JSON"]
    assert presenter.shown.radar.given_up == {1: "no strict JSON"}


def test_an_answer_without_the_trace_does_not_ask_for_ever(presenter, storage):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(stored(2))
    refresh(presenter, 2)
    presenter.on_event(page(0, 1))
    refresh(presenter, 4)
    assert storage.asked == [("traces", SURVEY, 0)]
    assert "no file" in presenter.shown.radar.given_up[0]


def test_a_storage_that_does_not_answer_is_asked_again(presenter, storage):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(stored(2))
    refresh(presenter, 2)
    presenter.on_event(ReadingFailed("service read_traces did not answer"))
    refresh(presenter, PATIENCE_REFRESHES + 2)
    assert storage.asked == [("traces", SURVEY, 0)] * 2


def test_a_new_survey_begins_an_empty_picture_and_a_resumed_one_does_not(presenter):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(trace_at(GRID, 0))
    presenter.on_event(SurveyDescribed(description(resumed=["2026-11-21T05:10:00+00:00"])))
    assert presenter.shown.radar.count == 1
    presenter.on_event(SurveyDescribed(description(survey_id=OTHER)))
    assert presenter.shown.radar.count == 0


def test_coverage_of_another_survey_waits_for_its_plan(presenter):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(stored(4, OTHER))
    presenter.refresh()
    assert presenter.shown.map.counts() is None
    presenter.on_event(SurveyDescribed(description(survey_id=OTHER)))
    presenter.refresh()
    assert presenter.shown.map.counts().done == 2


@pytest.mark.parametrize(
    "event",
    [
        SurveyDescribed("{"),
        CoverageRuns(SURVEY, 40, (3,), (0,)),
        CoverageRuns(SURVEY, 41, (0,), (0,)),
        trace_at(GRID, 3, x_mm=1.0),
        dataclasses.replace(trace_at(GRID, 3), index=99),
        SurveyRead(FOLDER, "{}", (0,)),
    ],
)
def test_what_cannot_be_shown_is_told_and_the_window_goes_on(presenter, event):
    presenter.on_event(SurveyDescribed(description()))
    presenter.on_event(event)
    presenter.refresh()
    assert len(presenter.problems) == 1
    presenter.on_event(trace_at(GRID, 0))
    assert presenter.shown.radar.count == 1


def listed(*surveys, before="", more=False):
    return SurveysListed(before, surveys, more)


def past(outcome="stopped", complete=False, survey_id=OTHER, problem="", folder=FOLDER):
    started = "" if problem else "2026-11-21T05:10:00.000000+00:00"
    count = 0 if problem else 7
    verdict = "INCOMPLETE: 7 of 40"
    return PastSurvey(
        folder, survey_id, started, outcome, count, 40, verdict, complete, True, problem
    )


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)


def cell(presenter, row, column):
    return presenter.views.past.table.item(row, column).text()


def test_the_list_says_what_became_of_each_survey(presenter, storage):
    presenter.views.past.show()
    assert storage.asked == [("list", "")]
    damaged = past(problem="survey.json cannot be read", folder="20261120T051000_0f8fad5b")
    presenter.on_event(listed(past(), damaged, past("finished", True)))
    assert cell(presenter, 0, 0) == "2026-11-21 05:10"
    assert "INCOMPLETE" in cell(presenter, 0, 1)
    assert cell(presenter, 0, 2) == "7 / 40"
    assert "CANNOT BE READ" in cell(presenter, 1, 1)
    assert cell(presenter, 1, 0) == "2026-11-20 05:10"
    assert cell(presenter, 2, 1).startswith("complete")


def test_only_an_unfinished_survey_can_be_resumed_and_none_while_one_runs(presenter):
    heard = []
    presenter.resume_requested.connect(heard.append)
    view = presenter.views.past
    view.show()
    presenter.on_event(listed(past(), past("finished", True), past(problem="torn")))
    allowed = []
    for row in range(3):
        view.table.selectRow(row)
        allowed.append((view.resume.isEnabled(), view.open.isEnabled()))
    assert allowed == [(True, True), (False, True), (False, False)]
    view.table.selectRow(0)
    click(view.resume)
    assert heard == [FOLDER]
    presenter.show_state(snapshot_of(SurveyState.SURVEYING, OTHER))
    assert not view.resume.isEnabled()
    assert "running" in cell(presenter, 0, 1)


def snapshot_of(code, survey_id, *events):
    class Still:
        def now_s(self):
            return 1.0

    model = SurveyModel(Still())
    for event in (ControlState(code, "", survey_id, True), *events):
        model.handle(event)
    return model.snapshot()


def test_a_past_survey_is_opened_and_the_live_one_goes_on_behind_it(presenter, storage):
    wanted = []
    presenter.radar_wanted.connect(lambda: wanted.append("radar"))
    presenter.on_event(SurveyDescribed(description()))
    presenter.views.past.show()
    presenter.on_event(listed(past()))
    presenter.views.past.table.selectRow(0)
    click(presenter.views.past.open)
    assert storage.asked[-1] == ("survey", FOLDER)
    presenter.on_event(SurveyRead(FOLDER, description(survey_id=OTHER), (0, 1, 5)))
    assert wanted == ["radar"]
    refresh(presenter, 2)
    assert storage.asked[-1] == ("traces", OTHER, 0)
    presenter.on_event(page(0, 0, 1, 5, grid=make_grid(survey_id=OTHER)))
    presenter.on_event(trace_at(GRID, 0))
    presenter.refresh()
    assert (presenter.shown.radar.count, presenter.live.radar.count) == (3, 1)
    assert FOLDER in presenter.views.radar.note.text()
    click(presenter.views.radar.back)
    assert presenter.shown is presenter.live
    assert "PAST" not in presenter.views.radar.note.text()


def test_pages_of_the_list_are_joined(presenter, storage):
    presenter.views.past.show()
    presenter.on_event(listed(past(), more=True))
    click(presenter.views.past.older)
    assert storage.asked[-1] == ("list", FOLDER)
    older = past(folder="20261120T051000_0f8fad5b")
    presenter.on_event(listed(older, before=FOLDER))
    assert presenter.views.past.table.rowCount() == 2
    assert not presenter.views.past.older.isEnabled()


def test_why_the_list_cannot_be_read_is_shown(presenter):
    presenter.on_event(ReadingFailed("service list_surveys did not answer; check its node"))
    assert "did not answer" in presenter.views.past.details.text()


def test_the_target_is_the_current_stop(presenter):
    presenter.on_event(SurveyDescribed(description()))
    there = (TargetPosition(125.0, 70.0, 0.0), CurrentPosition(120.0, 70.0, 0.0))
    presenter.show_state(snapshot_of(SurveyState.SURVEYING, SURVEY, *there))
    assert presenter.live.map.current == Stop(1, 1)
    presenter.show_state(snapshot_of(SurveyState.FINISHED, SURVEY))
    assert presenter.live.map.current is None
