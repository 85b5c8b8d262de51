import itertools
from dataclasses import replace

from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QLabel
from test_fault_messages import ASKED_STOP, FULL, MOVING, paused
from view_kit import RESTING, description, make_grid, snapshot
from window_helpers import click, hold_to_start, show, wishes

from gpr20_common.low.clock import Clock
from gpr20_common.message import verbatim
from gpr20_doctor.mid.node_health import HealthLevel, NodeHealth
from gpr20_operator.faults import PART_SILENT
from gpr20_operator.ground.trace_events import SurveyDescribed
from gpr20_operator.robot.condition import Condition, JobLevel
from gpr20_operator.robot.events import Answer, ControlState, Progress, Request, TargetPosition
from gpr20_operator.robot.health import HealthReport
from gpr20_operator.robot.notices import fault_notice
from gpr20_operator.robot.replay import ReplayMark, ReplayView
from gpr20_survey.plan.survey_state import ENDED, SurveyState
from gpr20_user_interface.touch.guard import HOLD_S

AT_REST = ControlState(SurveyState.STOPPED, ASKED_STOP, "id", True)


def shown(code, message="as it is", **other):
    values = {
        "state": ControlState(code, verbatim(message), "id", True),
        "progress": Progress("id", 99.99, 1000000, 999999, 10**7),
        "job_parameters": make_grid().plan[0],
        **other,
    }
    return snapshot(code, **values)


def is_job_shown(window):
    return window.survey_tab.currentWidget() is window.job


def test_the_job_is_shown_from_the_begin_of_a_survey_to_its_end(window):
    show(window, shown(SurveyState.IDLE))
    assert not is_job_shown(window)
    for code in ENDED:
        show(window, shown(SurveyState.SURVEYING))
        assert is_job_shown(window)
        show(window, shown(code))
        assert not is_job_shown(window)


def test_the_job_is_told_in_large_type(window):
    target = TargetPosition(150.0, 50.0, 0.0)
    progress = Progress("id", 42.7, 242, 103, 1080.0)
    called = {"name": "Field 4", "site": "x"}
    window.on_event(SurveyDescribed(description(survey_id="id", annotation=called)))
    show(window, shown(SurveyState.SURVEYING, progress=progress, target=target))
    job = window.job
    assert (job.left.text(), job.percent.text()) == ("18 min left", "42 %")
    assert job.line.text() == "Line 1 of 4"
    assert job.area.whole == "Field 4, 100 x 60 mm"
    assert job.percent.fontMetrics().height() >= 2.5 * job.area.fontMetrics().height()


def test_the_small_map_is_drawn_only_when_it_changes(window, monkeypatch):
    drawn = []
    monkeypatch.setattr(window.job.map, "show_coverage", drawn.append)
    window.draw()
    assert drawn == [], "CONTROL shows the plan"
    show(window, shown(SurveyState.SURVEYING))
    for _ in range(3):
        window.draw()
    assert len(drawn) == 1
    window.traces.live.begin(make_grid(survey_id="id"))
    window.draw()
    window.draw()
    assert len(drawn) == 2


def test_the_job_of_a_survey_that_begins_has_nothing_of_the_one_before(window, monkeypatch):
    code = SurveyState.CHECKING
    drawn = []
    monkeypatch.setattr(window.job.map, "show_coverage", drawn.append)
    window.on_event(SurveyDescribed(description(survey_id="id", annotation={"name": "Field 4"})))
    show(window, shown(SurveyState.SURVEYING))
    window.draw()
    assert "Field 4" in window.job.area.whole
    assert drawn[-1].grid.survey_id == "id"
    begun = ControlState(code, verbatim("as it is"), "next", True)
    show(window, shown(code, state=begun))
    window.draw()
    assert "Field 4" not in window.job.area.whole
    assert drawn[-1].grid is None
    window.on_event(SurveyDescribed(description(survey_id="next", annotation={"name": "East"})))
    window.draw()
    assert window.job.area.whole.startswith("East, ")
    assert drawn[-1].grid.survey_id == "next"


def test_a_fault_opens_a_card_once_and_its_resume_asks_like_the_one_of_the_bar(window):
    received = wishes(window)
    show(window, shown(SurveyState.SURVEYING))
    assert not window.notice.isVisible()
    faulty = shown(SurveyState.PAUSED, state=paused(FULL))
    show(window, faulty)
    notice = window.notice
    assert notice.isVisible() and notice.reason.toPlainText() == "The disk is full"
    assert "Make space" in notice.first.text() and notice.resume.isVisible()
    assert not notice.details.isVisible()
    click(notice.close_button)
    show(window, faulty)
    assert not notice.isVisible()
    click(window.job.card)
    assert notice.isVisible()
    asked = []
    window.top_bar.resume_pressed.connect(lambda: asked.append("resume"))
    click(notice.resume)
    assert asked == ["resume"]
    # It resumes nothing by itself.
    assert received == [] and window.start_sheet.isVisible()
    assert not notice.isVisible()
    hold_to_start(window)
    assert received == ["resume"]


def test_a_card_goes_with_its_fault_and_no_other_card_does(window):
    on = shown(SurveyState.SURVEYING)
    for fault in (
        shown(SurveyState.PAUSED, state=paused(FULL)),
        shown(SurveyState.SURVEYING, alive=False),
        shown(SurveyState.IDLE, interrupted=True),
    ):
        show(window, fault)
        assert window.notice.isVisible() and window.notice.first.text()
        show(window, on)
        assert not window.notice.isVisible()
        show(window, fault)
        window.notice.show_notice(fault_notice(paused(MOVING)))
        show(window, on)
        assert window.notice.isVisible()
        window.notice.hide()


def test_what_to_do_is_read_whole_on_the_page_and_on_the_card(window):
    show(window, shown(SurveyState.CHECKING))
    assert not window.job.remedy.isVisible() and not window.top_bar.band.more.isVisible()
    part = NodeHealth("vna_processing", HealthLevel.STALE, verbatim(""), {})
    show(window, shown(SurveyState.CHECKING, health=HealthReport((part,))))
    remedy = str(PART_SILENT.remedy)
    assert window.job.remedy.text() == remedy and window.top_bar.band.more.isVisible()
    assert remedy in window.top_bar.band.message.whole
    window.top_bar.band.touched.emit()
    assert (window.notice.reason.toPlainText(), window.notice.first.text()) == (
        *("No report: Storage", remedy),
    )


def test_a_replay_opens_no_card(window):
    replay = ReplayView(ReplayMark(), state=SurveyState.PAUSED)
    show(window, shown(SurveyState.PAUSED, state=paused(FULL), replay=replay))
    assert not window.notice.isVisible()
    assert not window.job.notes.isVisible()
    # What the robot said then; the band has the survey.
    assert window.job.message.text() == "The disk is full"


def test_a_stop_of_axes_that_are_silent_says_at_once_to_switch_off_the_motors(window):
    gone = shown(SurveyState.SURVEYING, axes=(), master_alive=False)
    show(window, gone)
    QTest.mousePress(window.top_bar.stop, 1)
    warning = window.stop_warning
    assert warning.isVisible()
    QTest.mouseRelease(window.top_bar.stop, 1)
    assert warning.title.text() == "SWITCH OFF THE MOTORS' POWER"
    assert warning.title.fontMetrics().height() >= 2.5 * window.fontMetrics().height()
    bar = window.top_bar.geometry()
    assert warning.geometry().top() == bar.bottom() + 1
    assert warning.geometry().bottom() == window.rect().bottom()
    # Nothing may cover it.
    window.notice.show_notice(fault_notice(paused(FULL)))
    show(window, gone)
    assert window.childAt(400, 300) in (warning, *warning.findChildren(QLabel))
    show(window, shown(SurveyState.STOPPED, state=AT_REST, master_alive=False))
    assert not warning.isVisible()


def test_a_stop_that_is_not_answered_is_said_within_300_ms(window):
    axes = tuple(replace(one, received_s=Clock().now_s()) for one in RESTING)
    show(window, shown(SurveyState.SURVEYING, axes=axes))
    QTest.mousePress(window.top_bar.stop, 1)
    assert not window.stop_warning.isVisible()
    QTest.qWait(300)
    assert window.stop_warning.isVisible()
    window.on_event(Answer(Request.STOP, True, verbatim("stopping")))
    assert window.stop_warning.isVisible()
    show(window, shown(SurveyState.SURVEYING))
    assert not window.stop_warning.isVisible()


def test_the_warning_is_closed_by_a_hold_and_not_by_a_tap(window):
    show(window, shown(SurveyState.SURVEYING, axes=()))
    click(window.top_bar.stop)
    button = window.stop_warning.close_button
    click(button)
    assert window.stop_warning.isVisible()
    QTest.mousePress(button, 1)
    QTest.qWait(int(1000 * HOLD_S) + 300)
    QTest.mouseRelease(button, 1)
    assert not window.stop_warning.isVisible()


def test_every_level_has_its_own_sign(window):
    pictures = []
    for level in JobLevel:
        band = window.top_bar.band
        band.show_condition(Condition(level, verbatim(""), verbatim("")), "", "")
        pictures.append(band.sign.pixmap().toImage())
    assert not any(one == other for one, other in itertools.combinations(pictures, 2))
