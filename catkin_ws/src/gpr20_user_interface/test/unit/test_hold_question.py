from dataclasses import replace

from view_kit import FOLDER, past_survey

from gpr20_operator.plan.hold_question import (
    LONGEST_NAME,
    delete_profile_question,
    other_analyzer_question,
    resume_past_question,
    resume_question,
    start_question,
)
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.preview import preview
from gpr20_operator.robot.events import Progress
from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_survey.plan.survey_cost import SurveyCost

PARAMETERS = default_parameters()
FIGURES = preview(PARAMETERS, 9.0)


def rows(question):
    return {str(name): str(value) for name, value in question.rows}


def test_start_says_area_spacing_traces_time_and_people():
    figures = replace(FIGURES, cost=SurveyCost(65.0, 1))
    question = start_question(
        PARAMETERS, figures, Annotation(operator="Ana", site="El Dorado", name="field 3")
    )
    assert rows(question) == {
        "Area": "100 x 100 mm: X 50 to 150, Y 50 to 150",
        "Spacing": "X 25 mm, Y 25 mm",
        "Traces": "50 at 25 stops",
        "Time": "about 2 min",
        "Name": "field 3",
        "Operator": "Ana",
        "Site": "El Dorado",
    }


def test_start_says_nothing_of_people_who_are_not_known():
    question = start_question(PARAMETERS, FIGURES, EMPTY)
    assert list(rows(question)) == ["Area", "Spacing", "Traces", "Time"]
    assert rows(question)["Time"] == "not known yet"


def test_resume_says_what_is_stored_and_how_long_it_takes():
    for seconds, words in (
        (0.0, "less than 1 min"),
        (60.1, "about 2 min"),
        (float("nan"), "not known yet"),
    ):
        question = resume_question(Progress("id", 50.0, 242, 121, seconds))
        assert rows(question) == {"Stored": "121 of 242 traces", "Time left": words}
    assert resume_question(None).rows == ()


def test_a_past_survey_is_named_before_it_is_resumed():
    survey = past_survey()
    assert rows(resume_past_question(FOLDER, survey)) == {
        "Survey": FOLDER,
        "Started": survey.local_time(),
        "Stored": "7 of 40 traces",
    }
    named = rows(resume_past_question(FOLDER, past_survey(name="field 3")))
    assert named["Survey"] == "field 3"
    assert rows(resume_past_question(FOLDER, None)) == {"Survey": FOLDER}


def test_whatever_moves_the_robot_warns_of_it():
    for question in (
        start_question(PARAMETERS, FIGURES, EMPTY),
        resume_question(None),
        resume_past_question(FOLDER, None),
        other_analyzer_question("Anritsu,MS2026C"),
    ):
        assert str(question.warning).startswith("Hands clear!")


def test_what_is_deleted_is_named():
    question = delete_profile_question("field-1")
    assert rows(question) == {"Profile": "field-1"}
    assert "Hands" not in str(question.warning)


def test_long_names_end_where_the_sheet_ends():
    annotation = Annotation(operator="O" * 200, site="S" * 200)
    shown = rows(start_question(PARAMETERS, FIGURES, annotation))
    assert len(shown["Operator"]) == len(shown["Site"]) == LONGEST_NAME
    assert shown["Site"].endswith("…")
