"""The crosshair, the layers, the marks and the hyperbola of GROUND, without widgets."""

import numpy as np
import pytest
from asked_storage import Storage
from candidate_examples import candidate, candidate_list
from case_kit import each_case
from hypothesis import given, settings
from hypothesis import strategies as st
from map_kit import MARKER
from run_seed import draws
from view_kit import PAST, SURVEY, add_trace, echo, make_grid, trace_at

from gpr20_operator.ground.additions import AdditionsPresenter, AdditionsRead
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.hyperbola import Hyperbola
from gpr20_operator.ground.marks import marks_above, marks_in_section
from gpr20_operator.ground.model import GroundModel, Layer
from gpr20_operator.ground.records import Axis, Place
from gpr20_operator.ground.shown_survey import ShownSurvey
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.radar.soils import ANY_SOIL
from gpr20_survey.results.candidates import Flag
from gpr20_survey.results.focused_image import FocusedImage

TARGET = Place(150.0, 90.0)
BOTH = (Axis.X_MM, Axis.Y_MM)


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


def new_model(grid=None, additions=None):
    """Return a model that shows a survey of 5 x 4 stops and two rotations, of nothing yet."""
    survey = ShownSurvey()
    survey.begin(grid or make_grid())
    additions = additions or AdditionsPresenter(Storage(), lambda: "Ana")
    additions.follow(survey.survey_id, can_read=True)
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


def test_another_survey_takes_crosshair_mark_and_hyperbola_away(model):
    add(model, *range(40))
    model.choose_place(150.0, 90.0)
    model.begin_hyperbola()
    model.change(polarization=1)
    model.survey.begin(make_grid(rotations_deg=(0.0,), survey_id=PAST))
    model.notice_survey()
    assert (model.place, model.mark, model.hyperbola) == (None, None, None)
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
    model.additions.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    model.set_depth(0.06)
    above = marks_above(model)
    assert [one.about for one in above] == [MARKER, marks[2], marks[1], marks[0]]
    assert [one.near for one in above] == 4 * [True]
    model.choose_mark(marks[2])
    last = marks_above(model)[-1]
    assert (last.about, last.chosen, last.near, last.doubtful) == (marks[2], True, True, False)
    model.choose_place(150.0, 90.0)
    assert {one.text for one in marks_in_section(model, Axis.X_MM)} == {"", "1", "2", "3"}
    for layer in (Layer.CANDIDATES, Layer.MARKERS):
        model.switch(layer)
    assert marks_above(model) == ()


def test_a_ring_on_ground_that_was_not_measured_says_so(model):
    cover(model, 10)  # the first row, up
    places = ((150.0, 50.0), (150.0, 110.0), (400.0, 50.0))
    find(model, *(candidate(number, *place, 60.0) for number, place in enumerate(places)))
    measured = {one.about.number: one.measured for one in marks_above(model)}
    assert measured == {0: True, 1: False, 2: False}


def test_the_crosshair_follows_the_last_trace_until_a_place_is_chosen(model):
    assert model.place is None
    add(model, 0, 1, 2)  # the others of another polarization, the last one at the next stop
    assert model.place == Place(100.0, 50.0)
    add(model, 3, 4)
    assert model.place == Place(150.0, 50.0)
    model.choose_place(172.0, 69.0)
    add(model, *range(5, 40))
    assert model.place == Place(175.0, 70.0)
    model.follow(True)
    latest, grid = model.survey.radar.latest_of[0].stop, model.survey.map.grid
    assert model.place == Place(grid.xs_mm[latest.column], grid.ys_mm[latest.row])


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


def test_the_crosshair_links_the_pictures(model):
    add(model, *range(40))
    model.change(remove_background=False)
    model.choose_place(TARGET.x_mm, TARGET.y_mm)
    model.touch_section(Axis.X_MM, 175.0, 100.0, Axis.DEPTH_MM)
    shown = model.pictures(BOTH)
    assert model.place == Place(175.0, 90.0)
    assert model.settings.depth_m == pytest.approx(0.1)
    assert shown.level_db == pytest.approx(shown.curve.scale.top_db, abs=6.0)
    model.touch_section(Axis.Y_MM, 52.0, 200.0, Axis.DEPTH_MM)
    assert model.place == Place(175.0, 50.0)
    # In time, the depth of the delay.
    model.change(in_depth=False)
    assert model.pictures(BOTH).sections[0].axis is Axis.DELAY_NS
    model.touch_depth(model.second_of(0.15, Axis.DELAY_NS), Axis.DELAY_NS)
    assert model.settings.depth_m == pytest.approx(0.15)


def test_the_depth_stays_within_what_can_be_shown_and_needs_a_height(model):
    add(model, *range(40))
    model.step_depth(-100)
    assert model.settings.depth_m == 0.0
    model.step_depth(10_000)
    assert model.settings.depth_m <= model.deepest_m + 1e-9
    model.change(permittivity=20.0)
    assert model.settings.depth_m <= model.deepest_m + 1e-9 < 0.5
    assert model.pictures(BOTH).above.measured
    without = new_model()
    add(without, *range(40), height_m=float("nan"))
    without.begin_hyperbola()
    assert without.hyperbola is None and without.pictures(BOTH).above is None


@each_case("truth,in_depth", [(3.0, True), (20.0, False)])
def test_a_hyperbola_that_is_dragged_over_an_echo_gives_the_permittivity(truth, in_depth):
    height_m, depth_m, apex_mm = 0.1, 0.12, 300.0
    grid = make_grid(31, 3, rotations_deg=(0.0,), x_start_mm=150.0, x_stop_mm=450.0)
    offsets_m = np.abs(grid.xs_mm - apex_mm) / 1000.0
    delays_s = 2.0 * one_way_delay_s(height_m, depth_m, offsets_m, truth)
    model = new_model(grid)
    for index in range(grid.planned):
        add(model, index, s21=echo(delays_s[grid.cell(index).stop.column]), height_m=height_m)
    model.change(in_depth=in_depth, in_db=False, remove_background=False)
    model.choose_place(250.0, 80.0)
    model.begin_hyperbola()
    section = model.pictures((Axis.X_MM,)).sections[0]
    expected = delays_s * 1e9
    if in_depth:  # drawn with permittivity 4
        expected = (delays_s * SPEED_OF_LIGHT_M_S / 2.0 - height_m) / 2.0 * 1000.0
    model.drag_hyperbola(True, apex_mm, expected[15], section.axis)
    model.drag_hyperbola(False, float(grid.xs_mm[1]), expected[1], section.axis)
    assert model.hyperbola.permittivity == pytest.approx(truth, rel=0.01)
    across_mm, drawn = model.hyperbola_points(section)
    # The curve lies on the echoes of the picture.
    low, high = section.range
    step = (high - low) / len(section.shades)
    peaks = low + (np.nanargmax(section.shades, axis=0) + 0.5) * step
    assert np.interp(grid.xs_mm, across_mm, drawn) == pytest.approx(peaks, abs=2 * step)
    model.end_hyperbola(use=True)
    assert model.settings.permittivity == pytest.approx(truth, rel=0.02)
    assert model.settings.depth_m == pytest.approx(depth_m, abs=0.005)


def test_the_focused_image_of_the_survey_has_the_crosshair_and_the_rule_of_the_noise(model):
    add(model, *range(40))
    model.switch(Layer.FOCUSED)
    model.additions.pictures.add_image(image_of(make_grid(survey_id=PAST)))
    assert not model.shows_focused and marks_above(model) == ()
    image = image_of(model.survey.map.grid)
    image.levels_db[:, :, :5] = np.nan
    model.additions.pictures.add_image(image)
    # It begins at its first candidate.
    assert model.shows_focused and model.place == TARGET
    model.choose_place(151.0, 88.0, 61.0)
    shown = model.pictures(BOTH)
    assert model.place == TARGET
    assert shown.level_db == pytest.approx(40.0)
    assert all(one.above_noise for one in (shown.above, *shown.sections))
    assert shown.curve.places[np.nanargmax(shown.curve.shades)] == 60.0
    for section in shown.sections:
        assert np.unravel_index(np.nanargmax(section.shades), section.shades.shape)[0] == 12
    model.set_depth(0.2)
    empty = model.pictures(BOTH).above
    assert not empty.above_noise and np.nanmax(empty.shades) < 0.1
    # What was not measured has no level.
    model.choose_place(100.0, 90.0)
    shown = model.pictures(BOTH)
    assert (shown.level_db, shown.curve) == (None, None)
    assert np.isnan(shown.above.shades[:, :5]).all()


def test_the_soil_is_that_of_the_survey_or_of_its_image_until_another_one_is_chosen(model):
    for survey, stored, shown in (
        *((SURVEY, 8.0, (8.0, None)), (SURVEY, 8.0, (5.0, 8.0)), (SURVEY, 9.0, (9.0, None))),
        *((PAST, 9.0, (9.0, None)), (SURVEY, None, (ANY_SOIL.permittivity, None))),
    ):
        model.take_soil(survey, stored)
        assert (model.settings.permittivity, model.other_permittivity) == shown
        model.change(permittivity=5.0)
    model.additions.pictures.add_image(image_of(model.survey.map.grid))
    model.take_soil(PAST, None)
    model.take_soil(SURVEY, None)
    assert model.settings.permittivity == model.image.found.permittivity == 4.0
    assert model.wanted_permittivity is None
    # Image and candidates of another permittivity are not shown.
    model.change(permittivity=9.0)
    assert model.image is None and not model.additions.candidates


@each_case("delay_s", [0.0, 1.0])
def test_a_point_that_no_ground_explains_ends_at_the_limits(delay_s):
    fitted = Hyperbola(100.0, 2e-9, 0.1, 6.0).through(200.0, delay_s)
    assert fitted.permittivity == pytest.approx(1.0 if delay_s == 0.0 else 81.0, rel=1e-6)
