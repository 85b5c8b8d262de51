"""What a survey visits, in which order, and which parameters and sensors it may have."""

import math
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import PARAMETERS, TRAVEL
from trace_examples import make_trace

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_survey.plan.recorded_plan import (
    ImportedGrid,
    PlanFit,
    imported_grid,
    is_imported,
    measured_area,
)
from gpr20_survey.plan.robot_description import Sensors
from gpr20_survey.plan.survey_parameters import (
    check,
    find_problems,
)
from gpr20_survey.plan.survey_points import grid, survey_points, visits
from gpr20_survey.trace.sweep import AnalyzerSettings


def test_x_turns_at_every_row_and_the_antennas_at_every_stop_and_only_there():
    points = visits([0, 1, 2, 3], [0, 1, 2], [5, 6])
    assert [(point.x_mm, point.y_mm) for point in points[::2]] == [
        *[(0, 0), (1, 0), (2, 0), (3, 0)],
        *[(3, 1), (2, 1), (1, 1), (0, 1)],
        *[(0, 2), (1, 2), (2, 2), (3, 2)],
    ]
    assert [point.z_deg for point in points] == [5, 6, 6, 5] * 6


@given(st.integers(3, 12), st.integers(3, 12))
def test_every_planned_point_is_visited_once_and_one_axis_moves_at_a_time(x_points, y_points):
    parameters = replace(PARAMETERS, x_points=x_points, y_points=y_points)
    points = survey_points(parameters, TRAVEL)
    visited = {(point.x_mm, point.y_mm, point.z_deg) for point in points}
    assert len(points) == len(visited) == x_points * y_points * 2
    assert [point.index for point in points] == list(range(len(points)))
    for before, after in zip(points, points[1:]):
        moved = [before.x_mm != after.x_mm, before.y_mm != after.y_mm, before.z_deg != after.z_deg]
        assert sum(moved) == 1


def test_a_reverse_survey_visits_the_same_grid_the_other_way_round():
    turned = replace(PARAMETERS, x_start_mm=30.0, x_stop_mm=10.0, y_start_mm=35.0, y_stop_mm=5.0)
    there = {(p.x_mm, p.y_mm, p.z_deg) for p in survey_points(PARAMETERS, TRAVEL)}
    back = survey_points(turned, TRAVEL)
    assert {(p.x_mm, p.y_mm, p.z_deg) for p in back} == there
    assert (back[0].x_mm, back[0].y_mm) == (30.0, 35.0)


def test_a_grid_holds_both_ends_on_motor_steps():
    coordinates = grid(0.0, 100.0, 7, TRAVEL.x)
    assert coordinates == [0.0, 16.67, 33.33, 50.0, 66.67, 83.33, 100.0]


NAN, INF = math.nan, math.inf
WRONG_PARAMETERS = {
    "vna_address": [("192.168.1", "VNA address"), ("GPIB0::16::INSTR\n", "GPIB0::16::INSTR")],
    "start_frequency_hz": [(0.0, "start frequency", 5000), (NAN, "nan"), (6.0e9,)],
    "stop_frequency_hz": [(6.1e9, 6100000000), (500.0e6, 500000000), (600.0e6 + 2.0, 0.5)],
    "frequency_points": [(1, "frequency points", 2, 4000), (4001, "frequency points")],
    "if_bandwidth_hz": [(0.5, "IF bandwidth", 1, 10000000), (2.0e7, 20000000)],
    "averages": [(-1, "averages", 0, 65535), (65536, "averages")],
    "output_power": [("MAX", "LOW or HIGH"), ("LOW\n",)],
    "x_start_mm": [(-0.01, "x start", -0.01, 0, 650), (NAN, "x start", "nan")],
    "x_stop_mm": [(650.01, "x stop", 650.01), (INF, "x stop", "inf"), (10.0, 0.01)],
    "x_points": [(2, "x", 3), (2002, 2002, 0.009995)],
    "y_start_mm": [(800.01, "y start", 800.01, 0, 800)],
    "y_stop_mm": [(NAN, "y stop", "nan")],
    "y_points": [(0, "y", 0)],
    "polarizations_deg": [
        *(((), "number of polarizations", 1, 36), ((0.0,) * 37, "number of polarizations", 37)),
        *(((0.0, 91.0), "polarization", 91), ((NAN,), "nan"), ((0.0, 0.0),), ((0.0, 1.0), 1)),
    ],
}


@each_case(
    "field, value, shown",
    [
        (field, value, shown)
        for field, all_of in WRONG_PARAMETERS.items()
        for value, *shown in all_of
    ],
)
def test_a_wrong_parameter_is_refused_with_its_value_and_its_limits(field, value, shown):
    with raises_fault("plan.not_allowed", *shown, error=InvalidValueError):
        check(replace(PARAMETERS, **{field: value}), TRAVEL)


def test_settings_that_are_left_out_are_those_of_the_instrument():
    assert PARAMETERS.sweep_settings.analyzer == AnalyzerSettings()
    own = replace(PARAMETERS, if_bandwidth_hz=1e3, averages=4, output_power="LOW")
    assert find_problems(own, TRAVEL) == []
    assert own.sweep_settings.analyzer == AnalyzerSettings(1e3, 4, "LOW")


@given(
    st.floats(),
    st.floats(),
    st.integers(-(2**31), 2**31 - 1),
    st.lists(st.floats(), max_size=3),
)
def test_any_numbers_give_sentences_and_never_an_exception(start, stop, points, rotations):
    wild = replace(
        PARAMETERS,
        x_start_mm=start,
        x_stop_mm=stop,
        x_points=points,
        start_frequency_hz=start,
        stop_frequency_hz=stop,
        polarizations_deg=tuple(rotations),
    )
    assert all(isinstance(one.message, Message) for one in find_problems(wild, TRAVEL))
    huge = replace(PARAMETERS, x_stop_mm=650.0, x_points=1001, y_stop_mm=800.0, y_points=1001)
    assert any("2004002" in str(one.message) for one in find_problems(huge, TRAVEL))


SOIL = {"name": "soil", "topic": "probe/soil", "message": "std_msgs/Float64", "field": "data"}


def made(**changes):
    values = {**SOIL, **changes}
    return record_from(Sensors, {"sensors": [values]}, "").sensors[0]


WRONG = {
    "name": ("Soil", "", "a" * 65, "vna_temperature"),
    "topic": ("~soil", "soil moisture", ""),
    "message": ("Float64", "std_msgs/msg/Float64"),
    "field": ("data[", "a..b", "__class__.x()"),
    "unit": ("u" * 33, "\n", 5),
    "longest_age_s": (0.0, math.nan, 1e9),
    "required": ("yes",),
    "low": (math.inf,),
    "high": (math.nan,),
    "higher": (1.0,),
}


@each_case("key, value", [(key, value) for key in WRONG for value in WRONG[key]])
def test_the_message_names_a_key_or_value_that_is_wrong(key, value):
    with pytest.raises(InvalidValueError) as caught:
        made(**{key: value})
    message = caught.value.message
    assert message.fault_code in ("config.wrong", "value.not_allowed")
    assert key in str(message) or SOIL["name"] in str(message)


@each_case("key", SOIL)
def test_a_key_that_is_missing_is_named(key):
    values = {name: value for name, value in SOIL.items() if name != key}
    with raises_fault("config.wrong", f"sensors[0]/{key}", error=InvalidValueError):
        record_from(Sensors, {"sensors": [values]}, "")


def test_names_are_unique_and_sensors_few():
    assert made(field="a[12].b.c[3]").field == "a[12].b.c[3]"
    with raises_fault("config.wrong", "soil", error=InvalidValueError):
        record_from(Sensors, {"sensors": [SOIL, SOIL]}, "")
    many = [{**SOIL, "name": f"s{number}"} for number in range(33)]
    with raises_fault("config.wrong", "soil", error=InvalidValueError):
        made(low=1.0, high=1.0)
    with raises_fault("config.wrong", 33, 31, error=InvalidValueError):
        record_from(Sensors, {"sensors": many}, "")


AXIS = st.lists(st.floats(-900.0, 900.0), min_size=1, max_size=5, unique=True).map(sorted)
GRID = {"polarization_deg": [0.0, 90.0], "y_mm": [-5.0], "x_mm": [1.0, 2.5, 9.0]}


def described(**changes):
    return {"imported": {**GRID, **changes}}


@given(turns=AXIS, ys=AXIS, xs=AXIS)
def test_every_place_has_one_index_and_a_trace_fits_only_its_own(turns, ys, xs):
    description = described(polarization_deg=turns, y_mm=ys, x_mm=xs)
    assert is_imported(description)
    points = imported_grid(description).points()
    places = {(one.z_deg, one.y_mm, one.x_mm) for one in points}
    assert places == {(z, y, x) for z in turns for y in ys for x in xs}
    fit = PlanFit(description)
    for point in points:
        place = {"x_coord_mm": point.x_mm, "y_coord_mm": point.y_mm, "z_coord_deg": point.z_deg}
        assert fit.misfits(make_trace(point.index, **place)) == []
        assert fit.misfits(make_trace(len(points), **place))
        moved = {**place, "x_coord_mm": point.x_mm + 1.0}
        assert "instead of" in str(fit.misfits(make_trace(point.index, **moved))[0])


@each_case(
    "axis",
    [None, [], ["1.0"], [True], [2.0, 1.0], [1.0, 1.0], [math.nan], [1.0, math.inf], {}],
)
def test_a_grid_that_is_none_is_refused(axis):
    for name in GRID:
        with pytest.raises(InvalidValueError, match="grid of the imported survey"):
            imported_grid(described(**{name: axis}))
    for entry in (axis, {"x_mm": axis}):
        assert is_imported({"imported": entry})
        assert measured_area({"imported": entry}) is None
        with pytest.raises(InvalidValueError):
            imported_grid({"imported": entry})
    many = [float(number) for number in range(1001)]
    with pytest.raises(InvalidValueError):
        imported_grid(described(x_mm=many, y_mm=many))


def test_the_area_has_the_names_of_parameters():
    assert measured_area(described()) == {
        "polarizations_deg": [0.0, 90.0],
        **{"x_start_mm": 1.0, "x_stop_mm": 9.0, "x_points": 3},
        **{"y_start_mm": -5.0, "y_stop_mm": -5.0, "y_points": 1},
    }
    assert measured_area({"parameters": 7}) == 7
    assert imported_grid(described()) == ImportedGrid((0.0, 90.0), (-5.0,), (1.0, 2.5, 9.0))
