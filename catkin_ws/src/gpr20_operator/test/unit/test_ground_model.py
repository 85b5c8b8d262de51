"""The crosshair, the layers, the marks and what belongs to a survey, without widgets."""

import random
from dataclasses import replace

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from hypothesis import given, settings
from hypothesis import strategies as st
from map_kit import MARKER, focused, marked
from result_kit import TIME_US, Now, Requests, noted
from result_kit import stored as stored_survey
from run_seed import draws
from view_kit import PAST, SURVEY, TRAVEL, add_trace, make_grid, trace_at

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import AdditionsPresenter
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.grid import FINER_SIZE_MM, Area, Place, plan_finer, planned_grid
from gpr20_operator.ground.model import GroundModel
from gpr20_operator.ground.sources import Layer
from gpr20_operator.ground.texts import marks_above, marks_in_section
from gpr20_operator.ground.traces import ShownSurvey
from gpr20_operator.jobs.pictures import Imaging
from gpr20_survey.folder.log_record import Kind, soil_values
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel, check
from gpr20_survey.radar import ANY_SOIL
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import Flag

TARGET = Place(150.0, 90.0)


def image_of(grid, level_db=40.0, found=None):
    """Return an image of noise with a target at X 150, Y 90, depth 60 mm."""
    rng = np.random.default_rng(1)
    x_mm, y_mm = np.linspace(100.0, 200.0, 21), np.linspace(50.0, 110.0, 13)
    depth_mm = np.arange(0.0, 301.0, 5.0)
    shape = (len(depth_mm), len(y_mm), len(x_mm))
    noise = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    levels_db = 20.0 * np.log10(np.abs(noise) / np.sqrt(2.0)).astype(np.float32)
    levels_db[12, 8, 10] = level_db
    found = found or candidate_list([candidate(level_db=level_db)], survey_id=grid.survey_id)
    return FocusedImage(40, x_mm, y_mm, depth_mm, levels_db, found)


def new_model(grid=None):
    """Return a model that shows a survey of 5 x 4 stops and two rotations, of nothing yet."""
    survey = ShownSurvey()
    survey.begin(grid or make_grid())
    additions = AdditionsPresenter(Imaging(Requests(), Now()), lambda: "Ana")
    additions.follow(survey.map.grid)
    additions.refresh()
    model = GroundModel(survey, additions)
    model.notice_survey()
    return model


@pytest.fixture
def model():
    return new_model()


def add(model, *indices, **changes):
    for index in indices:
        add_trace(model.survey.radar, trace_at(model.survey.map.grid, index, **changes))


def cover(model, stored):
    """Say that the first of 40 traces are stored."""
    runs = {0: 1, **({stored: 0} if stored < 40 else {})}
    model.survey.map.set_coverage(CoverageRuns(SURVEY, 40, tuple(runs), tuple(runs.values())))


def find(model, *candidates):
    found = candidate_list(candidates, survey_id=SURVEY)
    model.additions.pictures.add_image(image_of(model.survey.map.grid, found=found))


def test_another_survey_takes_crosshair_and_mark_away(model):
    add(model, *range(40))
    model.choose_place(150.0, 90.0)
    model.change(polarization=1)
    model.survey.begin(make_grid(rotations_deg=(0.0,), survey_id=PAST))
    model.notice_survey()
    assert model.place is model.mark is None
    assert model.follows and model.settings.polarization == 0


def test_a_mark_is_chosen_with_its_depth_and_left_when_it_is_gone(model):
    add(model, *range(40))
    first = candidate(1, 150.0, 90.0, 60.0, 40.0)
    second = candidate(2, 101.0, 51.0, 120.0, 12.0, [Flag.EDGE])
    find(model, first, second)
    for mark in (first, second, first):
        model.choose_next()
        assert model.mark == mark
        assert model.point == (mark.x_mm, mark.y_mm, pytest.approx(mark.depth_mm))
    find(model, second)
    model.notice_survey()
    assert model.mark is None


def test_what_must_not_be_overlooked_is_painted_last_and_has_its_number_at_every_depth(model):
    cover(model, 40)
    marks = [
        candidate(1, 150.0, 90.0, 60.0, 40.0),
        candidate(2, 150.0, 90.0, 160.0, 20.0),
        candidate(3, 151.0, 91.0, 160.0, 10.0, [Flag.EDGE]),
    ]
    find(model, *marks)
    model.additions.read_again()
    model.additions._imaging._requests.ticket("read").done(marked(MARKER))
    model.set_depth(0.06)
    above = marks_above(model)
    assert [one.about for one in above] == [MARKER, marks[2], marks[1], marks[0]]
    assert [one.near for one in above] == 4 * [True]
    model.choose_mark(marks[2])
    last = marks_above(model)[-1]
    assert (last.about, last.chosen, last.near, last.doubtful) == (marks[2], True, True, False)
    model.choose_place(150.0, 90.0)
    assert {one.text for one in marks_in_section(model)} == {"", "1", "2", "3"}


def test_a_ring_on_ground_that_was_not_measured_says_so(model):
    cover(model, 10)  # the first row, up
    places = ((150.0, 50.0), (150.0, 110.0), (400.0, 50.0))
    find(model, *(candidate(number, *place, 60.0) for number, place in enumerate(places)))
    measured = {one.about.number: one.measured for one in marks_above(model)}
    assert measured == {0: True, 1: False, 2: False}


@settings(max_examples=draws(50))
@given(
    *(st.integers(2, 30), st.integers(2, 30), st.booleans()),
    *(st.floats(-100.0, 500.0), st.floats(-100.0, 500.0)),
)
def test_the_place_chosen_is_within_half_a_cell_of_the_touch(columns, rows, left, x, y):
    ends = {"x_start_mm": 200.0, "x_stop_mm": 100.0} if left else {}
    model = new_model(make_grid(columns, rows, **ends))
    model.choose_place(x, y)
    # A touch off the area chooses its edge.
    for at, touched, low, high, count in (
        (model.place.x_mm, x, 100.0, 200.0, columns),
        (model.place.y_mm, y, 50.0, 110.0, rows),
    ):
        half = (high - low) / (count - 1) / 2.0
        assert abs(at - min(max(touched, low), high)) <= half + 0.02


def test_the_depth_stays_within_what_can_be_shown_and_needs_a_height(model):
    wet = new_model(make_grid(permittivity=20.0))
    for one in (model, wet):
        add(one, *range(40))
        one.step_depth(-100)
        assert one.settings.depth_m == 0.0
        one.step_depth(10_000)
        assert one.settings.depth_m <= one.deepest_m + 1e-9
    assert wet.deepest_m < 0.5 and wet.pictures().above.measured
    without = new_model()
    add(without, *range(40), height_m=float("nan"))
    shown = without.pictures()
    assert shown.above is shown.section is without.deepest_m is None


def test_the_focused_image_of_the_survey_has_the_crosshair_and_the_rule_of_the_noise(model):
    add(model, *range(40))
    model.change(layer=Layer.FOCUSED)
    model.additions.pictures.add_image(image_of(make_grid(survey_id=PAST)))
    assert not model.shows_focused and marks_above(model) == ()
    image = image_of(model.survey.map.grid)
    image.levels_db[:, :, :5] = np.nan
    model.additions.pictures.add_image(image)
    # It begins at its first candidate.
    assert model.shows_focused and model.place == TARGET
    model.choose_place(151.0, 88.0, 61.0)
    for _along in range(2):
        shown = model.pictures()
        assert model.place == TARGET
        assert shown.level_db == pytest.approx(40.0)
        assert shown.above.above_noise and shown.section.above_noise
        shades = shown.section.shades
        assert np.unravel_index(np.nanargmax(shades), shades.shape)[0] == 12
        model.turn()
    model.set_depth(0.2)
    empty = model.pictures().above
    assert not empty.above_noise and np.nanmax(empty.shades) < 0.1
    # What was not measured has no level.
    model.choose_place(100.0, 90.0)
    assert model.pictures().level_db is None
    assert np.isnan(model.pictures().above.shades[:, :5]).all()


def test_the_soil_is_that_of_the_survey_or_of_its_image():
    for stored, shown in ((8.0, 8.0), (None, ANY_SOIL.permittivity)):
        model = new_model(make_grid(permittivity=stored))
        assert model.settings.permittivity == shown
    model.additions.pictures.add_image(image_of(model.survey.map.grid))
    model.notice_survey()
    assert model.settings.permittivity == model.image.found.permittivity == 4.0
    # Somebody enters one: image and candidates of another permittivity are not shown.
    log = [noted("decision", soil_values(9.0, TIME_US))]
    model.additions._imaging._requests.ticket("read").done(stored_survey(log=log))
    model.notice_survey()
    assert model.settings.permittivity == 9.0
    assert model.image is None and not model.additions.candidates


@pytest.fixture
def additions(node, now):
    additions = AdditionsPresenter(Imaging(node, now), lambda: "Ana")
    additions.follow(make_grid())
    additions.refresh()
    return additions


def test_nothing_of_another_survey_is_shown(node, additions):
    first = node.ticket("read")
    additions.pictures.add_image(focused(survey_id=PAST))
    additions.follow(make_grid(survey_id=PAST))
    additions.refresh()
    first.done(marked(MARKER))
    assert additions.markers == ()
    node.ticket("read").done(marked(MARKER))
    assert additions.markers == (MARKER,)
    additions.follow(make_grid())
    assert additions.markers == additions.candidates == ()


def test_a_marker_is_shown_when_the_storage_has_it_and_each_failure_is_reported(node, additions):
    failed = []
    additions.marking_failed = failed.append
    additions.add_marker(SURVEY, 1.0, 2.0, None, "metal")
    first = node.ticket("fact")
    additions.remove_marker(MARKER.marker_id)
    (survey, kind, values), removal = node.of("fact")
    assert (survey, kind, values["text"], values["author"]) == (SURVEY, Kind.MARKER, "metal", "Ana")
    values = {"marker_id": MARKER.marker_id, "author": "Ana"}
    assert removal == (SURVEY, Kind.MARKER_REMOVED, values)
    # Neither ends the other.
    first.fail(verbatim("the disk is full"))
    assert failed == [verbatim("the disk is full")] and additions.markers == ()
    node.ticket("fact").done(verbatim("stored"))
    assert len(node.of("read")) == 2
    node.ticket("read").done(marked(MARKER))
    assert additions.markers == (MARKER,)


def test_a_finer_plan_has_half_the_spacing_and_all_else_of_the_survey():
    grid = make_grid(x_points=11, y_points=7, if_bandwidth_hz=1000.0, averages=4)
    plan = plan_finer(grid, 150.0, 80.0)
    ends = {"x_start_mm": 100.0, "x_stop_mm": 200.0, "y_start_mm": 30.0, "y_stop_mm": 130.0}
    assert plan.parameters == replace(grid.plan[0], **ends, x_points=21, y_points=21)
    # What was changed in the plan still refines if it lies inside.
    p = plan.parameters
    assert plan.refined_by(replace(p, x_start_mm=120.0, averages=8)) == SURVEY
    assert plan.refined_by(replace(p, x_stop_mm=250.0)) == ""
    # At the edge of travel it is moved.
    assert plan_finer(grid, 0.0, 800.0).area == Area(0.0, 100.0, 700.0, 800.0)
    grid.plan = (grid.plan[0], RobotTravel(Travel(0.0, 0.005, 0.01), TRAVEL.y, TRAVEL.z))
    with pytest.raises(InvalidValueError):
        plan_finer(grid, 0.0, 0.0)


def test_any_finer_plan_can_be_measured_and_reaches_its_place():
    for seed in range(draws(25)):
        source = random.Random(seed)
        lowest, highest = source.uniform(0, 50), source.uniform(300, 900)
        x_travel = Travel(lowest, highest, source.choice([0.01, 0.1, 0.0125]))
        travel = RobotTravel(x_travel, TRAVEL.y, TRAVEL.z)
        points = source.randint(3, 60)
        grid = planned_grid(SURVEY, True, make_grid(points, points).plan[0], travel)
        x_mm, y_mm = source.uniform(lowest, min(highest, 800)), source.uniform(0, 800)
        plan, most_mm = plan_finer(grid, x_mm, y_mm), max(min(grid.spacing_mm) / 2.0, 1.0)
        p = plan.parameters
        check(p, travel)
        for low_mm, high_mm, points in (
            (p.x_start_mm, p.x_stop_mm, p.x_points),
            (p.y_start_mm, p.y_stop_mm, p.y_points),
        ):
            assert (high_mm - low_mm) / (points - 1) <= most_mm + 0.02, seed
            assert high_mm - low_mm <= max(FINER_SIZE_MM, 2 * most_mm) + 0.02, seed
        # To within one distance of the stops.
        assert plan.area.grown(most_mm + 1, most_mm + 1).holds(x_mm, y_mm), seed
