"""Imported surveys have the places of their source, and no plan."""

import math

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from trace_examples import make_trace

from gpr20_common.errors import InvalidValueError
from gpr20_survey.plan.imported import (
    ImportedFit,
    ImportedGrid,
    imported_grid,
    is_imported,
    measured_area,
)
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace_definition import TRACE_DEFINITION

AXIS = st.lists(st.floats(-900.0, 900.0), min_size=1, max_size=5, unique=True).map(sorted)
GRID = {"polarization_deg": [0.0, 90.0], "y_mm": [-5.0], "x_mm": [1.0, 2.5, 9.0]}


def described(**changes):
    return {"imported": {**GRID, **changes}}


def test_the_definition_of_a_trace_has_the_checksum_of_its_message():
    types = get_typestore(Stores.ROS1_NOETIC)
    types.register(get_types_from_msg(TRACE_DEFINITION, "gpr20_msgs/msg/Trace"))
    assert types.generate_msgdef("gpr20_msgs/msg/Trace")[1] == trace_message.MD5SUM


@given(turns=AXIS, ys=AXIS, xs=AXIS)
def test_every_place_has_one_index_and_a_trace_fits_only_its_own(turns, ys, xs):
    description = described(polarization_deg=turns, y_mm=ys, x_mm=xs)
    assert is_imported(description)
    points = imported_grid(description).points()
    places = {(one.z_deg, one.y_mm, one.x_mm) for one in points}
    assert places == {(z, y, x) for z in turns for y in ys for x in xs}
    fit = ImportedFit(description)
    for point in points:
        place = {"x_coord_mm": point.x_mm, "y_coord_mm": point.y_mm, "z_coord_deg": point.z_deg}
        assert fit.misfits(make_trace(point.index, **place)) == []
        assert fit.misfits(make_trace(len(points), **place))
        moved = {**place, "x_coord_mm": point.x_mm + 1.0}
        assert "not at its place" in str(fit.misfits(make_trace(point.index, **moved))[0])


@each_case(
    "axis",
    [None, [], [1], ["1.0"], [True], [2.0, 1.0], [1.0, 1.0], [math.nan], [1.0, math.inf], {}],
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


def test_a_grid_with_more_places_than_a_survey_may_have_is_refused():
    axis = [float(number) for number in range(1001)]
    with pytest.raises(InvalidValueError):
        imported_grid(described(x_mm=axis, y_mm=axis))


def test_the_area_has_the_names_of_parameters():
    assert measured_area(described()) == {
        "polarizations_deg": [0.0, 90.0],
        **{"x_start_mm": 1.0, "x_stop_mm": 9.0, "x_points": 3},
        **{"y_start_mm": -5.0, "y_stop_mm": -5.0, "y_points": 1},
    }
    assert measured_area({"parameters": 7}) == 7
    assert imported_grid(described()) == ImportedGrid((0.0, 90.0), (-5.0,), (1.0, 2.5, 9.0))
