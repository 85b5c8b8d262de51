"""What is said before the robot moves or something is changed."""

from dataclasses import replace

from annotation_examples import annotations
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from test_fields import parameters
from view_kit import FOLDER, past_survey

from gpr20_common.message import verbatim
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.form import LONGEST_SHOWN, overwritten, preview
from gpr20_operator.plan.texts import (
    change_records_question,
    other_analyzer_question,
    plan_question,
    resume_past_question,
    resume_question,
)
from gpr20_operator.robot.events import Progress
from gpr20_operator.words import local_time
from gpr20_survey.plan.annotation import EMPTY, Annotation

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
    doubt = str(start(replace(PARAMETERS, x_points=7)).doubt)
    assert "25 mm" in doubt and "targets can be missed" in doubt and "11.4 mm" in doubt
    assert start(replace(PARAMETERS, x_points=13)).doubt is not None, "12.5 mm"
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


@each_case("question", [*MOVING, other_analyzer_question(verbatim("another VNA"))])
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
