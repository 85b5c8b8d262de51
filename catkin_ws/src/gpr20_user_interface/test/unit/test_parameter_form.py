from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from gpr20_operator.plan.fields import (
    ANALYZER_FIELDS,
    FIELDS,
    MAX_GRID_POINTS,
    after_arrow,
    check_form,
    limits,
    stepped,
    texts_of,
)
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_survey.plan.survey_parameters import (
    RobotTravel,
    Rule,
    SurveyParameters,
    Travel,
    problems,
)
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

DEFAULTS = {field.name: field.default for field in FIELDS}
ROBOT = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


def check(travel=ROBOT, **texts):
    return check_form({**DEFAULTS, **texts}, travel)


def test_form_has_every_parameter_of_a_survey():
    assert [field.name for field in FIELDS] == list(SurveyParameters.__dataclass_fields__)


def test_defaults_can_be_started():
    result = check()
    assert (result.wrong_fields, result.broken) == ((), ())
    assert result.parameters.start_frequency_hz == 600e6
    assert result.parameters.polarizations_deg == (0.0, 90.0)


def test_field_that_cannot_be_read_is_marked_and_locks_the_start():
    texts = {field.name: ["", "abc", "1 2"] for field in FIELDS[1:-1]}
    texts["x_points"] += ["3.5", "-3", "1_0", "٣", "inf", "9" * 5000]
    for name, text in ((one, text) for one in texts for text in texts[one]):
        result = check(**{name: text})
        if name in ANALYZER_FIELDS and not text:
            assert result.parameters is not None
        else:
            assert (result.wrong_fields, result.broken) == ((name,), ()), text
            assert result.parameters is None


def test_empty_settings_of_the_vna_leave_it_as_it_is():
    for blank in ("", " "):
        result = check(if_bandwidth_hz=blank, averages=blank, output_power=blank)
        assert not result.parameters.sweep_settings.analyzer.is_known
    result = check(if_bandwidth_hz="1000", averages="16", output_power="LOW")
    assert result.parameters.sweep_settings.analyzer == AnalyzerSettings(1000.0, 16, "LOW")


def test_arrows_choose_among_the_values_of_the_vna():
    for name, text, change, expected in (
        ("if_bandwidth_hz", "", 1, "10"),
        ("if_bandwidth_hz", "", -1, ""),
        ("if_bandwidth_hz", "10000", 100, "20000"),
        ("if_bandwidth_hz", "100000", 1, "100000"),
        ("if_bandwidth_hz", "30000", 1, ""),
        ("averages", "", 1, "1"),
        ("averages", "", 10, "10"),
        ("averages", "10", -10, ""),
        ("averages", "65535", 1, "65535"),
        ("output_power", "", 1, "LOW"),
        ("output_power", "LOW", 10, "HIGH"),
        ("output_power", "LOW", -1, ""),
        ("x_points", "5", 1, "6"),
    ):
        assert after_arrow(name, text, change, ROBOT) == expected, (name, text)
        assert check(**{name: expected}).parameters is not None


def test_frequencies_closer_than_a_hertz_are_a_fault_of_their_number():
    result = check(start_frequency_hz="600", stop_frequency_hz="600.0004")
    assert result.wrong_fields == ("frequency_points",)
    assert result.broken == (Rule.FREQUENCY_SPACING,)


def test_several_wrong_fields_are_all_marked_in_their_order():
    result = check(y_points="x", vna_address="1.2", x_stop_mm="900")
    assert result.wrong_fields == ("vna_address", "x_stop_mm", "y_points")


def test_too_many_points_in_all_are_a_fault_of_both_axes():
    result = check(x_points="1000", y_points="1000")
    assert (result.parameters, result.broken) == (None, (Rule.SIZE,))
    assert result.wrong_fields == ("x_points", "y_points")


def test_limits_are_those_of_the_axes_that_are_given():
    assert check(DOCUMENTED_TRAVEL, x_stop_mm="700").parameters is not None
    assert check(ROBOT, x_stop_mm="700").parameters is None


@given(st.fixed_dictionaries({field.name: st.text(max_size=8) for field in FIELDS}))
def test_any_text_is_answered_with_good_parameters_or_a_sentence(texts):
    result = check_form(texts, ROBOT)
    assert (result.parameters is None) == bool(result.unreadable or result.broken)
    assert result.parameters is None or problems(result.parameters, ROBOT) == []


def test_whole_number_between_blanks_is_read():
    for text in ("\x1f5", " 5 "):
        assert check(x_points=text).parameters.x_points == 5


def test_texts_of_parameters_are_read_back_as_the_same_parameters():
    parameters = check(start_frequency_hz="700.123456", x_stop_mm="150.01").parameters
    assert check_form(texts_of(parameters), ROBOT).parameters == parameters
    settings = {"if_bandwidth_hz": 12345.5, "averages": 3, "output_power": "-10.5dBm"}
    others = replace(parameters, **settings)
    assert check_form(texts_of(others), ROBOT).parameters == others


def test_arrow_changes_a_number_within_its_bounds():
    for text, change, expected in (
        ("50", 10, "60"),
        ("50.25", -1, "49.25"),
        ("0.1", 1, "1.1"),
        ("600", 100, "650"),
        ("50", -100, "0"),
        ("700", 10, "650"),
        ("", 1, "0"),
        ("nan", 1, "0"),
        ("-inf", 1, "0"),
        ("-1e999999999", 1, "0"),
        ("100", 100, "200"),
    ):
        assert stepped(text, change, (0.0, 650.0)) == expected, text


@given(st.text(max_size=8), st.sampled_from([-100, -10, -1, 1, 10, 100]))
def test_arrow_makes_an_allowed_number_of_any_text(text, change):
    assert 0.0 <= float(stepped(text, change, (0.0, 650.0))) <= 650.0


def test_limits_that_are_shown_are_those_that_are_checked():
    for field in FIELDS[1:]:
        if field.name == "polarizations_deg" or field.choices:
            continue
        lower, upper = limits(field.name, ROBOT)
        allowed = check(**{field.name: f"{lower:g}"})
        assert not field.rules & set(allowed.broken) - {Rule.FREQUENCY_ORDER}, field.name
        assert field.name in check(**{field.name: f"{lower - 1:g}"}).wrong_fields
        if upper != MAX_GRID_POINTS:
            assert field.name in check(**{field.name: f"{upper + 1:g}"}).wrong_fields


def test_a_decimal_comma_is_read_as_a_point():
    for name, text, value in (
        ("x_stop_mm", "149,5", 149.5),
        ("y_start_mm", ",5", 0.5),
        ("start_frequency_hz", "700,123456", 700123456.0),
        ("if_bandwidth_hz", "12,5", 12.5),
        ("polarizations_deg", "1,8; 90", (1.8, 90.0)),
    ):
        assert getattr(check(**{name: text}).parameters, name) == value
