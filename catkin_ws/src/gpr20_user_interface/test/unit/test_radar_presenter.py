"""The crosshair, the hyperbola and the two sources of RADAR, without widgets."""

import dataclasses

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from view_kit import depth_echo, echo, make_grid, trace_at

from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.records import Axis, Place, Source
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S
from gpr20_survey.radar.refraction import one_way_delay_s
from gpr20_survey.results.focused_image import FocusedImage
from gpr20_user_interface.pages.ground.radar_model import Grip, RadarPresenter

TARGET = Place(150.0, 90.0)


def image_of(grid, level_db=40.0, seed=1, traces=40, **changes):
    """Return an image of noise with a target at X 150, Y 90, depth 60 mm."""
    rng = np.random.default_rng(seed)
    x_mm, y_mm = np.linspace(100.0, 200.0, 21), np.linspace(50.0, 110.0, 13)
    depth_mm = np.arange(0.0, 301.0, 5.0)
    shape = (len(depth_mm), len(y_mm), len(x_mm))
    noise = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    levels_db = 20.0 * np.log10(np.abs(noise) / np.sqrt(2.0)).astype(np.float32)
    levels_db[12, 8, 10] = level_db
    values = {
        "traces": traces,
        "x_mm": x_mm,
        "y_mm": y_mm,
        "depth_mm": depth_mm,
        "levels_db": levels_db,
        "found": candidate_list([candidate(level_db=level_db)], survey_id=grid.survey_id),
    }
    return FocusedImage(**{**values, **changes})


@pytest.fixture
def model():
    model = RadarModel()
    model.begin(make_grid())
    return model


@pytest.fixture
def presenter(model):
    presenter = RadarPresenter(model)
    presenter.notice_survey()
    return presenter


def on_axis(delay_s, axis, height_m):
    """Return where a delay is drawn in a picture of permittivity 4."""
    if axis is Axis.DELAY_NS:
        return delay_s * 1e9
    return (delay_s * SPEED_OF_LIGHT_M_S / 2.0 - height_m) / 2.0 * 1000.0


def add(model, *indices, **changes):
    for index in indices:
        model.add(trace_at(model.grid, index, **changes))


def test_the_crosshair_follows_the_last_trace_until_a_place_is_chosen(presenter, model):
    assert presenter.place is None
    add(model, 0)
    assert presenter.place == Place(100.0, 50.0)
    add(model, 3, 4)
    assert presenter.place == Place(150.0, 50.0)
    presenter.touch_slice(172.0, 69.0)
    assert presenter.place == Place(175.0, 70.0)
    add(model, *range(5, 40))
    assert presenter.place == Place(175.0, 70.0)
    presenter.follow(True)
    latest = model.latest_of[0].stop
    grid = model.grid
    assert presenter.place == Place(grid.xs_mm[latest.column], grid.ys_mm[latest.row])


def test_the_crosshair_stays_at_a_trace_of_its_polarization(presenter, model):
    add(model, 0)
    add(model, 1, 2)  # both of the other polarization, the second one at the next stop
    assert presenter.place == Place(100.0, 50.0)
    assert presenter.pictures().curve is not None


def test_a_touch_off_the_area_chooses_its_edge(presenter, model):
    add(model, 0)
    presenter.touch_slice(-1e6, 1e6)
    assert presenter.place == Place(100.0, 110.0)


def test_the_crosshair_links_the_three_pictures(presenter, model):
    add(model, *range(40))
    presenter.change(remove_background=False)
    presenter.touch_slice(TARGET.x_mm, TARGET.y_mm)
    presenter.touch_line(175.0, 100.0, Axis.DEPTH_MM)
    shown = presenter.pictures()
    assert shown.place == Place(175.0, 90.0)
    assert shown.depth_m == pytest.approx(0.1)
    assert shown.line.across is Axis.X_MM
    assert shown.level_db == pytest.approx(shown.curve.scale.top_db, abs=6.0)
    presenter.change(along=Axis.Y_MM)
    presenter.touch_line(52.0, 200.0, Axis.DEPTH_MM)
    shown = presenter.pictures()
    assert shown.place == Place(175.0, 50.0)
    assert shown.line.across is Axis.Y_MM
    assert shown.line.across_mm == pytest.approx((40.0, 120.0))
    presenter.touch_curve(33.0, Axis.DEPTH_MM)
    assert presenter.settings.depth_m == pytest.approx(0.035)


def test_any_line_along_x_or_y_can_be_shown(model, presenter):
    grid = model.grid
    for index in range(grid.planned):
        cell = grid.cell(index)
        level = 1.0 if (cell.stop.row, cell.stop.column) == (2, 3) else 1e-3
        add(model, index, s21=depth_echo(0.1, level=level))
    presenter.change(remove_background=False, in_db=False)
    for axis, lines, others in ((Axis.X_MM, range(4), 3), (Axis.Y_MM, range(5), 2)):
        presenter.change(along=axis)
        for number in lines:
            along_x = axis is Axis.X_MM
            here = (0, number) if along_x else (number, 0)
            presenter.touch_slice(float(grid.xs_mm[here[0]]), float(grid.ys_mm[here[1]]))
            shades = presenter.pictures().line.shades
            through = number == (2 if along_x else 3)
            assert (np.nanmax(shades) > 0.5) == through
            if through:
                assert np.unravel_index(np.nanargmax(shades), shades.shape)[1] == others


def test_in_time_a_touch_chooses_the_depth_of_the_delay(presenter, model):
    add(model, *range(40))
    presenter.change(in_depth=False)
    line = presenter.pictures().line
    assert line.axis is Axis.DELAY_NS
    delay_ns = presenter.second_of(0.15, Axis.DELAY_NS)
    presenter.touch_curve(delay_ns, Axis.DELAY_NS)
    assert presenter.settings.depth_m == pytest.approx(0.15)


def test_without_height_no_depth_can_be_chosen(presenter, model):
    add(model, *range(40), height_m=float("nan"))
    presenter.touch_line(150.0, 4.0, Axis.DELAY_NS)
    assert presenter.settings.depth_m == 0.05
    presenter.begin_hyperbola()
    assert presenter.hyperbola is None
    assert presenter.pictures().slice is None


def test_the_depth_stays_within_what_can_be_shown(presenter, model):
    add(model, *range(40))
    presenter.step_depth(-100)
    assert presenter.settings.depth_m == 0.0
    presenter.step_depth(1)
    assert presenter.settings.depth_m == 0.005
    presenter.step_depth(10_000)
    assert presenter.settings.depth_m <= presenter.deepest_m + 1e-9
    presenter.change(permittivity=20.0)
    assert presenter.settings.depth_m <= presenter.deepest_m + 1e-9 < 0.5
    assert presenter.pictures().slice.measured


def test_another_survey_takes_crosshair_and_hyperbola_away(presenter, model):
    add(model, *range(40))
    presenter.touch_slice(150.0, 90.0)
    presenter.begin_hyperbola()
    presenter.change(polarization=1)
    model.begin(make_grid(rotations_deg=(0.0,), survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7"))
    presenter.notice_survey()
    assert presenter.follows
    assert presenter.place is None
    assert presenter.hyperbola is None
    assert presenter.settings.polarization == 0


@pytest.mark.parametrize("truth", [3.0, 8.0, 20.0])
@pytest.mark.parametrize("in_depth", [True, False])
def test_a_hyperbola_that_is_dragged_over_an_echo_gives_the_permittivity(truth, in_depth):
    height_m, depth_m, apex_mm = 0.1, 0.12, 300.0
    grid = make_grid(31, 3, rotations_deg=(0.0,), x_start_mm=150.0, x_stop_mm=450.0)
    offsets_m = np.abs(grid.xs_mm - apex_mm) / 1000.0
    delays_s = 2.0 * one_way_delay_s(height_m, depth_m, offsets_m, truth)
    model = RadarModel()
    model.begin(grid)
    for index in range(grid.planned):
        s21 = echo(delays_s[grid.cell(index).stop.column])
        model.add(trace_at(grid, index, s21, height_m=height_m))
    presenter = RadarPresenter(model)
    presenter.notice_survey()
    presenter.change(in_depth=in_depth, in_db=False, remove_background=False)
    presenter.touch_slice(250.0, 80.0)
    presenter.begin_hyperbola()
    line = presenter.pictures().line
    expected = np.array([on_axis(one, line.axis, height_m) for one in delays_s])
    presenter.drag_hyperbola(Grip.APEX, apex_mm, expected[15], line.axis)
    presenter.drag_hyperbola(Grip.FLANK, float(grid.xs_mm[1]), expected[1], line.axis)
    assert presenter.hyperbola.permittivity == pytest.approx(truth, rel=0.01)
    across_mm, drawn = presenter.hyperbola_points(line)
    # The curve lies on the echoes of the picture.
    low, high = line.range
    step = (high - low) / len(line.shades)
    peaks = low + (np.nanargmax(line.shades, axis=0) + 0.5) * step
    assert np.interp(grid.xs_mm, across_mm, drawn) == pytest.approx(peaks, abs=2 * step)
    presenter.take_permittivity()
    assert presenter.hyperbola is None
    assert presenter.settings.permittivity == pytest.approx(truth, rel=0.02)
    assert presenter.settings.depth_m == pytest.approx(depth_m, abs=0.005)


def test_the_focused_image_is_shown_only_with_its_survey(presenter, model):
    add(model, *range(40))
    presenter.change(source=Source.FOCUSED)
    assert not presenter.shows_focused
    presenter.set_image(image_of(make_grid(survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7")))
    assert not presenter.shows_focused
    assert presenter.candidates == ()
    presenter.set_image(image_of(model.grid))
    assert presenter.shows_focused
    assert [one.number for one in presenter.candidates] == [1]


def test_the_focused_image_has_the_same_crosshair_and_the_rule_of_the_noise(presenter, model):
    add(model, *range(40))
    presenter.set_image(image_of(model.grid))
    presenter.change(source=Source.FOCUSED)
    presenter.touch_slice(151.0, 89.0)
    presenter.set_depth(0.06)
    shown = presenter.pictures()
    assert shown.place == TARGET
    assert shown.level_db == pytest.approx(40.0)
    assert shown.slice.above_noise
    assert shown.line.above_noise
    assert shown.slice.scale == shown.line.scale == shown.curve.scale
    for axis in (Axis.X_MM, Axis.Y_MM):
        presenter.change(along=axis)
        line = presenter.pictures().line
        assert np.unravel_index(np.nanargmax(line.shades), line.shades.shape)[0] == 12
    for in_db in (True, False):
        presenter.change(in_db=in_db)
        presenter.set_depth(0.2)
        empty = presenter.pictures().slice
        assert not empty.above_noise
        assert np.nanmax(empty.shades) < 0.1


def test_newer_images_of_a_survey_keep_its_scale(presenter, model):
    add(model, *range(40))
    presenter.change(source=Source.FOCUSED)
    tops = []
    for number, level_db in enumerate((60.0, 58.0, 40.0, 66.0)):
        presenter.set_image(image_of(model.grid, level_db, seed=number))
        tops.append(presenter.pictures().slice.scale.top_db)
    assert tops == [60.0, 60.0, 60.0, 70.0]


def test_what_was_not_measured_is_no_level_of_the_image(presenter, model):
    add(model, *range(40))
    image = image_of(model.grid)
    levels_db = image.levels_db.copy()
    levels_db[:, :, :5] = np.nan
    presenter.set_image(dataclasses.replace(image, levels_db=levels_db))
    presenter.change(source=Source.FOCUSED)
    presenter.touch_slice(100.0, 90.0)
    shown = presenter.pictures()
    assert shown.level_db is None
    assert shown.curve is None
    assert np.isnan(shown.slice.shades[:, :5]).all()


def test_the_soil_that_was_chosen_last_counts(presenter):
    presenter.take_plan(8.0)
    assert presenter.settings.permittivity == 8.0
    presenter.change(permittivity=15.0)
    for unchanged in (8.0, None, 8.0):
        presenter.take_plan(unchanged)
        assert presenter.settings.permittivity == 15.0
    presenter.take_plan(20.0)
    assert presenter.settings.permittivity == 20.0
