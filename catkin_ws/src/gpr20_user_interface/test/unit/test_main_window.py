"""What the window shows of the robot, and asks it for: band, job, cards, the STOP warning."""

import itertools
from dataclasses import replace

import pytest
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel
from view_kit import (
    ASKED_STOP,
    FULL,
    MOVING,
    RESTING,
    description,
    make_grid,
    moving,
    paused,
    said,
    snapshot,
    state_of,
)
from wait_kit import wait_until
from window_helpers import Finger, click, hold, hold_to_start, place_of, show, start, wishes

from gpr20_common.message import verbatim
from gpr20_operator.ground.traces import SurveyDescribed
from gpr20_operator.robot.condition import JobLevel
from gpr20_operator.robot.events import Answer, Progress, Request, TargetPosition
from gpr20_operator.robot.notices import ANSWER_S, fault_notice
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_survey.axes import AxisId
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.widgets.bars import StateBand, TabName
from gpr20_user_interface.widgets.widgets import Overlay


def job(code, **other):
    values = {
        "progress": Progress("id", 99.99, 1000000, 999999, 10**7),
        "job_parameters": make_grid().plan[0],
        **other,
    }
    return snapshot(code, **values)


SURVEYING, FAULTY = job(SurveyState.SURVEYING), job(SurveyState.PAUSED, state=paused(FULL))


@pytest.fixture
def band(window):
    return window.top_bar.band


def test_state_and_progress_are_seen_once_on_every_tab(window, band):
    surveying = snapshot(SurveyState.SURVEYING, progress=Progress("id", 99.99, 90, 89, 61.0))
    for tab in TabName:
        window.show_tab(tab)
        show(window, surveying)
        shown = (band.title.text(), band.message.text())
        figures = (window.job.percent.text(), window.job.left.text())
        if tab is TabName.SURVEY:
            assert (*shown, *figures) == ("SURVEYING", "As it is", "99 %", "2 min left")
        else:
            assert shown == ("SURVEYING 99 %", "2 min left")
    assert band.simulated.isVisible()


def test_the_figures_of_the_job_are_those_of_its_survey(window):
    page, target = window.job, TargetPosition(150.0, 50.0, 0.0)
    window.on_event(SurveyDescribed(description(survey_id="id", annotation={"name": "Field 4"})))
    progress = Progress("id", 42.7, 242, 103, 1080.0)
    for code in (SurveyState.IDLE, SurveyState.FINISHED, SurveyState.SURVEYING):
        show(window, job(code, progress=progress, target=target))
        running = code is SurveyState.SURVEYING
        assert (window.survey_tab.currentWidget() is page) is running
    figures = [one.text() for one in (page.percent, page.stored, page.left, page.line, page.area)]
    stored = "103 of 242 traces stored"
    assert figures == ["42 %", stored, "18 min left", "Line 1 of 4", "Field 4, 100 x 60 mm"]
    # The figures of another survey are not those of this one.
    show(window, job(code, progress=replace(progress, survey_id="other")))
    assert page.percent.text() == "—" and not page.stored.isVisible()


def test_the_small_map_shows_nothing_of_the_survey_before(window, monkeypatch):
    drawn = []
    monkeypatch.setattr(window.job.map, "show_coverage", lambda model: drawn.append(model.grid))
    for survey in ("id", "next"):
        begun = state_of(SurveyState.CHECKING, survey_id=survey)
        show(window, job(SurveyState.CHECKING, state=begun))
        assert "Field 4" not in window.job.area.text() and drawn.pop() is None
        text = description(survey_id=survey, annotation={"name": "Field 4"})
        window.on_event(SurveyDescribed(text))
        show(window, job(SurveyState.SURVEYING, state=begun))
        assert drawn.pop().survey_id == survey and "Field 4" in window.job.area.text()


def test_a_fault_opens_a_card_once_and_its_resume_asks_like_the_one_of_the_bar(window, band):
    notice = window.notice
    show(window, SURVEYING)
    for touched in (None, band.sign, band.message):
        show(window, FAULTY)
        if touched is not None:
            assert not notice.isVisible()
            click(touched)
        assert notice.isVisible() and notice.reason.toPlainText() == "The disk is full"
        assert notice.first.text() == str(FULL.fault.remedy)
        click(notice.close_button)
    click(band.message)
    click(notice.resume)
    # It resumes nothing by itself.
    assert wishes(window) == [] and window.start_sheet.isVisible() and not notice.isVisible()
    hold_to_start(window)
    assert wishes(window) == ["resume"]
    # A card goes with its fault, and no other card does.
    for shown in (SURVEYING, FAULTY, SURVEYING, FAULTY):
        show(window, shown)
        assert notice.isVisible() is (shown is FAULTY)
    notice.show_notice(fault_notice(paused(MOVING)))
    show(window, SURVEYING)
    assert notice.isVisible()


def test_a_stop_of_axes_that_are_silent_says_at_once_to_switch_off_the_motors(window):
    gone = job(SurveyState.SURVEYING, axes=(), master_alive=False)
    show(window, gone)
    QTest.mousePress(window.top_bar.stop, Qt.LeftButton)
    warning = window.stop_warning
    assert warning.isVisible()
    QTest.mouseRelease(window.top_bar.stop, Qt.LeftButton)
    assert warning.title.text() == "SWITCH OFF THE MOTORS' POWER"
    assert warning.title.fontMetrics().height() >= 2.5 * window.fontMetrics().height()
    # Nothing may cover it.
    window.notice.show_notice(fault_notice(paused(FULL)))
    show(window, gone)
    assert window.childAt(400, 300) in (warning, *warning.findChildren(QLabel))
    # It is closed by a hold and not by a tap.
    click(warning.close_button)
    assert warning.isVisible()
    hold(warning.close_button)
    assert not warning.isVisible()
    click(window.top_bar.stop)
    assert warning.isVisible()
    at_rest = said(SurveyState.STOPPED, ASKED_STOP)
    show(window, job(SurveyState.STOPPED, state=at_rest, master_alive=False))
    assert not warning.isVisible()


def test_a_stop_that_is_not_answered_is_said_between_two_refreshes(opened, clock):
    window = opened()
    axes = tuple(replace(one, received_s=clock.now_s()) for one in RESTING)
    show(window, job(SurveyState.SURVEYING, axes=axes))
    QTest.mousePress(window.top_bar.stop, Qt.LeftButton)
    assert not window.stop_warning.isVisible()
    clock.advance(ANSWER_S + 0.001)
    wait_until(window.stop_warning.isVisible, meanwhile=lambda: QTest.qWait(10))
    window.on_event(Answer(Request.STOP, True, verbatim("stopping")))
    assert window.stop_warning.isVisible()
    show(window, SURVEYING)
    assert not window.stop_warning.isVisible()


X_MOVES = moving(AxisId.X)
# What a window may know of a robot, beside the state of its survey.
KNOWN = (
    *({}, {"alive": False}, {"master_alive": False}, {"axes": ()}, {"axes": X_MOVES}),
    *({"service": verbatim("homing")}, {"pending": frozenset(Request)}),
)


def test_motion_is_seen_and_stop_acts_on_every_tab_over_every_dialog_and_in_every_state(opened):
    field = opened()
    show(field, snapshot(SurveyState.FINISHED, axes=X_MOVES))
    field.findChild(StateBand).touched.emit()
    assert field.notice.title.text() == "ROBOT MOVES"
    assert field.notice.reason.toPlainText() == "X axis"
    assert "STOP stops every axis" in field.notice.first.text()
    field.notice.hide()

    finger, stop, pressed = Finger(field, field.clock), field.top_bar.stop, 0
    states = itertools.cycle(itertools.product((None, *SurveyState), KNOWN))
    band = field.top_bar.band
    for tab, overlay in places_in(field):
        field.touch_binding.cover.dimmed = True
        show(field, snapshot(SurveyState.FINISHED, axes=X_MOVES))
        assert (band.title.text(), band.level) == ("ROBOT MOVES", JobLevel.ATTENTION), (
            tab,
            overlay,
        )
        assert not field.touch_binding.cover.isVisible() and is_free(field, band), (tab, overlay)
        code, known = next(states)
        show(field, snapshot(code, **known))
        for locked in (False, True):
            field.touch_binding.set_locked(locked)
            case = tab, overlay, code, known, locked
            assert stop.isEnabled() and is_free(field, stop), case
            # On the press, whatever has just opened.
            finger.press(stop)
            pressed += 1
            assert wishes(field).count("stop") == pressed, case
            finger.release(stop)
            assert wishes(field).count("stop") == pressed, case
        field.touch_binding.set_locked(False)


def places_in(window):
    """Yield every tab alone, and every dialog over one of them, while it is shown."""
    tabs = itertools.cycle(TabName)
    for tab in TabName:
        window.show_tab(tab)
        yield tab, None
    for overlay in window.findChildren(Overlay):
        tab = next(tabs)
        window.show_tab(tab)
        overlay.open()
        yield tab, type(overlay).__name__
        overlay.hide()


def is_free(window, widget):
    """Return whether a finger on a part of the window meets nothing else."""
    found = window.childAt(place_of(window, widget).center())
    return found is widget or widget.isAncestorOf(found)


class Asked:
    """In place of a client: remembers what it is asked for."""

    def __init__(self):
        self.asked = []

    def __getattr__(self, name):
        return lambda *given, **more: self.asked.append((name, *given, *filter(more.get, more)))


@pytest.fixture
def parts(opened, clock):
    control = Asked()
    window = opened(survey=WindowPresenter(SurveyModel(clock), control, Asked().ask))
    window.begin()
    yield window, control
    window.end()


def say(window, code):
    window.on_event(state_of(code))
    window.refresh()


def test_one_press_of_start_is_one_request(parts):
    window, control = parts
    assert control.asked == [("check_master",)]
    say(window, SurveyState.IDLE)
    start(window)
    start(window)
    assert len(control.asked) == 2
    _name, plan = control.asked[1]
    assert plan.parameters.x_points == 16 and plan.permittivity == 4.0
    assert window.top_bar.stop.isEnabled()


def test_pause_resume_and_every_press_of_stop_are_asked_for(parts):
    window, control = parts
    say(window, SurveyState.SURVEYING)
    click(window.top_bar.pause)
    window.on_event(Answer(Request.PAUSE, True, verbatim("")))
    say(window, SurveyState.PAUSED)
    click(window.top_bar.pause)
    hold_to_start(window)
    click(window.top_bar.stop)
    click(window.top_bar.stop)
    resumed = ("resume_survey", "")
    assert control.asked[1:] == [("pause_survey",), resumed, ("stop",), ("stop",)]
    window.refresh()
    assert Request.STOP in window.survey.snapshot.pending


OTHER = "Anritsu,MS2026C/2,62011033,1.23"
REFUSED = Answer(
    Request.RESUME,
    False,
    verbatim(f"the VNA is {OTHER}, but the survey was measured with Anritsu,MS2026C/2,1,1.23"),
    other_analyzer=OTHER,
)


def test_another_vna_is_a_question_that_resumes_the_same_survey_with_it(parts):
    window, control = parts
    sheet = window.start_sheet
    folder, asked = "20260921T141320_0f8fad5b", [("check_master",)]
    window.on_event(state_of(SurveyState.PAUSED))
    for accepted in (False, True):
        window.survey.resume(folder)
        # The status of the failed check may come first.
        window.on_event(state_of(SurveyState.CHECKING))
        window.on_event(state_of(SurveyState.PAUSED))
        window.on_event(REFUSED)
        asked.append(("resume_survey", folder))
        assert sheet.isVisible() and not window.notice.isVisible()
        assert sheet.question.rows[0][1] == REFUSED.message
        hold_to_start(window) if accepted else click(sheet.cancel)
        assert not sheet.isVisible() and (accepted or control.asked == asked)
    assert control.asked == [*asked, ("resume_survey", folder, OTHER)]
    # Another refusal after the question is a notice.
    window.on_event(Answer(Request.RESUME, False, verbatim("the VNA does not answer")))
    assert window.notice.reason.toPlainText() == "The VNA does not answer"
    assert window.notice.isVisible() and not sheet.isVisible()


def test_the_band_names_the_robot_that_stop_stops(opened):
    window = opened()
    for name, begin in (("", ""), ("robot1", "robot1: "), ("a" * 20 + "/1", f"…{'a' * 13}/1: ")):
        window.top_bar.show_robot(name)
        show(window, snapshot(SurveyState.SURVEYING))
        shown = window.top_bar.band.message.text()
        assert shown.startswith(begin) and (": " in shown) is bool(name)
