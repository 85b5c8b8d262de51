"""A plan: text, value and bounds of each field, what follows from what, and what START asks."""

from dataclasses import replace

from annotation_examples import annotations
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from view_kit import FOLDER, past_survey, snapshot
from view_kit import TRAVEL as ROBOT

from gpr20_common.message import verbatim
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.fields import PLAN, SPECS, default_parameters, texts_of
from gpr20_operator.plan.form import (
    LONGEST_SHOWN,
    PlanForm,
    annotation_from,
    annotation_texts,
    points_for,
    preview,
)
from gpr20_operator.plan.texts import (
    other_analyzer_question,
    plan_question,
    resumable,
    resume_past_question,
    resume_question,
)
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_survey.plan.annotation import EMPTY, Wgs84Position
from gpr20_survey.plan.recorded_plan import IMPORTED
from gpr20_survey.plan.survey_parameters import SurveyParameters, find_problems
from gpr20_survey.plan.survey_state import SurveyState

DEFAULT = default_parameters()


def check(travel=ROBOT, **texts):
    form = PlanForm(travel)
    form.restore(texts)
    return form.check()


@st.composite
def parameters(draw):
    def rounded(lower, upper):
        return st.floats(lower, upper).map(lambda value: float(f"{value:.12g}"))

    def axis(upper):
        start = draw(rounded(0.0, upper - 10.0))
        return start, draw(rounded(start + 5.0, upper)), draw(st.integers(3, 300))

    start_hz = float(draw(st.integers(5000, 5_000_000_000)))
    stop_hz = start_hz + draw(st.integers(1_000_000, 999_000_000))
    x, y = axis(650.0), axis(800.0)
    steps = draw(st.lists(st.integers(-50, 50), min_size=1, max_size=6, unique=True))
    return SurveyParameters(
        draw(st.sampled_from(["", "10.0.0.7", "192.168.100.100"])),
        *(start_hz, stop_hz, draw(st.integers(2, 4000))),
        *(*x, *y),
        tuple(float(f"{step * 1.8:.12g}") for step in steps),
        draw(st.sampled_from([0.0, 10.0, 12345.5])),
        draw(st.integers(0, 65535)),
        draw(st.sampled_from(["", "LOW", "HIGH", "-10.5dBm"])),
    )


def test_the_plan_of_a_new_robot_can_be_started():
    result = check()
    assert (result.problems, result.parameters, result.permittivity) == ({}, DEFAULT, 4.0)
    assert find_problems(DEFAULT, ROBOT) == []


@given(parameters(), annotations)
def test_texts_are_read_back_as_the_same(wanted, annotation):
    assert find_problems(wanted, ROBOT) == []
    assert check(**texts_of(wanted)).parameters == wanted
    assert annotation_from(annotation_texts(annotation)) == annotation


@given(st.fixed_dictionaries({spec.name: st.text(max_size=8) for spec in PLAN}))
def test_any_text_is_answered_with_good_parameters_or_a_sentence(texts):
    result = check(**texts)
    assert (result.parameters is None) == bool(result.problems)
    assert result.parameters is None or find_problems(result.parameters, ROBOT) == []


NO_NUMBERS = (
    *("", ",", "1.2.3", "1,234.5", "1.234,5", "1_0", "٣", "nan", "-inf", "1e400"),
    *("0x1", "1 2", "--1", "600 MHz"),
)
WRONG = (
    ("vna_address", "10.0.0.256", "four whole numbers"),
    ("start_frequency_hz", "0", "from 0.005 to 6000"),
    ("start_frequency_hz", "6000", "below the stop frequency"),
    ("stop_frequency_hz", "6GHz", "a number such as 12.5"),
    ("frequency_points", "1.5", "a whole number from 2 to 4000"),
    ("x_start_mm", "-1", "from 0 to 650"),
    *(("x_start_mm", text, "a number such as 12.5") for text in NO_NUMBERS),
    ("x_spacing_mm", "0", "above 0"),
    ("y_spacing_mm", "x", "a number such as 12.5"),
    ("permittivity", "100", "from 1 to 81"),
    *(("polarizations_deg", text, "from -90 to 90") for text in ("0, 91", "0,,90", "0, x", "")),
    ("polarizations_deg", "0, 0", "different"),
    ("if_bandwidth_hz", "-10", "from 1 to 10000000"),
    ("averages", "65536", "a whole number from 1 to 65535"),
    ("output_power", "a b", "LOW or HIGH for the MS2026C"),
)


@each_case("name,text,words", WRONG)
def test_what_is_wrong_is_named_and_locks(name, text, words):
    result = check(**{name: text})
    assert words in str(result.problems[name])
    assert result.parameters is None and set(result.problems) == {name}


def test_what_several_fields_or_the_axes_make_wrong_is_named_on_them():
    assert check(DOCUMENTED_TRAVEL, x_stop_mm="700").parameters is not None
    assert list(check(ROBOT, x_stop_mm="700").problems) == ["x_stop_mm"]
    for points, words in (("1000", "1000000"), ("90000", "0.01 mm")):
        found = check(x_points=points, y_points=points).problems
        assert list(found) == ["x_spacing_mm", "y_spacing_mm"]
        assert all(words in str(one) for one in found.values())
    result = check(start_frequency_hz="600", stop_frequency_hz="600.0004")
    assert list(result.problems) == ["frequency_points"]


def test_a_decimal_comma_is_read_as_a_point():
    for name, text, value in (
        *(("x_stop_mm", " 149,50 ", 149.5), ("if_bandwidth_hz", "+1,2E+1", 12.0)),
        *(("polarizations_deg", text, (1.8, -90.0)) for text in ("1,8; -90", "1.8,-90")),
        ("position", "4,60283; -74,06514", Wgs84Position(4.60283, -74.06514)),
    ):
        assert SPECS[name].kind.read(text) == value


@given(st.floats(0.5, 60.0), st.floats(1.0, 800.0))
def test_no_two_points_are_farther_apart_than_the_spacing(spacing_mm, length_mm):
    count = points_for(length_mm, spacing_mm)
    assert length_mm / (count - 1) <= spacing_mm * 1.00002
    assert count == 3 or length_mm / (count - 2) > spacing_mm


@given(st.sampled_from("xy"), st.integers(0, 300), st.floats(301.0, 650.0), st.integers(3, 9999))
def test_parameters_are_measured_as_they_are_and_points_follow_spacing_and_area(
    axis, start, stop, count
):
    form = PlanForm(ROBOT)
    points, stop = f"{axis}_points", float(f"{stop:.2f}")
    ends = {f"{axis}_start_mm": start, f"{axis}_stop_mm": stop, points: count}
    form.show_parameters(replace(DEFAULT, **ends))
    assert form.texts[points] == str(count)
    # The spacing gives the same points again.
    form.set_text(f"{axis}_stop_mm", form.texts[f"{axis}_stop_mm"])
    assert form.texts[points] == str(count)
    form.set_texts({f"{axis}_start_mm": "0", f"{axis}_stop_mm": "305", f"{axis}_spacing_mm": "10"})
    assert form.texts[points] == "32"


def test_only_the_last_survey_is_offered_and_only_if_it_ended_early_and_can_be_resumed():
    idle, early, older = snapshot(SurveyState.IDLE), past_survey(), past_survey(folder="2025")
    complete, imported = past_survey(complete=True), past_survey(outcome=IMPORTED, folder="2027")
    for listed, expected in (((), None), ((imported, early), early), ((complete, older), None)):
        past = PastSurveys()
        past.take("", listed, False)
        assert resumable(past, idle) == expected
        for other in (None, snapshot(SurveyState.IDLE, alive=False), snapshot(SurveyState.HOMING)):
            assert resumable(past, other) is None
        past.set_running("another")
        assert resumable(past, idle) is None
    said = [str(value) for _title, value in resume_past_question(FOLDER, early).rows]
    assert FOLDER in said and "7 of 40 traces" in said


def start(measured=DEFAULT, permittivity=4.0, annotation=EMPTY):
    return plan_question(measured, permittivity, preview(measured, permittivity), annotation)


@given(parameters(), st.floats(1.0, 81.0), annotations)
def test_start_shows_every_parameter_of_any_plan(measured, permittivity, annotation):
    shown = " ".join(str(value) for _, value in start(measured, permittivity, annotation).rows)
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
    doubt = str(start(replace(DEFAULT, x_points=7)).doubt)
    assert "25 mm" in doubt and "targets can be missed" in doubt and "11.4 mm" in doubt
    assert start(replace(DEFAULT, x_points=13)).doubt is not None, "12.5 mm"
    assert start().doubt is None


QUESTIONS = (start(), resume_question(None), resume_past_question(FOLDER, None))


@each_case("question", [*QUESTIONS, other_analyzer_question(verbatim("another VNA"))])
def test_whatever_moves_the_robot_says_what_moves(question):
    warning = str(question.warning)
    assert warning.startswith("Hands clear!") and "X, Y and the antennas move" in warning
