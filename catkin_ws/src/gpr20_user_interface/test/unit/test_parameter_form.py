import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_main_control.mid.survey_parameters import RobotTravel, SurveyParameters, Travel, problems
from gpr20_user_interface.mid.parameter_form import FIELDS, check_form
from gpr20_user_interface.mid.survey_state import DOCUMENTED_TRAVEL

DEFAULTS = {field.name: field.default for field in FIELDS}
ROBOT = RobotTravel(Travel(0.0, 650.0, 0.01), Travel(0.0, 800.0, 0.01), Travel(-90.0, 90.0, 1.8))


def check(travel=ROBOT, **texts):
    return check_form({**DEFAULTS, **texts}, travel)


def test_form_has_every_parameter_of_a_survey():
    assert [field.name for field in FIELDS] == list(SurveyParameters.__dataclass_fields__)


def test_defaults_can_be_started():
    result = check()
    assert result.sentences == ()
    assert result.parameters.start_frequency_hz == 600e6
    assert result.parameters.polarizations_deg == (0.0, 90.0)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("vna_address", "10.0.7", "four numbers"),
        ("start_frequency_hz", "0", "between"),
        ("start_frequency_hz", "6000", "below the stop frequency"),
        ("start_frequency_hz", "nan", "between"),
        ("stop_frequency_hz", "6000.1", "between"),
        ("frequency_points", "4001", "between 2 and 4000"),
        ("frequency_points", "1", "between 2 and 4000"),
        ("x_start_mm", "-1", "between 0 and 650 mm"),
        ("x_start_mm", "inf", "between 0 and 650 mm"),
        ("x_stop_mm", "650.01", "between 0 and 650 mm"),
        ("x_points", "2", "more than 2"),
        ("y_start_mm", "801", "between 0 and 800 mm"),
        ("y_stop_mm", "nan", "between 0 and 800 mm"),
        ("y_points", "0", "more than 2"),
        ("polarizations_deg", "0, 91", "between -90 and 90 deg"),
        ("polarizations_deg", "0, 0", "a rotation of its own"),
    ],
)
def test_field_with_a_wrong_value_is_marked_and_says_what_is_allowed(name, text, words):
    result = check(**{name: text})
    assert list(result.field_problems) == [name]
    assert words in result.field_problems[name]
    assert result.parameters is None


@pytest.mark.parametrize("field", FIELDS[1:], ids=lambda field: field.name)
@pytest.mark.parametrize("text", ["", "abc", "1 2"])
def test_field_that_cannot_be_read_is_marked_and_locks_the_start(field, text):
    result = check(**{field.name: text})
    assert list(result.field_problems) == [field.name]
    assert result.parameters is None


def test_points_are_whole_numbers():
    assert "not a whole number" in check(x_points="3.5").field_problems["x_points"]


def test_several_wrong_fields_are_all_marked_in_their_order():
    result = check(y_points="x", vna_address="", x_stop_mm="900")
    assert list(result.field_problems) == ["vna_address", "x_stop_mm", "y_points"]


def test_fault_of_no_single_field_locks_the_start_too():
    result = check(x_points="1000", y_points="1000")
    assert result.parameters is None
    assert dict(result.field_problems) == {}
    assert "number of traces" in result.other_problems[0]


def test_limits_are_those_of_the_axes_that_are_given():
    assert check(DOCUMENTED_TRAVEL, x_stop_mm="700").parameters is not None
    assert check(ROBOT, x_stop_mm="700").parameters is None


@given(st.fixed_dictionaries({field.name: st.text(max_size=8) for field in FIELDS}))
def test_any_text_is_answered_with_good_parameters_or_a_sentence(texts):
    result = check_form(texts, ROBOT)
    assert (result.parameters is None) == bool(result.sentences)
    assert result.parameters is None or problems(result.parameters, ROBOT) == []
