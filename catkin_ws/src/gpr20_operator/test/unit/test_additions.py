"""What belongs to a survey: images, candidates, markers, finer surveys and their plans."""

import random
from dataclasses import replace

import pytest
from map_kit import DOUBTED, FINER, MARKER, SURE, focused
from run_seed import draws
from view_kit import SURVEY, TRAVEL, make_grid

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import (
    RETRY_REFRESHES,
    AdditionsFailed,
    AdditionsPresenter,
    AdditionsRead,
    MarkersStored,
    RelatedSurvey,
)
from gpr20_operator.ground.finer_plan import SIZES_MM, plan_finer, proposed_spacing, spacing_of
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.grid import planned_grid
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel, check

RELATED = RelatedSurvey(FINER, "20261121T061000_7c9e6679", True, Area(1.0, 2.0, 3.0, 4.0))


@pytest.fixture
def additions(storage):
    additions = AdditionsPresenter(storage, lambda: "Ana")
    additions.follow(SURVEY, can_read=True)
    return additions


def test_what_belongs_to_a_survey_is_asked_for_once_and_again_after_a_failure(storage, additions):
    additions.follow(SURVEY, can_read=True)
    additions.on_event(AdditionsFailed(SURVEY, verbatim("no")))
    for asked in (*[1] * (RETRY_REFRESHES - 1), 2):
        additions.refresh()
        assert storage.asked == asked * [("additions", SURVEY)]
    additions.on_event(AdditionsRead(SURVEY, (MARKER,), (RELATED,)))
    assert (additions.markers, additions.related) == ((MARKER,), (RELATED,))


def test_nothing_of_another_survey_is_shown(additions):
    additions.on_event(AdditionsRead(FINER, (MARKER,), (RELATED,)))
    additions.on_event(MarkersStored(FINER, (MARKER,)))
    additions.pictures.add_image(focused(survey_id=FINER))
    assert (additions.markers, additions.related, additions.candidates) == ((), (), ())
    additions.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    # A replay has no storage to ask.
    additions.follow(FINER, can_read=False)
    assert additions.markers == () and not additions.can_mark
    assert additions.candidates == (SURE, DOUBTED)


def test_a_marker_is_shown_when_the_storage_has_it(storage, additions):
    with pytest.raises(InvalidValueError):
        additions.add_marker(SURVEY, 1.0, 2.0, None, "a\nb")
    assert len(storage.asked) == 1
    additions.add_marker(SURVEY, 1.0, 2.0, None, "metal")
    _kind, survey, marker = storage.asked[-1]
    assert (survey, marker.text, marker.author, marker.depth_mm) == (SURVEY, "metal", "Ana", None)
    assert additions.markers == ()
    additions.on_event(MarkersStored(SURVEY, (marker,)))
    assert additions.markers == (marker,)
    additions.remove_marker(marker.marker_id)
    assert storage.asked[-1] == ("remove marker", SURVEY, marker.marker_id, "Ana")


def test_a_finer_plan_has_half_the_spacing_and_all_else_of_the_survey():
    grid = make_grid(x_points=11, y_points=7, if_bandwidth_hz=1000.0, averages=4)
    assert (spacing_of(grid), proposed_spacing(grid)) == (10.0, 5.0)
    plan = plan_finer(grid, 150.0, 80.0, 100.0, 5.0)
    ends = {"x_start_mm": 100.0, "x_stop_mm": 200.0, "y_start_mm": 30.0, "y_stop_mm": 130.0}
    assert plan.parameters == replace(grid.plan[0], **ends, x_points=21, y_points=21)
    # What was changed in CONTROL still refines if it lies inside.
    p = plan.parameters
    assert plan.refined_by(replace(p, x_start_mm=120.0, averages=8)) == SURVEY
    assert plan.refined_by(replace(p, x_stop_mm=250.0)) == ""
    # At the edge of travel it has the part that can be reached.
    assert plan_finer(make_grid(), 0.0, 800.0, 100.0, 5.0).area == Area(0.0, 50.0, 750.0, 800.0)
    grid.plan = (grid.plan[0], RobotTravel(Travel(0.0, 0.005, 0.01), TRAVEL.y, TRAVEL.z))
    with pytest.raises(InvalidValueError):
        plan_finer(grid, 0.0, 0.0, 100.0, 5.0)


def test_any_finer_plan_can_be_measured_and_reaches_its_place():
    for seed in range(draws(25)):
        source = random.Random(seed)
        lowest, highest = source.uniform(0, 50), source.uniform(300, 900)
        x_travel = Travel(lowest, highest, source.choice([0.01, 0.1, 0.0125]))
        travel = RobotTravel(x_travel, TRAVEL.y, TRAVEL.z)
        grid = planned_grid(SURVEY, True, make_grid().plan[0], travel)
        x_mm, y_mm = source.uniform(lowest, min(highest, 800)), source.uniform(0, 800)
        size_mm = source.choice([*SIZES_MM, 3.0])
        spacing_mm = source.choice([0.1, 1.0, 2.5, 7.3, 20.0, 90.0])
        plan = plan_finer(grid, x_mm, y_mm, size_mm, spacing_mm)
        p = plan.parameters
        check(p, travel)
        for low_mm, high_mm, points in (
            (p.x_start_mm, p.x_stop_mm, p.x_points),
            (p.y_start_mm, p.y_stop_mm, p.y_points),
        ):
            spacing = (high_mm - low_mm) / (points - 1)
            assert spacing <= max(spacing_mm, 1.0) + 0.02, seed
            assert high_mm - low_mm <= max(size_mm, 2 * max(spacing_mm, 1.0)) + 0.02, seed
        # To within one distance of the stops.
        assert plan.area.grown(spacing_mm + 1).holds(x_mm, y_mm), seed
