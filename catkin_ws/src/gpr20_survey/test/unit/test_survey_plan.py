"""The order in which a survey visits its points."""

import itertools
from dataclasses import replace

from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import PARAMETERS, TRAVEL

from gpr20_survey.plan.survey_plan import alternating, grid, raster, survey_points


@each_case("columns", [1, 3, 4, 5, 6])
@each_case("rows", [1, 2, 3])
def test_a_raster_visits_every_cell_once(columns, rows):
    cells = list(raster(range(columns), range(rows)))
    assert sorted(cells) == sorted(itertools.product(range(columns), range(rows)))


def test_a_raster_turns_at_every_row_and_only_there():
    assert list(raster([0, 1, 2, 3], [0, 1, 2])) == [
        *[(0, 0), (1, 0), (2, 0), (3, 0)],
        *[(3, 1), (2, 1), (1, 1), (0, 1)],
        *[(0, 2), (1, 2), (2, 2), (3, 2)],
    ]


@given(st.integers(3, 12), st.integers(3, 12))
def test_every_planned_point_is_visited_exactly_once_per_polarization(x_points, y_points):
    parameters = replace(PARAMETERS, x_points=x_points, y_points=y_points)
    points = survey_points(parameters, TRAVEL)
    visited = {(point.x_mm, point.y_mm, point.z_deg) for point in points}
    assert len(points) == len(visited) == x_points * y_points * 2
    assert [point.index for point in points] == list(range(len(points)))


@given(st.integers(3, 9), st.integers(3, 9))
def test_between_two_points_only_one_axis_of_the_grid_moves_by_one_place(x_points, y_points):
    points = survey_points(replace(PARAMETERS, x_points=x_points, y_points=y_points), TRAVEL)
    for before, after in zip(points, points[1:]):
        moved = [before.x_mm != after.x_mm, before.y_mm != after.y_mm, before.z_deg != after.z_deg]
        assert sum(moved) == 1


def test_the_antennas_turn_once_per_stop():
    visits = list(alternating([(0, 0), (1, 0), (2, 0)], [0.0, 90.0]))
    assert [rotation for _stop, rotation in visits] == [0.0, 90.0, 90.0, 0.0, 0.0, 90.0]


def test_a_reverse_survey_visits_the_same_grid_the_other_way_round():
    turned = replace(PARAMETERS, x_start_mm=30.0, x_stop_mm=10.0, y_start_mm=35.0, y_stop_mm=5.0)
    there = {(p.x_mm, p.y_mm, p.z_deg) for p in survey_points(PARAMETERS, TRAVEL)}
    back = survey_points(turned, TRAVEL)
    assert {(p.x_mm, p.y_mm, p.z_deg) for p in back} == there
    assert (back[0].x_mm, back[0].y_mm) == (30.0, 35.0)


def test_a_grid_holds_both_ends_on_motor_steps():
    coordinates = grid(0.0, 100.0, 7, TRAVEL.x)
    assert coordinates == [0.0, 16.67, 33.33, 50.0, 66.67, 83.33, 100.0]
