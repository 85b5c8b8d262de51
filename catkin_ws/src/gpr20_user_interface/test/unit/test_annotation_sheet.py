"""Operator, site, notes and position in the window, written with fingers alone."""

from __future__ import annotations

import json
import random
from dataclasses import replace

import pytest
from annotation_examples import EXAMPLE
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QPushButton
from view_kit import FOLDER, SURVEY, snapshot, state_of
from window_helpers import click, hold, show, start

from gpr20_common.message import verbatim
from gpr20_operator.jobs.pictures import StoredSurvey
from gpr20_operator.plan.spec import Keys, Tile
from gpr20_operator.robot.events import Answer, Request, RobotDefaults
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_state import SurveyState


@pytest.fixture(autouse=True)
def idle(window):
    show(window, snapshot(SurveyState.IDLE))


def read(window, node, survey, annotation):
    """Open the records of a survey as the storage has them."""
    window.annotation.read(survey)
    assert node.of("read")[-1] == (survey,)
    node.ticket("read").done(StoredSurvey(json.dumps({"annotation": annotation.values()}), 0))


def asked(node):
    """Return what is to replace the records of which survey."""
    return [tuple(fields.values()) for kind, _, fields in node.asked if kind == "annotate"]


@pytest.fixture
def sheet(window):
    return window.annotation


def write(sheet, name, text):
    """Touch a field and press the keys of a text."""
    click(sheet.tiles[name])
    assert sheet.pad.isVisible()
    sheet.pad.press(text)
    click(sheet.pad.accept_button)
    assert not sheet.pad.isVisible()


def write_example(sheet):
    for name in ("name", "operator", "site", "notes"):
        write(sheet, name, getattr(EXAMPLE, name))
    write(sheet, "position", "4.60283,-74.06514")


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
    assert sheet.texts["operator"] == EXAMPLE.operator
    assert {sheet.texts[name] for name in ("position", "notes")} == {""}
    click(sheet.close_button)
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
    defaults = RobotDefaults("127.0.0.1", Site(site="elsewhere", operator="Ana"))
    show(window, snapshot(SurveyState.IDLE, defaults=defaults))
    assert window.control.next_annotation.value == Annotation("Ana", "here")
    # Once: an operator may empty a field.
    window.control.next_annotation.value = EMPTY
    show(window, snapshot(SurveyState.IDLE, defaults=defaults))
    assert window.control.next_annotation.value == EMPTY


def test_a_wrong_position_cannot_be_accepted_and_says_why(window, sheet):
    click(window.control.tiles[Tile.NAME])
    click(sheet.tiles["position"])
    pad = sheet.pad
    for text, reason in (
        ("91,0", "latitude is 91 deg; it must lie between -90 and 90 deg"),
        ("4,1-", "longitude is '1-'; it must be a decimal number of degrees"),
        ("4.6", "position is '4.6'; it must be latitude and longitude"),
    ):
        pad.edit.clear()
        pad.press(text)
        assert not pad.accept_button.isEnabled()
        assert pad.hint.text().startswith(reason)
    click(pad.cancel)
    click(sheet.close_button)
    assert window.control.next_annotation.value == EMPTY


def test_a_text_that_is_too_long_cannot_be_accepted(window, sheet):
    click(window.control.tiles[Tile.NAME])
    click(sheet.tiles["operator"])
    pad = sheet.pad
    pad.edit.insertPlainText("a" * 201)
    assert pad.hint.text() == "operator has 201 characters; at most 200 are allowed"
    assert not pad.accept_button.isEnabled()
    click(pad.erase)
    assert pad.accept_button.isEnabled()


@pytest.mark.parametrize("keys", [Keys.NUMBER, Keys.WHOLE, Keys.LIST])
def test_every_key_of_a_pad_with_digits_writes_or_erases(sheet, keys):
    pad = sheet.pad
    for key in pad.digits.keys:
        pad.ask(lambda _text: None, "title", "hint", "12", lambda _text: "", keys)
        if key.isEnabled():
            click(key)
            assert pad.edit.toPlainText() != "12", key.text()
        pad.hide()


def test_return_on_a_real_keyboard_ends_a_line_or_begins_one(window, sheet):
    click(window.control.tiles[Tile.NAME])
    click(sheet.tiles["operator"])
    QTest.keyClicks(sheet.pad.edit, "Ana")
    QTest.keyClick(sheet.pad.edit, Qt.Key_Return)
    assert sheet.texts["operator"] == "Ana"
    click(sheet.tiles["notes"])
    QTest.keyClicks(sheet.pad.edit, "a")
    QTest.keyClick(sheet.pad.edit, Qt.Key_Return)
    assert sheet.pad.edit.toPlainText() == "a\n"
    assert sheet.pad.isVisible()


def test_nothing_can_be_saved_before_something_was_changed(window, sheet, node):
    read(window, node, FOLDER, EXAMPLE)
    assert not sheet.save.isEnabled()
    write(sheet, "site", "s")
    assert sheet.save.isEnabled()


def shown_survey(window, node, annotation):
    """Open the records of the survey that runs."""
    show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY)))
    window.control.show_notes()
    assert node.of("read")[-1] == (SURVEY,)
    node.ticket("read").done(StoredSurvey(json.dumps({"annotation": annotation.values()}), 0))


def test_empty_notes_of_the_running_survey_are_filled_without_a_hold(window, node, sheet):
    shown_survey(window, node, replace(EXAMPLE, notes=""))
    write(sheet, "notes", "wet")
    click(sheet.save)
    assert asked(node) == [(SURVEY, replace(EXAMPLE, notes="wet"))]
    assert sheet.isVisible()
    node.ticket("annotate").done(verbatim("stored"))
    assert not sheet.isVisible()
    assert window.control.next_annotation.value == EMPTY


def test_notes_of_the_running_survey_that_exist_are_changed_by_a_hold(window, node, sheet):
    shown_survey(window, node, EXAMPLE)
    write(sheet, "notes", "!")
    click(sheet.save)
    assert asked(node) == []
    hold(window.annotation.confirm.hold)
    changed = replace(EXAMPLE, notes=EXAMPLE.notes + "!")
    assert asked(node) == [(SURVEY, changed)]


def test_a_stored_survey_is_changed_only_by_a_hold_that_says_old_and_new(window, node, sheet):
    confirm = window.annotation.confirm
    read(window, node, FOLDER, Annotation("Ana", name="field 3"))
    assert FOLDER in sheet.title.whole
    write(sheet, "operator", "b")
    click(sheet.save)
    shown = {str(name): str(value) for name, value in confirm.question.rows}
    assert shown == {"Survey": "field 3", "Operator": "Ana → Anab"}
    for touch in (lambda: click(confirm.hold), lambda: hold(confirm.hold, 0.9)):
        touch()
        assert asked(node) == []
    click(confirm.cancel)
    assert sheet.isVisible() and sheet.texts["operator"] == "Anab"
    click(sheet.save)
    hold(confirm.hold)
    assert asked(node) == [(FOLDER, Annotation("Anab", name="field 3"))]


def test_random_touches_never_change_the_records_of_a_stored_survey(window, node, sheet):
    draw = random.Random(4)
    parts = (sheet, sheet.pad, window.annotation.confirm)
    saves = 0
    for _ in range(600):
        if not any(part.isVisible() for part in parts):
            read(window, node, FOLDER, EXAMPLE)
        top = next(part for part in reversed(parts) if part.isVisible())
        button = draw.choice([one for one in top.findChildren(QPushButton) if one.isVisible()])
        saves += button is sheet.save and button.isEnabled()
        QTest.mouseClick(button, Qt.LeftButton)
    assert saves > 5
    assert asked(node) == []


def test_a_failure_is_said_and_loses_nothing_that_was_written(window, node, sheet):
    read(window, node, FOLDER, EMPTY)
    write(sheet, "site", "here")
    click(sheet.save)
    hold(window.annotation.confirm.hold)
    node.ticket("annotate").fail(verbatim("The disk is full"))
    assert window.notice.isVisible()
    assert window.notice.reason.toPlainText() == "The disk is full"
    click(window.notice.close_button)
    assert sheet.isVisible()
    assert sheet.texts["site"] == "here"


def test_records_that_cannot_be_read_are_said_and_those_of_an_older_survey_are_empty(window, node):
    for text in ("", "[]", '{"annotation": 1}', '{"annotation": {"site": 1}}'):
        window.annotation.read(FOLDER)
        node.ticket("read").done(StoredSurvey(text, 0))
        assert window.notice.isVisible() and not window.annotation.isVisible(), text
        click(window.notice.close_button)
    window.annotation.read(FOLDER)
    node.ticket("read").done(StoredSurvey("{}", 0))
    assert window.annotation.isVisible() and not any(window.annotation.texts.values())
