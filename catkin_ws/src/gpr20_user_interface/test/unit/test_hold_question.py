"""What is said before the robot moves or something is changed, and the sheets to hold for."""

from dataclasses import replace

from annotation_examples import annotations
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from PyQt5.QtWidgets import QLabel, QPushButton
from test_fields import parameters
from view_kit import FOLDER, past_survey, snapshot
from window_helpers import click, hold, show, wishes

from gpr20_common.message import Message
from gpr20_operator.plan.annotation import LONGEST_SHOWN, overwritten
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.form import SurveyPreview, preview
from gpr20_operator.plan.hold_question import (
    change_records_question,
    other_analyzer_question,
    plan_question,
    resume_past_question,
    resume_question,
)
from gpr20_operator.robot.events import Progress, Request
from gpr20_operator.words import local_time
from gpr20_survey.faults import OTHER_ZEROS
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_points import SurveyCost
from gpr20_survey.plan.survey_state import SurveyState

PARAMETERS = default_parameters()


def rows(question):
    return {str(name): str(value) for name, value in question.rows}


def start(measured=PARAMETERS, permittivity=4.0, annotation=EMPTY):
    return plan_question(measured, permittivity, preview(measured, permittivity), annotation)


@given(parameters(), st.floats(1.0, 81.0), annotations)
def test_start_shows_every_parameter_of_any_plan(measured, permittivity, annotation):
    said = rows(start(measured, permittivity, annotation))
    titles = ["Where", "How close", "Soil", "Radar", "Antennas", "VNA", "Name", "Traces", "Time"]
    assert [one for one in said if one != "Name"] == [one for one in titles if one != "Name"]
    shown = " ".join(said.values())
    ends = (measured.x_start_mm, measured.x_stop_mm, measured.y_start_mm, measured.y_stop_mm)
    bandwidth = measured.if_bandwidth_hz and f"{measured.if_bandwidth_hz:.12g} Hz"
    people = (annotation.name, annotation.operator, annotation.site)
    named = [
        *(f"{end:.5g}" for end in ends),
        f"{measured.x_points} x {measured.y_points}",
        f"{measured.start_frequency_hz / 1e6:.12g}",
        f"{measured.stop_frequency_hz / 1e6:.12g}",
        f"{measured.frequency_points} points",
        *(f"{one:.12g}" for one in measured.polarizations_deg),
        *(measured.vna_address, bandwidth or "", measured.output_power),
        *([f"{measured.averages} x"] if measured.averages else []),
        f"permittivity {permittivity:.12g}",
        *(" ".join(one.split())[: LONGEST_SHOWN - 1] for one in people),
    ]
    missing = [one for one in named if one not in shown]
    assert not missing, (missing, shown)


def test_a_coarse_plan_is_said_in_words():
    doubt = str(start(replace(PARAMETERS, x_points=5)).doubt)
    assert "25 mm" in doubt and "targets can be missed" in doubt and "11.4 mm" in doubt
    assert start().doubt is None


def test_resume_says_what_is_stored_and_how_long_it_takes():
    for seconds, words in ((60.1, "about 2 min"), (float("nan"), "not known yet")):
        question = resume_question(Progress("id", 50.0, 242, 121, seconds))
        assert rows(question) == {"Stored": "121 of 242 traces", "Time left": words}


def test_a_past_survey_is_named_before_it_is_resumed():
    survey = past_survey(name="field 3", width_mm=300.0, height_mm=250.0)
    assert rows(resume_past_question(FOLDER, survey)) == {
        "Survey": "field 3",
        "Started": str(local_time(survey.started, survey.folder)),
        "Stored": "7 of 40 traces",
        "Area": "300 x 250 mm",
        "Plan": "that of the survey, not the one on this page",
    }
    for unnamed in (past_survey(), None):
        assert rows(resume_past_question(FOLDER, unnamed))["Survey"] == FOLDER


MOVING = (start(), resume_question(None), resume_past_question(FOLDER, None))


@each_case("question", [*MOVING, other_analyzer_question("Anritsu,MS2026C")])
def test_whatever_moves_the_robot_says_what_moves(question):
    warning = str(question.warning)
    assert warning.startswith("Hands clear!") and "X, Y and the antennas move" in warning


def test_what_is_changed_is_named_as_it_was_and_will_be():
    before = Annotation("Ana", "El Carmen", "wet", name="field 3")
    question = change_records_question("field 3", before, replace(before, operator="", notes="dry"))
    assert rows(question) == {"Survey": "field 3", "Operator": "Ana → —", "Notes": "wet → dry"}


@given(st.text("abc", min_size=20, max_size=60), st.text("x", min_size=1), st.text("u"))
def test_the_old_and_the_new_text_never_look_the_same(same, old, new):
    ((_title, text),) = overwritten(Annotation(notes=same + old), Annotation(notes=same + new))
    shown_old, shown_new = str(text).split(" → ")
    assert shown_old != shown_new


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
