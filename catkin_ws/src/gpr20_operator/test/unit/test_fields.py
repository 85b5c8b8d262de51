"""Every field of a plan: text and value, limits, arrows, presets; what follows from what."""

import re
from dataclasses import replace

import pytest
from annotation_examples import annotations
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from view_kit import TRAVEL as ROBOT
from view_kit import configured, past_survey, snapshot

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_operator.ground.past_surveys import PastSurveys
from gpr20_operator.plan.fields import (
    PARAMETERS,
    PEOPLE,
    PLAN,
    SPECS,
    TILE_FIELDS,
    Keys,
    Tile,
    default_parameters,
    texts_of,
)
from gpr20_operator.plan.form import (
    PlanForm,
    annotation_from,
    annotation_texts,
    points_for,
    preview,
)
from gpr20_operator.plan.texts import resumable, spacing_warning
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_operator.words import (
    duration,
    hertz_from_megahertz,
    megahertz_text,
    number_from_text,
    rotations_from_text,
)
from gpr20_survey.plan.annotation import Wgs84Position
from gpr20_survey.plan.recorded_plan import IMPORTED
from gpr20_survey.plan.survey_parameters import SurveyParameters, find_problems
from gpr20_survey.plan.survey_points import survey_cost
from gpr20_survey.plan.survey_state import SurveyState

DEFAULTS = {spec.name: spec.default for spec in PLAN}


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


def test_the_plan_has_every_parameter_of_a_survey_and_every_field_is_on_one_tile():
    assert {spec.name for spec in PARAMETERS} == set(SurveyParameters.__dataclass_fields__)
    shown = [name for tile in Tile for name in TILE_FIELDS[tile]]
    assert sorted([*shown, "x_points", "y_points"]) == sorted(SPECS)
    for spec in (*PLAN, *PEOPLE):
        assert str(spec.title) and str(spec.hint(ROBOT)) and spec.kind.keys in Keys


def test_the_plan_of_a_new_robot_and_every_preset_can_be_started():
    result = check()
    assert (result.problems, result.parameters) == ({}, default_parameters())
    assert result.permittivity == 4.0
    assert find_problems(default_parameters(), ROBOT) == []
    assert spacing_warning(preview(result.parameters, result.permittivity)) is None
    assert 1200.0 < cost_of(result.parameters).duration_s < 1800.0
    for spec in PLAN:
        found = spec.presets(ROBOT, 11.37)
        assert bool(found) is (spec.tile is not None), spec.name
        for preset in found:
            form = PlanForm(ROBOT)
            form.set_texts(preset.texts)
            assert form.check().problems == {}, preset


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


WRONG = (
    ("vna_address", "10.0.0.256", "four whole numbers"),
    ("start_frequency_hz", "0", "from 0.005 to 6000"),
    ("start_frequency_hz", "6000", "below the stop frequency"),
    ("stop_frequency_hz", "6GHz", "a number such as 12.5"),
    ("frequency_points", "1.5", "a whole number from 2 to 4000"),
    ("x_start_mm", "-1", "from 0 to 650"),
    *(("x_start_mm", text, "a number such as 12.5") for text in ("nan", "-inf", "1e400")),
    ("x_spacing_mm", "0", "above 0"),
    ("y_spacing_mm", "x", "a number such as 12.5"),
    ("permittivity", "100", "from 1 to 81"),
    ("polarizations_deg", "0, 91", "from -90 to 90"),
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


@each_case(
    "read, texts",
    [
        (number_from_text, ["", ",", "1.2.3", "1,234.5", "1.234,5", "1_0", "٣", "nan", "inf"]),
        (number_from_text, ["0x1", "1 2", "--1", "600 MHz"]),
        (hertz_from_megahertz, ["-inf", "1,5,0", "sNaN"]),
        (rotations_from_text, ["", "zero"]),
        (lambda part: rotations_from_text(f"0,{part},90"), ["", "x"]),
    ],
)
def test_what_is_no_number_is_refused(read, texts):
    for text in texts:
        with raises_fault(NOT_ALLOWED, text, error=InvalidValueError):
            read(text)


@given(st.floats(-1e4, 1e4), st.integers(1, 6_000_000_000))
def test_any_number_is_read_with_either_mark_and_every_whole_hertz_can_be_written(number, hertz):
    text = repr(number)
    assert number_from_text(text.replace(".", ",")) == number_from_text(text) == number
    assert hertz_from_megahertz(f"{hertz // 10**6}.{hertz % 10**6:06d}") == hertz
    assert hertz_from_megahertz(megahertz_text(hertz)) == hertz


CONFIGURED = configured()


@pytest.fixture
def form():
    return PlanForm(ROBOT)


def cost_of(parameters):
    return survey_cost(parameters, CONFIGURED.config, CONFIGURED.settings)


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
    form.show_parameters(replace(default_parameters(), **ends))
    assert form.texts[points] == str(count)
    # The spacing gives the same points again.
    form.set_text(f"{axis}_stop_mm", form.texts[f"{axis}_stop_mm"])
    assert form.texts[points] == str(count)
    form.set_texts({f"{axis}_stop_mm": "wrong", f"{axis}_spacing_mm": "10"})
    assert form.texts[points] == str(count)
    form.set_texts({f"{axis}_start_mm": "0", f"{axis}_stop_mm": "305"})
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


DAY_S = 86400


@given(st.integers(min_value=60, max_value=400 * DAY_S))
def test_a_time_is_rounded_up_by_less_than_its_last_unit(time_s):
    assert str(duration(-3)) == str(duration(59.9)) == "less than 1 min"
    words = str(duration(time_s))
    units = {"d": DAY_S, "h": 3600, "min": 60}
    parts = re.findall(r"(\d+) (d|h|min)", words)
    said_s = sum(int(number) * units[unit] for number, unit in parts)
    assert 0 <= said_s - time_s < units[parts[-1][1]]
