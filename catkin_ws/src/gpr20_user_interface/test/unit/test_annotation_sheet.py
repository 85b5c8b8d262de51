"""Operator, site, notes and position in the window, written with fingers alone."""

from __future__ import annotations

from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from view_kit import FOLDER, SURVEY, past_survey, snapshot, state_of
from window_helpers import click, show, start

from gpr20_common.message import verbatim
from gpr20_operator.ground.trace_events import (
    AnnotationFailed,
    AnnotationRead,
    AnnotationStored,
    SurveysListed,
)
from gpr20_operator.plan.spec import Tile
from gpr20_operator.robot.events import AnnotationDefaults, Answer, Request
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_user_interface.window.rail import TabName


@pytest.fixture(autouse=True)
def idle(window):
    show(window, snapshot(SurveyState.IDLE))


@pytest.fixture
def sheet(window):
    return window.annotation


def write(sheet, name, text):
    """Touch a field and press the keys of a text."""
    field = sheet.fields[name]
    QTest.mouseClick(field.viewport() if name == "notes" else field, Qt.LeftButton)
    pad = sheet.number_pad if name in ("latitude", "longitude") else sheet.text_pad
    assert pad.isVisible()
    if pad is sheet.number_pad:
        for character in text:
            pad.press(character)
    else:
        pad.press(text)
    click(pad.accept_button)
    assert not pad.isVisible()


def write_example(sheet):
    write(sheet, "name", EXAMPLE.name)
    write(sheet, "operator", EXAMPLE.operator)
    write(sheet, "site", EXAMPLE.site)
    write(sheet, "notes", EXAMPLE.notes)
    write(sheet, "latitude", "4.60283")
    write(sheet, "longitude", "-74.06514")


def started(window):
    window.on_event(Answer(Request.START, True, verbatim("Survey started"), SURVEY))


def test_what_is_written_with_fingers_goes_into_the_next_survey(window, sheet):
    click(window.control.tiles[Tile.NAME])
    write_example(sheet)
    click(sheet.save)
    assert not sheet.isVisible()
    start(window)
    assert window.survey.annotations == [EXAMPLE]


def test_operator_and_site_stay_for_the_survey_after_that_which_gets_the_next_name(window, sheet):
    click(window.control.tiles[Tile.NAME])
    write_example(sheet)
    click(sheet.save)
    started(window)
    click(window.control.tiles[Tile.NAME])
    assert sheet.fields["operator"].text() == EXAMPLE.operator
    assert {sheet.fields[name].text() for name in ("latitude", "longitude", "notes")} == {""}
    click(sheet.save)
    start(window)
    assert window.survey.annotations == [
        Annotation(EXAMPLE.operator, EXAMPLE.site, name="El Carmen 4")
    ]


def test_a_refused_start_keeps_the_notes(window, sheet):
    click(window.control.tiles[Tile.NAME])
    write(sheet, "notes", "wet")
    click(sheet.save)
    window.on_event(Answer(Request.START, False, verbatim("refused")))
    assert window.control.next_annotation.value.notes == "wet"


def test_closing_without_saving_changes_nothing(window, sheet):
    click(window.control.tiles[Tile.NAME])
    write(sheet, "operator", "Ana")
    click(sheet.close_button)
    assert window.control.next_annotation.value == EMPTY


def test_the_defaults_of_the_robot_fill_what_is_empty(window):
    window.control.next_annotation.value = Annotation(site="here")
    window.on_event(AnnotationDefaults(Annotation("Ana", "elsewhere")))
    assert window.control.next_annotation.value == Annotation("Ana", "here")


def test_a_wrong_position_cannot_be_saved_and_says_why(window, sheet):
    for name, text, reason in (
        ("latitude", "91", "latitude is 91 deg; it must lie between -90 and 90 deg"),
        ("longitude", "1-", "longitude is '1-'; it must be a decimal number of degrees"),
        ("longitude", "10", "a position needs latitude and longitude"),
    ):
        click(window.control.tiles[Tile.NAME])
        write(sheet, name, text)
        assert not sheet.save.isEnabled()
        assert sheet.problem.text().startswith(reason)
        click(sheet.close_button)
        assert window.control.next_annotation.value == EMPTY


def test_a_text_that_is_too_long_cannot_be_accepted(window, sheet):
    click(window.control.tiles[Tile.NAME])
    QTest.mouseClick(sheet.fields["operator"], Qt.LeftButton)
    pad = sheet.text_pad
    pad.edit.insertPlainText("a" * 201)
    assert pad.hint.text() == "operator has 201 characters; at most 200 are allowed"
    assert not pad.accept_button.isEnabled()
    click(pad.erase)
    assert pad.accept_button.isEnabled()


def test_return_on_a_real_keyboard_ends_a_line_or_begins_one(window, sheet):
    click(window.control.tiles[Tile.NAME])
    QTest.mouseClick(sheet.fields["operator"], Qt.LeftButton)
    QTest.keyClicks(sheet.text_pad.edit, "Ana")
    QTest.keyClick(sheet.text_pad.edit, Qt.Key_Return)
    assert sheet.fields["operator"].text() == "Ana"
    QTest.mouseClick(sheet.fields["notes"].viewport(), Qt.LeftButton)
    QTest.keyClicks(sheet.text_pad.edit, "a")
    QTest.keyClick(sheet.text_pad.edit, Qt.Key_Return)
    assert sheet.text_pad.edit.toPlainText() == "a\n"
    assert sheet.text_pad.isVisible()


def test_the_notes_of_the_running_survey_are_read_and_changed(window, storage, sheet):
    show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY)))
    click(window.control.tiles[Tile.NAME])
    assert storage.asked[-1] == ("annotation", SURVEY)
    window.on_event(AnnotationRead(SURVEY, EXAMPLE))
    assert sheet.fields["notes"].text() == EXAMPLE.notes
    write(sheet, "notes", "!")
    click(sheet.save)
    changed = replace(EXAMPLE, notes=EXAMPLE.notes + "!")
    assert storage.asked[-1] == ("annotate", SURVEY, changed)
    assert sheet.isVisible()
    window.on_event(AnnotationStored(SURVEY))
    assert not sheet.isVisible()
    assert window.control.next_annotation.value == EMPTY


def test_a_failure_is_said_and_loses_nothing_that_was_written(window, sheet):
    window.on_event(AnnotationRead(FOLDER, EMPTY))
    write(sheet, "site", "here")
    click(sheet.save)
    window.on_event(AnnotationFailed(verbatim("The disk is full")))
    assert window.notice.isVisible()
    assert window.notice.reason.toPlainText() == "The disk is full"
    click(window.notice.close_button)
    assert sheet.isVisible()
    assert sheet.fields["site"].text() == "here"


def test_a_past_survey_is_annotated_from_the_list(window, storage, sheet):
    window.show_tab(TabName.SURVEYS)
    window.on_event(SurveysListed("", (past_survey(),), False))
    assert not window.past.notes.isEnabled()
    window.past.table.selectRow(0)
    click(window.past.notes)
    assert storage.asked[-1] == ("annotation", FOLDER)
    window.on_event(AnnotationRead(FOLDER, EXAMPLE))
    assert FOLDER in sheet.title.text()
    click(sheet.save)
    assert storage.asked[-1] == ("annotate", FOLDER, EXAMPLE)
