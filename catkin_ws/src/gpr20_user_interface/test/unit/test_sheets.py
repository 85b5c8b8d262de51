"""Sheets: what is asked before the robot moves; what people add, written with fingers alone."""

import json
from dataclasses import replace
from functools import partial

import pytest
from annotation_examples import EXAMPLE
from PyQt5.QtWidgets import QPushButton
from view_kit import FOLDER, SURVEY, snapshot, state_of
from window_helpers import click, hold, press_keys, show, start, wishes

from gpr20_common.message import Message, verbatim
from gpr20_operator.jobs.pictures import StoredSurvey
from gpr20_operator.plan.fields import Tile, default_parameters
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_state import SurveyState


@pytest.fixture(autouse=True)
def idle(window):
    show(window, snapshot(SurveyState.IDLE))


@pytest.fixture
def sheet(window):
    return window.annotation


def write(sheet, name, text):
    click(sheet.tiles[name])
    assert sheet.pad.isVisible()
    press_keys(sheet.pad, text)
    click(sheet.pad.accept_button)
    assert not sheet.pad.isVisible()


def test_what_is_written_with_fingers_goes_into_the_next_survey_and_who_and_where_stay(
    window, sheet
):
    click(window.control.tiles[Tile.NAME])
    assert not sheet.save.isEnabled()
    for name in ("name", "operator", "site", "notes"):
        write(sheet, name, getattr(EXAMPLE, name))
    write(sheet, "position", "4.60283,-74.06514")
    click(sheet.tiles["position"])
    sheet.pad.edit.setPlainText("91,0")
    assert not sheet.pad.accept_button.isEnabled()
    click(sheet.pad.cancel)
    click(sheet.save)
    start(window)
    window.on_event(Answer(Request.START, False, verbatim("refused")))
    assert window.control.next_annotation.value == EXAMPLE
    window.on_event(Answer(Request.START, True, verbatim("Survey started"), SURVEY))
    click(window.control.tiles[Tile.NAME])
    write(sheet, "operator", "nobody")
    click(sheet.close_button)  # without saving
    start(window)
    after = Annotation(EXAMPLE.operator, EXAMPLE.site, name="El Carmen 4")
    assert window.survey.annotations == [EXAMPLE, after]


@pytest.mark.parametrize("survey", [SURVEY, FOLDER])
def test_records_that_exist_are_changed_only_by_a_hold_that_says_old_and_new(
    window, node, sheet, survey
):
    confirm = sheet.confirm
    if survey == SURVEY:
        show(window, snapshot(state=state_of(SurveyState.SURVEYING, survey_id=SURVEY)))
        window.control.show_notes()
    else:
        sheet.read(survey)
    assert node.of("read")[-1] == (survey,)
    records = {"annotation": Annotation("Ana", name="field 3").values()}
    node.ticket("read").done(StoredSurvey(json.dumps(records), ()))
    write(sheet, "operator", "b")
    click(sheet.save)
    shown = {str(name): str(value) for name, value in confirm.question.rows}
    assert shown == {"Survey": "field 3", "Operator": "Ana → Anab"}
    click(confirm.hold)
    hold(confirm.hold, 0.9)
    click(confirm.cancel)
    assert node.of("fact") == []
    click(sheet.save)
    hold(confirm.hold)
    # The storage keeps what others have written meanwhile.
    values = {**Annotation("Anab", name="field 3").values(), "notes_before": ""}
    assert node.of("fact") == [(survey, Kind.ANNOTATION, values)]
    # A failure is said and loses nothing that was written.
    node.ticket("fact").fail(verbatim("The disk is full"))
    assert window.notice.reason.toPlainText() == "The disk is full"
    assert sheet.isVisible() and sheet.texts["operator"] == "Anab"
    click(sheet.save)
    hold(confirm.hold)
    node.ticket("fact").done(verbatim("stored"))
    assert not sheet.isVisible()


@pytest.mark.parametrize("text", ["", "[]", '{"annotation": {"site": 1}}', "{}"])
def test_records_that_cannot_be_read_are_said_and_those_of_an_older_survey_are_empty(
    window, node, sheet, text
):
    sheet.read(FOLDER)
    node.ticket("read").done(StoredSurvey(text, ()))
    assert sheet.isVisible() is (text == "{}") is not window.notice.isVisible()
    assert not any(sheet.texts.values())


def test_the_sheet_closes_when_it_is_too_late(window):
    sheet = window.start_sheet
    idle, paused = snapshot(SurveyState.IDLE), snapshot(SurveyState.PAUSED)
    surveying = snapshot(SurveyState.SURVEYING)
    ask_start = partial(sheet.ask_start, default_parameters(), 4.0, Annotation())
    for ask, before, after in (
        (ask_start, idle, surveying),
        (ask_start, idle, replace(idle, control_alive=False)),
        (sheet.ask_resume, paused, surveying),
        (sheet.ask_resume, paused, replace(paused, pending=frozenset([Request.RESUME]))),
        (partial(sheet.ask_resume_past, FOLDER), idle, snapshot(SurveyState.CHECKING)),
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
    assert any("NOT PROVEN" in str(value) for _name, value in window.start_sheet.question.rows)
    hold(window.start_sheet.hold)
    assert wishes(window) == ["resume without proof"]
    show(window, paused)
    window.start_sheet.ask_resume()
    hold(window.start_sheet.hold)
    # Each question is answered once.
    hold(window.start_sheet.hold)
    assert wishes(window)[1:] == ["resume"]
    assert not any(one.isVisible() for one in window.start_sheet.findChildren(QPushButton))
