"""The sheets that ask before the robot moves: when they close, and what a hold does."""

from dataclasses import replace

from PyQt5.QtWidgets import QLabel, QPushButton
from view_kit import FOLDER, snapshot
from window_helpers import click, hold, show, wishes

from gpr20_common.message import Message
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.form import SurveyPreview
from gpr20_operator.robot.events import Request
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_points import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState


def texts(sheet):
    return [label.text() for label in sheet.findChildren(QLabel) if label.isVisible()]


def test_the_sheet_closes_when_it_is_too_late(window):
    sheet = window.start_sheet
    idle, paused = snapshot(SurveyState.IDLE), snapshot(SurveyState.PAUSED)
    surveying = snapshot(SurveyState.SURVEYING)

    def ask_start():
        sheet.ask_start(default_parameters(), 4.0, Annotation())

    def ask_past():
        sheet.ask_resume_past(FOLDER)

    for ask, before, after in (
        (ask_start, idle, surveying),
        (ask_start, idle, replace(idle, control_alive=False)),
        (sheet.ask_resume, paused, surveying),
        (sheet.ask_resume, paused, replace(paused, pending=frozenset([Request.RESUME]))),
        (ask_past, idle, snapshot(SurveyState.CHECKING)),
    ):
        show(window, before)
        ask()
        show(window, before)
        assert sheet.isVisible()
        show(window, after)
        assert not sheet.isVisible()


def test_zeros_that_nothing_proves_are_accepted_only_by_holding_for_that(window):
    paused = snapshot(SurveyState.PAUSED)
    asked = Message("Paused: {reason}", reason=Message("turned").with_fault(OTHER_ZEROS))
    show(window, replace(paused, state=replace(paused.state, message=asked)))
    window.start_sheet.ask_resume()
    assert "NOT PROVEN" in " ".join(texts(window.start_sheet))
    hold(window.start_sheet.hold)
    assert wishes(window) == ["resume without proof"]
    show(window, paused)
    window.start_sheet.ask_resume()
    hold(window.start_sheet.hold)
    # Each question is answered once.
    hold(window.start_sheet.hold)
    assert wishes(window)[1:] == ["resume"]
    assert not any(one.isVisible() for one in window.start_sheet.findChildren(QPushButton))


def test_what_is_learned_while_the_sheet_is_open_is_shown_and_does_not_end_the_hold(window):
    show(window, snapshot(SurveyState.IDLE))
    click(window.control.start)
    assert "not known yet" in texts(window.start_sheet)
    figures = SurveyPreview(25, 50, 25.0, 25.0, 1.0, SurveyCost(1080.0, 10**6))
    window.survey.preview = figures
    show(window, snapshot(SurveyState.IDLE))
    assert "about 18 min, 1 MB on the disk" in texts(window.start_sheet)
    click(window.start_sheet.cancel)
    assert not window.start_sheet.isVisible() and wishes(window) == []
