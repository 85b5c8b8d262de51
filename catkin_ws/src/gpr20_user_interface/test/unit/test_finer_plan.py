import random
from dataclasses import replace

import pytest
from view_kit import SURVEY, TRAVEL, make_grid

from gpr20_common.errors import InvalidValueError
from gpr20_operator.ground.finer_plan import (
    SIZES_MM,
    plan_finer,
    proposed_spacing,
    spacing_of,
)
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.grid import planned_grid
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel, check, coordinate_limits_mm


def test_a_plan_has_half_the_spacing_and_all_else_of_the_survey():
    grid = make_grid(x_points=11, y_points=7, if_bandwidth_hz=1000.0, averages=4)
    assert (spacing_of(grid), proposed_spacing(grid)) == (10.0, 5.0)
    plan = plan_finer(grid, 150.0, 80.0, 100.0, 5.0)
    p = plan.parameters
    assert (p.x_start_mm, p.x_stop_mm, p.x_points) == (100.0, 200.0, 21)
    assert (p.y_start_mm, p.y_stop_mm, p.y_points) == (30.0, 130.0, 21)
    assert plan.refines == SURVEY
    assert p.polarizations_deg == grid.plan[0].polarizations_deg
    assert p.sweep_settings == grid.plan[0].sweep_settings
    assert p.vna_address == grid.plan[0].vna_address


def test_any_plan_can_be_measured_and_reaches_its_place():
    for seed in range(300):
        source = random.Random(seed)
        lowest, highest = source.uniform(0, 50), source.uniform(300, 900)
        travel = RobotTravel(
            Travel(lowest, highest, source.choice([0.01, 0.1, 0.0125])), TRAVEL.y, TRAVEL.z
        )
        grid = planned_grid(SURVEY, True, make_grid().plan[0], travel)
        x_mm, y_mm = source.uniform(lowest, min(highest, 800)), source.uniform(0, 800)
        size_mm = source.choice([*SIZES_MM, 3.0])
        spacing_mm = source.choice([0.1, 1.0, 2.5, 7.3, 20.0, 90.0])
        plan = plan_finer(grid, x_mm, y_mm, size_mm, spacing_mm)
        p = plan.parameters
        check(p, travel)
        for low_mm, high_mm, points, limits in (
            (p.x_start_mm, p.x_stop_mm, p.x_points, travel.x),
            (p.y_start_mm, p.y_stop_mm, p.y_points, travel.y),
        ):
            assert points > 2
            spacing = (high_mm - low_mm) / (points - 1)
            assert spacing <= max(spacing_mm, 1.0) + 0.02, seed
            lower, upper = coordinate_limits_mm(limits)
            assert lower <= low_mm < high_mm <= upper, seed
            assert high_mm - low_mm <= max(size_mm, 2 * max(spacing_mm, 1.0)) + 0.02, seed
        # To within one distance of the stops.
        reach_mm = spacing_mm + 1
        assert plan.area.grown(reach_mm).holds(x_mm, y_mm), seed


def test_a_place_at_the_edge_of_travel_gets_the_part_that_can_be_reached():
    plan = plan_finer(make_grid(), 0.0, 800.0, 100.0, 5.0)
    assert plan.area == Area(0.0, 50.0, 750.0, 800.0)


def test_an_axis_without_travel_is_refused():
    travel = RobotTravel(Travel(0.0, 0.005, 0.01), TRAVEL.y, TRAVEL.z)
    grid = planned_grid(SURVEY, True, make_grid().plan[0], TRAVEL)
    grid.plan = (grid.plan[0], travel)
    with pytest.raises(InvalidValueError):
        plan_finer(grid, 0.0, 0.0, 100.0, 5.0)


def test_what_was_changed_in_control_still_refines_if_it_lies_inside():
    plan = plan_finer(make_grid(), 150.0, 80.0, 100.0, 5.0)
    p = plan.parameters
    assert plan.refined_by(p) == SURVEY
    assert plan.refined_by(replace(p, x_points=31, averages=8)) == SURVEY
    assert plan.refined_by(replace(p, x_start_mm=120.0)) == SURVEY
    assert plan.refined_by(replace(p, x_stop_mm=p.x_stop_mm + 50.0)) == ""
