from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_survey.plan.survey_parameters import (
    RobotTravel,
    Rule,
    SurveyParameters,
    Travel,
    problems,
)
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_user_interface.mid.events import DOCUMENTED_TRAVEL
from gpr20_user_interface.mid.parameter_form import (
    ANALYZER_FIELDS,
    FIELDS,
    MAX_GRID_POINTS,
    after_arrow,
    check_form,
    limits,
    stepped,
    texts_of,
)

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


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("vna_address", "10.0.7", Rule.ADDRESS),
        ("start_frequency_hz", "0", Rule.START_FREQUENCY),
        ("start_frequency_hz", "6000", Rule.FREQUENCY_ORDER),
        ("start_frequency_hz", "-1", Rule.START_FREQUENCY),
        ("stop_frequency_hz", "6000.1", Rule.STOP_FREQUENCY),
        ("frequency_points", "4001", Rule.FREQUENCY_POINTS),
        ("frequency_points", "1", Rule.FREQUENCY_POINTS),
        ("x_start_mm", "-1", Rule.X_START),
        ("x_stop_mm", "650.01", Rule.X_STOP),
        ("x_points", "2", Rule.X_POINTS),
        ("x_points", "20000", Rule.X_SPACING),
        ("y_start_mm", "801", Rule.Y_START),
        ("y_stop_mm", "800.5", Rule.Y_STOP),
        ("y_points", "0", Rule.Y_POINTS),
        ("polarizations_deg", "0, 91", Rule.POLARIZATIONS),
        ("polarizations_deg", "0, 0", Rule.POLARIZATIONS),
        ("if_bandwidth_hz", "0.5", Rule.IF_BANDWIDTH),
        ("if_bandwidth_hz", "-10", Rule.IF_BANDWIDTH),
        ("averages", "65536", Rule.AVERAGES),
        ("output_power", "LOW POWER", Rule.OUTPUT_POWER),
    ],
)
def test_field_with_a_wrong_value_is_marked_with_the_rule_it_breaks(name, text, rule):
    result = check(**{name: text})
    assert result.wrong_fields == (name,)
    assert rule in result.broken
    assert result.parameters is None


@pytest.mark.parametrize("field", FIELDS[1:-1], ids=lambda field: field.name)
@pytest.mark.parametrize("text", ["", "abc", "1 2"])
def test_field_that_cannot_be_read_is_marked_and_locks_the_start(field, text):
    result = check(**{field.name: text})
    if field.name in ANALYZER_FIELDS and not text:
        assert result.parameters is not None
        return
    assert (result.wrong_fields, result.broken) == ((field.name,), ())
    assert result.parameters is None


def test_empty_settings_of_the_vna_leave_it_as_it_is():
    for blank in ("", " "):
        result = check(if_bandwidth_hz=blank, averages=blank, output_power=blank)
        assert not result.parameters.sweep_settings.analyzer.is_known
    result = check(if_bandwidth_hz="1000", averages="16", output_power="LOW")
    assert result.parameters.sweep_settings.analyzer == AnalyzerSettings(1000.0, 16, "LOW")


@pytest.mark.parametrize(
    ("name", "text", "change", "expected"),
    [
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
    ],
)
def test_arrows_choose_among_the_values_of_the_vna(name, text, change, expected):
    assert after_arrow(name, text, change, ROBOT) == expected
    assert check(**{name: expected}).parameters is not None


def test_frequencies_closer_than_a_hertz_are_a_fault_of_their_number():
    result = check(start_frequency_hz="600", stop_frequency_hz="600.0004")
    assert result.wrong_fields == ("frequency_points",)
    assert result.broken == (Rule.FREQUENCY_SPACING,)


@pytest.mark.parametrize("text", ["3.5", "-3", "1_0", "٣", "inf"])
def test_points_are_whole_numbers(text):
    assert check(x_points=text).unreadable == ("x_points",)


@pytest.mark.parametrize("text", ["inf", "nan", "-inf"])
def test_coordinates_are_finite(text):
    assert check(x_start_mm=text).wrong_fields == ("x_start_mm",)


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


@pytest.mark.parametrize("text", ["\x1f5", " 5 ", "9" * 5000])
def test_whole_number_between_blanks_or_far_too_long_is_no_crash(text):
    result = check(x_points=text)
    assert result.unreadable == (() if len(text) < 9 else ("x_points",))


def test_texts_of_parameters_are_read_back_as_the_same_parameters():
    parameters = check(start_frequency_hz="700.123456", x_stop_mm="150.01").parameters
    assert check_form(texts_of(parameters), ROBOT).parameters == parameters
    settings = {"if_bandwidth_hz": 12345.5, "averages": 3, "output_power": "-10.5dBm"}
    others = replace(parameters, **settings)
    assert check_form(texts_of(others), ROBOT).parameters == others


@pytest.mark.parametrize(
    ("text", "change", "expected"),
    [
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
    ],
)
def test_arrow_changes_a_number_within_its_bounds(text, change, expected):
    assert stepped(text, change, (0.0, 650.0)) == expected


@given(st.text(max_size=8), st.sampled_from([-100, -10, -1, 1, 10, 100]))
def test_arrow_makes_an_allowed_number_of_any_text(text, change):
    assert 0.0 <= float(stepped(text, change, (0.0, 650.0))) <= 650.0


@pytest.mark.parametrize(
    "field",
    [one for one in FIELDS[1:] if one.name != "polarizations_deg" and not one.choices],
    ids=lambda field: field.name,
)
def test_limits_that_are_shown_are_those_that_are_checked(field):
    lower, upper = limits(field.name, ROBOT)
    assert not field.rules & set(check(**{field.name: f"{lower:g}"}).broken) - {
        Rule.FREQUENCY_ORDER
    }
    below = check(**{field.name: f"{lower - 1:g}"})
    assert field.name in below.wrong_fields
    if upper != MAX_GRID_POINTS:
        assert field.name in check(**{field.name: f"{upper + 1:g}"}).wrong_fields


@pytest.mark.parametrize(
    ("texts", "value"),
    [
        ({"x_stop_mm": "149,5"}, 149.5),
        ({"y_start_mm": ",5"}, 0.5),
        ({"start_frequency_hz": "700,123456"}, 700123456.0),
        ({"if_bandwidth_hz": "12,5"}, 12.5),
        ({"polarizations_deg": "1,8; 90"}, (1.8, 90.0)),
    ],
)
def test_a_decimal_comma_is_read_as_a_point(texts, value):
    (name,) = texts
    assert getattr(check(**texts).parameters, name) == value
