"""GROUND in the window: touches, layers, candidates, markers, finer surveys, what it says."""

import dataclasses
import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from map_kit import DOUBTED, FINER, MARKER, SURE, focused
from picture_kit import colours, drag, touch
from PyQt5.QtCore import QPoint, QPointF, Qt
from PyQt5.QtTest import QTest
from test_ground_model import image_of
from view_kit import (
    PAST,
    SURVEY,
    depth_echo,
    description,
    make_grid,
    snapshot,
    state_of,
    trace_at,
)
from window_helpers import click, close, hold, opened_window, show

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.additions import (
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
    RelatedSurvey,
)
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.model import Layer
from gpr20_operator.ground.records import Axis, Colours, Place
from gpr20_operator.ground.shade_colours import LAST_SHADE, NOT_MEASURED
from gpr20_operator.ground.trace_events import SurveyDescribed
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.radar.soils import Soils
from gpr20_user_interface.window.rail import TabName

NO_MINE = "No echo does not mean no mine."


def fill(window, stored=40, s21=None, grid=None, **changes):
    """Let a window show a survey of which the first traces are stored and here."""
    grid = grid or make_grid()
    live = window.traces.live
    live.begin(grid)
    cover(window, stored, grid)
    for index in range(stored):
        live.take_traces([trace_at(grid, index, s21, **changes)])
    window.show_tab(TabName.GROUND)
    window.refresh()
    window.draw()


def cover(window, stored, grid=None):
    grid = grid or window.traces.live.map.grid
    runs = ((0, stored), (1, 0)) if 0 < stored < grid.planned else ((0,), (int(stored > 0),))
    window.traces.live.map.set_coverage(CoverageRuns(SURVEY, grid.planned, *runs))


@pytest.fixture
def view(window):
    return window.ground.view


@pytest.fixture
def filled(window):
    fill(window)
    window.on_event(AdditionsRead(SURVEY, (MARKER,), ()))
    window.additions.pictures.add_image(focused())
    window.draw()
    return window


def noise(grid, level=1e-4):
    rng = np.random.default_rng(1)
    for _ in range(grid.planned):
        yield level * (rng.standard_normal(501) + 1j * rng.standard_normal(501))


def fill_with_noise(window, count=None):
    grid = make_grid()
    window.traces.live.begin(grid)
    cover(window, grid.planned, grid)
    for index, s21 in enumerate(noise(grid)):
        if count is None or index < count:
            window.traces.live.take_traces([trace_at(grid, index, s21)])
    window.show_tab(TabName.GROUND)
    window.refresh()
    window.draw()


def refreshed(view):
    """Let the picture that a finger has changed be drawn."""
    view.refresh()
    return view


def area_px(pictures):
    """Return how many pixels are pictures."""
    return sum(one.width() * one.height() for one in pictures.plots if one.isVisible())


def asked(window, kind):
    return [one for one in window.traces.source.asked if one[0] == kind]


def test_the_pictures_are_more_than_half_of_the_screen(filled, view):
    assert (filled.width(), filled.height()) == (800, 480)
    assert area_px(view.pictures) >= 0.55 * 800 * 480
    click(view.enlarge_key)
    assert area_px(view.pictures) >= 0.55 * 800 * 480


@pytest.mark.parametrize("size", [(800, 480), (1280, 800)])
@pytest.mark.parametrize("shape", [(21, 21, 300, 300), (3, 40, 40, 600), (40, 3, 600, 40)])
def test_a_picture_shows_radar_nearly_wherever_it_is(window, view, size, shape):
    columns, rows, width, height = shape
    grid = make_grid(
        columns, rows, (0.0,),
        x_start_mm=10.0, x_stop_mm=10.0 + width, y_start_mm=10.0, y_stop_mm=10.0 + height,
    )  # fmt: skip
    window.resize(*size)
    fill(window, grid.planned, grid=grid)
    pictures = view.pictures
    radar = sum(one.area.width() * one.area.height() for one in pictures.plots if one.isVisible())
    if width == height:
        assert radar >= 0.97 * area_px(pictures)
    assert radar >= 0.6 * area_px(pictures)
    assert pictures.sections[1].isVisible() == (size == (1280, 800))
    places = [one.geometry() for one in pictures.plots if one.isVisible()]
    assert not any(one.intersects(other) for one, other in itertools.combinations(places, 2))


def test_section_and_view_from_above_grow_trace_by_trace(window, view):
    grid = make_grid()
    window.traces.live.begin(grid)
    window.show_tab(TabName.GROUND)
    section, above = view.pictures.sections[0], view.pictures.above
    for count, index in enumerate((0, 3, 4, 7, 8), 1):  # of polarization 0
        window.traces.live.take_traces([trace_at(grid, index)])
        window.draw()
        shades, places = view.pictures.trace.points
        assert places[np.argmax(shades)] == pytest.approx(100.0, abs=7)
        measured = (section.numbers != NOT_MEASURED).any(axis=0).tolist()
        assert measured == [True] * count + [False] * (5 - count)
        assert (above.numbers != NOT_MEASURED).sum() == count
    window.traces.live.begin(make_grid(survey_id=PAST))
    window.draw()
    assert above.numbers is section.numbers is None


def test_a_touch_shows_section_and_trace_of_that_place_and_says_what_is_there(filled, view):
    touch(view.pictures.above, 149.0, 91.0)
    refreshed(view)
    assert filled.ground.model.place == Place(150.0, 90.0)
    assert view.pictures.above.crosshair == (150.0, 90.0)
    assert view.pictures.sections[0].labels == ("X mm", "Depth mm, at Y 90 mm")
    assert view.text.text().splitlines()[0] == "X 150, Y 90, depth 50 mm"
    assert "above the noise" in view.text.text()


@pytest.mark.parametrize("seed", range(6))
def test_random_touches_of_random_surveys_choose_the_cell_below_the_finger(window, view, seed):
    rng = np.random.default_rng(seed)
    columns, rows = rng.integers(2, 40, 2).tolist()
    left, low = rng.uniform(0.0, 200.0, 2)
    right, high = left + rng.uniform(20.0, 400.0), low + rng.uniform(20.0, 500.0)
    xs, ys = ((left, right)[:: rng.choice((1, -1))], (low, high)[:: rng.choice((1, -1))])
    grid = make_grid(
        columns, rows, (0.0,),
        x_start_mm=xs[0], x_stop_mm=xs[1], y_start_mm=ys[0], y_stop_mm=ys[1],
    )  # fmt: skip
    fill(window, 0, grid=grid)
    above, model = view.pictures.above, window.ground.model
    for _ in range(20):
        above.zoom_by(float(rng.uniform(0.5, 2.0)), above.area.center())
        area = above.area
        at = QPoint(*(int(rng.uniform(a + 1, b - 1)) for a, b in (
            (area.left(), area.right()), (area.top(), area.bottom()),
        )))  # fmt: skip
        touched = above.to_data(QPointF(at))
        QTest.mouseClick(above.viewport(), Qt.LeftButton, pos=at)
        place = model.place
        for found, wanted, axis in zip((place.x_mm, place.y_mm), touched, (grid.xs_mm, grid.ys_mm)):
            # A motor step more: places of the plan lie on motor steps.
            half = abs(axis[1] - axis[0]) / 2.0 + 0.02
            nearest = min(max(wanted, axis.min()), axis.max())
            assert abs(found - nearest) <= half


def test_dragging_in_the_section_changes_the_depth(filled, view):
    section, model = view.pictures.sections[0], filled.ground.model
    touch(view.pictures.above, 150.0, 90.0)
    for depth_mm in (80.0, 200.0, 20.0):
        drag(section, (150.0, 100.0), (150.0, depth_mm))
        refreshed(view)
        assert model.settings.depth_m * 1000.0 == pytest.approx(depth_mm, abs=5.0)
        assert model.place == Place(150.0, 90.0)
        assert view.pictures.above.labels[1].endswith(f"{model.settings.depth_m * 1e3:.0f} mm deep")
    drag(view.pictures.trace, (0.5, 100.0), (0.5, 60.0))
    assert model.settings.depth_m * 1000.0 == pytest.approx(60.0, abs=5.0)
    drag(section, (150.0, 60.0), (200.0, 60.0))
    assert model.place == Place(200.0, 90.0)
    for key, change_m in ((view.deeper, 0.005), (view.shallower, -0.005)):
        before = model.settings.depth_m
        click(key)
        assert model.settings.depth_m == pytest.approx(before + change_m)


def test_a_double_tap_or_the_key_lets_one_picture_fill_the_page_and_back(filled, view):
    pictures = view.pictures
    for plot in (pictures.above, pictures.sections[0], pictures.trace):
        QTest.mouseDClick(plot.viewport(), Qt.LeftButton, pos=QPoint(20, 40))
        assert [one for one in pictures.plots if one.isVisible()] == [plot]
        assert plot.size() == pictures.size()
        assert plot.area.width() * plot.area.height() >= 0.98 * area_px(pictures)
        assert NO_MINE in view.note.text() and view.note.isVisible()
        QTest.mouseDClick(plot.viewport(), Qt.LeftButton, pos=QPoint(20, 40))
        assert pictures.above.isVisible() and pictures.sections[0].isVisible()
    # The key is for the picture that was touched last.
    touch(pictures.sections[0], 150.0, 60.0)
    click(view.enlarge_key)
    assert pictures.enlarged is pictures.sections[0]
    click(view.enlarge_key)
    assert pictures.enlarged is None


def test_candidates_are_visited_and_described(filled, view):
    click(view.next)
    assert filled.ground.model.mark == SURE
    assert view.text.text().splitlines() == [
        "Candidate 1",
        "X 125, Y 90, depth 85 mm",
        "21 dB above the clutter",
    ]
    touch(view.pictures.above, SURE.x_mm, SURE.y_mm)
    refreshed(view)
    assert filled.ground.model.mark == DOUBTED
    assert view.text.text().splitlines()[0] == "Candidate 2, doubtful"
    assert view.text.text().splitlines()[-2:] == ["Clutter", "Edge"]
    touch(view.pictures.above, SURE.x_mm, SURE.y_mm)
    refreshed(view)
    assert filled.ground.model.mark is None
    touch(view.pictures.above, MARKER.x_mm, MARKER.y_mm)
    refreshed(view)
    assert view.text.text().splitlines() == [
        "Marker: raíz",
        "X 175, Y 70, depth 60 mm",
        "2026-11-21 05:10 UTC Ana",
    ]


def test_it_counts_what_a_person_should_look_at_before_a_place_is_chosen(filled, view):
    filled.ground.model.follow(True)
    refreshed(view)
    assert "1 candidate, 1 doubtful" in view.text.text()


def test_what_is_not_done_is_found_one_after_the_other_and_says_why(window, view):
    fill(window, 10)
    reason = verbatim("ADC: no answer")
    runs = (0, 10, 12), (1, 3, 0)
    window.traces.live.map.set_coverage(CoverageRuns(SURVEY, 40, *runs, {10: reason}))
    window.draw()
    assert view.next.text() == "Next\ngap"
    for x_mm in (100.0, 125.0):
        click(view.next)
        assert window.ground.model.place == Place(x_mm, 70.0)
    touch(view.pictures.above, 200.0, 70.0)
    refreshed(view)
    assert view.text.text().splitlines()[1:] == ["Failed", "ADC: no answer", "No trace to show"]


def test_layers_are_switched_by_name_in_one_sheet(filled, view):
    click(view.layers)
    sheet, above = filled.ground.layers, view.pictures.above
    assert sheet.isVisible()
    assert sheet.layers[Layer.ECHOES].text() == "✓ Echoes"
    click(sheet.layers[Layer.ECHOES])
    assert sheet.layers[Layer.ECHOES].text() == "Echoes"
    assert above.numbers is None
    click(sheet.layers[Layer.FOCUSED])
    assert above.labels[1].startswith("Y mm, focused")
    click(sheet.layers[Layer.CANDIDATES])
    assert [one.about for one in above.marks] == [MARKER]
    click(sheet.layers[Layer.MARKERS])
    assert above.marks == ()
    # Nobody has asked where a mine could hide.
    assert not sheet.layers[Layer.HIDING].isEnabled()
    assert sheet.counts[StopState.DONE].text() == "Done: 20"
    click(sheet.done)
    assert not sheet.isVisible()


def test_the_settings_change_what_is_drawn_and_never_the_data(filled, view):
    sheet, model = filled.ground.layers, filled.ground.model
    echoes = filled.traces.live.radar.echoes[0].copy()
    sheet.open()
    click(sheet.soils[Soils.WET_SAND])
    assert model.settings.permittivity == Soils.WET_SAND.value.permittivity
    click(sheet.permittivity.more)
    assert sheet.soils[None].isChecked()
    click(sheet.gain.more)
    assert model.settings.gain_db_per_ns == 1.0
    for key, name in ((sheet.axis, "in_depth"), (sheet.scale, "in_db")):
        before = getattr(model.settings, name)
        click(key)
        assert getattr(model.settings, name) is not before
    assert view.pictures.sections[0].axis is Axis.DELAY_NS
    click(sheet.along)
    assert model.settings.along is Axis.Y_MM
    assert view.pictures.sections[0].labels[0] == "Y mm"
    click(sheet.polarization)
    assert sheet.polarization.text() == "Antenna\n90°"
    click(sheet.background)
    click(sheet.colours[Colours.GREY])
    numbers = view.pictures.above.numbers
    assert abs(int(np.median(numbers)) - LAST_SHADE // 2) <= LAST_SHADE // 2
    click(sheet.follow)
    assert not model.follows
    assert (filled.traces.live.radar.echoes[0] == echoes).all()


def test_another_permittivity_is_fitted_by_a_hyperbola(filled, view):
    model, section = filled.ground.model, view.pictures.sections[0]
    touch(view.pictures.above, 150.0, 90.0)
    filled.ground.layers.open()
    click(filled.ground.layers.fit)
    assert view.pictures.enlarged is section
    assert view.use.isVisible() and not view.layers.isVisible()
    before = model.hyperbola
    drag(section, section.grip, (section.grip[0], section.grip[1] + 40.0))
    refreshed(view)
    assert model.hyperbola.apex_delay_s > before.apex_delay_s
    drag(section, (120.0, 300.0), (115.0, 160.0))
    fitted = model.hyperbola.permittivity
    assert fitted != before.permittivity
    click(view.use)
    assert model.settings.permittivity == round(fitted, 1)
    assert view.pictures.above.isVisible() and view.layers.isVisible()
    view.begin_fit()
    click(view.drop)
    assert model.settings.permittivity == round(fitted, 1)
    view.begin_fit()
    filled.traces.live.begin(make_grid(survey_id=PAST))
    refreshed(view)
    assert not view.is_fitting


def test_nothing_above_the_noise_is_never_said_while_a_part_is_not_here(window, view):
    fill_with_noise(window, count=25)
    window.ground.model.set_depth(0.3)
    refreshed(view)
    assert window.ground.model.waiting is not None
    assert view.pictures.above.notice == ""
    assert "loading 25/40" in view.note.text()
    assert all(one.notice == "" for one in view.pictures.sections)
    window.ground.model.choose_place(150.0, 110.0)
    refreshed(view)
    # Of the uppermost line nothing has come: its section is patterned as loading.
    section = view.pictures.sections[0]
    found = colours(section, 150.0, 200.0, reach=8)
    window.traces.live.map.set_coverage(CoverageRuns(SURVEY, 40, (0, 25), (1, 0)))
    refreshed(view)
    assert colours(section, 150.0, 200.0, reach=8) != found
    cover(window, 40)
    grid = window.traces.live.map.grid
    for index, s21 in enumerate(noise(grid)):
        if index >= 25:
            window.traces.live.take_traces([trace_at(grid, index, s21)])
    refreshed(view)
    assert view.pictures.above.notice == f"Nothing above the noise at this depth. {NO_MINE}"
    assert view.pictures.sections[0].notice == f"Nothing above the noise in this section. {NO_MINE}"
    window.traces.live.map.set_coverage(CoverageRuns(SURVEY, 40, (0, 30), (1, 0)))
    refreshed(view)
    assert "A part is not measured." in view.pictures.above.notice


def test_it_never_says_that_the_ground_is_clear(filled, view):
    pictures = view.pictures
    for plot in (None, pictures.above, pictures.sections[0], pictures.trace):
        pictures.enlarge(plot)
        refreshed(view)
        QTest.qWait(1)
        assert NO_MINE in view.note.text() and view.note.isVisible()
        assert view.note.fontMetrics().horizontalAdvance(view.note.text()) <= view.note.width()
        said = " ".join(
            (view.note.text(), view.text.text(), *(one.notice for one in pictures.plots))
        )
        assert not {"clear", "free", "safe"} & set(said.lower().replace(".", "").split())


@pytest.mark.parametrize("size", [(480, 320), (800, 480), (1280, 800)])
@pytest.mark.parametrize("language", [Language.ENGLISH, Language.SPANISH])
def test_the_safety_notice_is_never_cut_off_even_beside_the_band(
    application, tmp_path, size, language
):
    window = opened_window(application, language, profiles=tmp_path)
    try:
        window.resize(*size)
        fill(window)
        view = window.ground.view
        name = Message("PAST SURVEY: {name}", name="2026-11-21 05:10, " + "El Carmen " * 9)
        for band in (None, name):
            view.show_band(band)
            for plot in (None, view.pictures.above):
                view.pictures.enlarge(plot)
                view.refresh()
                QTest.qWait(1)
                note = view.note
                assert note.fontMetrics().horizontalAdvance(note.text()) <= note.width()
                assert note.geometry().right() < view.width()
                assert band is None or view.band.width() >= 0.3 * view.width()
    finally:
        close(window)


def test_a_past_survey_is_named_with_the_way_back(filled, view):
    assert not view.band.isVisible() and not view.back.isVisible()
    view.show_band(Message("PAST SURVEY: {name}", name="El Carmen 4"))
    refreshed(view)
    assert view.band.whole == "PAST SURVEY: El Carmen 4"
    assert view.back.isVisible()
    view.show_band(None)
    assert not view.back.isVisible()
    click_back = []
    view.back.clicked.connect(lambda: click_back.append(True))
    view.show_band(Message("PAST SURVEY: {name}", name="El Carmen 4"))
    click(view.back)
    assert click_back == [True]


def test_empty_states_say_what_to_do(window, view):
    window.show_tab(TabName.GROUND)
    window.draw()
    assert view.pictures.above.notice.startswith("No survey yet. Start one under")
    for key in (view.next, view.set_marker, view.finer, view.deeper):
        assert not key.isEnabled()
    fill(window, 0)
    assert "Touch the ground" in view.text.text()


def test_it_says_what_is_missing_in_the_picture(window, view):
    fill(window, 1, height_m=float("nan"))
    assert view.note.text().startswith(f"SIMULATED. {NO_MINE}")
    assert "No height was measured" in view.pictures.above.notice
    assert view.pictures.sections[0].axis is Axis.DELAY_NS
    assert not view.deeper.isEnabled()
    assert "The background is not removed from fewer than 8 traces" in view.note.text()
    window.traces.live.radar.give_up(5, verbatim("torn"))
    refreshed(view)
    assert "Cannot be shown: 1" in view.note.text()


def test_an_image_that_is_not_there_yet_is_said_to_be_on_its_way(window, view):
    fill(window)
    window.ground.model.switch(Layer.FOCUSED)
    refreshed(view)
    assert "not focused yet" in view.pictures.above.notice
    view.problem = Message("The imaging node does not answer.")
    refreshed(view)
    assert view.pictures.above.notice.startswith("The imaging node does not answer. ")
    window.additions.pictures.add_image(image_of(window.traces.live.map.grid))
    refreshed(view)
    assert view.pictures.above.numbers.shape == (13, 21)
    assert "Focused with permittivity 4." in view.note.text()


def test_depths_follow_the_soil_of_the_survey_whatever_the_plan_says(window, view):
    grid = make_grid(permittivity=9.0)
    window.control.form.set_text("permittivity", "15")
    window.control.show_plan()
    # So few that nothing is removed as background.
    fill(window, 6, grid=grid, s21=depth_echo(0.06, permittivity=9.0))
    shades, places = view.pictures.trace.points
    assert places[np.argmax(shades)] == pytest.approx(60.0, abs=5)
    window.ground.model.change(permittivity=4.0)
    refreshed(view)
    shades, places = view.pictures.trace.points
    assert places[np.argmax(shades)] == pytest.approx(90.0, abs=7)
    assert "Depths with permittivity 4; the survey has 9." in view.note.text()
    # Another screen stores another one.
    window.traces.live.begin(make_grid(permittivity=4.0))
    window.draw()
    assert "Depths with" not in view.note.text()


def test_an_image_is_asked_for_with_the_permittivity_that_is_chosen(window, monkeypatch):
    asked = []
    monkeypatch.setattr(window.ground._imaging, "keep", asked.append)
    fill(window)
    assert asked[-1].permittivity == 4.0
    window.ground.model.change(permittivity=9.0)
    window.draw()
    assert asked[-1].permittivity == 9.0


def test_over_a_candidate_nothing_is_said_to_be_nothing(window, view):
    fill(window)
    faint = candidate_list([candidate(level_db=7.0)], survey_id=SURVEY)
    image = dataclasses.replace(image_of(window.traces.live.map.grid, level_db=7.0), found=faint)
    window.additions.pictures.add_image(image)
    model = window.ground.model
    model.switch(Layer.FOCUSED)
    model.choose_mark(faint.candidates[0])
    refreshed(view)
    assert not model.pictures(()).above.above_noise
    for plot in (view.pictures.above, view.pictures.sections[0]):
        assert "Nothing above" not in plot.notice
    model.choose_place(200.0, 50.0)
    model.set_depth(0.25)
    refreshed(view)
    for plot in (view.pictures.above, view.pictures.sections[0]):
        assert "Nothing above the clutter" in plot.notice


def test_nothing_is_drawn_while_nobody_can_see_it(window, view):
    fill(window)
    window.show_tab(TabName.SURVEY)
    grid = make_grid(survey_id=PAST)
    window.traces.live.begin(grid)
    window.traces.live.take_traces([trace_at(grid, 0)])
    before = view.pictures.above.numbers
    window.draw()
    assert view.pictures.above.numbers is before
    window.show_tab(TabName.GROUND)
    assert (view.pictures.above.numbers != NOT_MEASURED).sum() == 1


def test_what_is_hidden_is_not_computed(filled, view, monkeypatch):
    found = []
    source = filled.ground.model._source
    monkeypatch.setattr(type(source), "line", lambda *_: found.append(True))
    view.enlarge(view.pictures.above)
    assert found == []


def test_a_finer_survey_is_framed_and_named(filled, view):
    folder = "20261121T061000_7c9e6679"
    related = RelatedSurvey(FINER, folder, True, Area(130.0, 170.0, 60.0, 100.0))
    filled.on_event(AdditionsRead(SURVEY, (), (related,)))
    filled.ground.model.follow(True)
    filled.draw()
    assert folder in view.text.text()
    assert [one.area for one in view._frames()] == [related.area]


def test_a_place_is_shown_from_another_page(filled, view):
    filled.ground.show_place(150.0, 70.0, 120.0)
    assert filled.ground.model.place == Place(150.0, 70.0)
    assert filled.ground.model.settings.depth_m == pytest.approx(0.12)


def test_a_place_that_is_shown_before_the_page_is_seen_stays(window, view):
    window.traces.live.begin(make_grid())
    cover(window, 40)
    window.show_tab(TabName.SURVEY)
    window.ground.show_place(150.0, 70.0, 120.0)
    window.show_tab(TabName.GROUND)
    window.draw()
    assert view.pictures.above.crosshair == (150.0, 70.0)


def choose_place(window):
    window.ground.view.next.click()
    assert window.ground.model.mark == SURE


def in_state(code):
    """Return what is known while the survey that is shown is in a state."""
    return snapshot(code, state=state_of(code, survey_id=SURVEY))


def test_a_finer_survey_goes_to_the_plan_and_starts_only_there(filled, view):
    choose_place(filled)
    click(view.finer)
    sheet = filled.ground.finer
    assert sheet.isVisible()
    click(sheet.sizes[1])
    click(sheet.use)
    assert filled.control.isVisible()
    p = filled.control.parameters
    assert (p.x_start_mm, p.x_stop_mm, p.x_points) == (50.0, 200.0, 16)
    assert (p.y_start_mm, p.y_stop_mm, p.y_points) == (15.0, 165.0, 16)
    assert p.polarizations_deg == (0.0, 90.0)
    assert filled.survey.asked == []
    assert filled.survey.finer == filled.additions.plan == sheet.plan
    filled.on_event(Answer(Request.START, True, verbatim("Survey started")))
    assert filled.survey.finer is filled.additions.plan is None


def test_a_plan_made_while_a_survey_runs_is_kept_found_again_and_dropped(filled, view):
    show(filled, in_state(SurveyState.SURVEYING))
    choose_place(filled)
    click(view.finer)
    sheet = filled.ground.finer
    assert "running" in sheet.note.text()
    click(sheet.use)
    assert view.isVisible()
    assert filled.survey.finer is None
    plan = filled.additions.plan
    assert [one.planned for one in view._frames()] == [True]
    show(filled, in_state(SurveyState.FINISHED))
    filled.draw()
    assert view.finer.text() == "Finer\nplan"
    click(view.finer)
    assert sheet.plan == plan
    click(sheet.use)
    assert filled.survey.finer == plan
    filled.show_tab(TabName.GROUND)
    click(view.finer)
    click(sheet.drop)
    assert filled.additions.plan is filled.survey.finer is None


def test_spacing_is_changed_by_touch_and_never_below_a_millimetre(filled, view):
    choose_place(filled)
    click(view.finer)
    sheet = filled.ground.finer
    for _ in range(20):
        click(sheet.closer)
    assert sheet.spacing.text() == "1 mm"
    assert "101 x 101 stops, 20402 traces" in sheet.figures.text()
    click(sheet.wider)
    assert sheet.spacing.text() == "2 mm"


def test_a_marker_is_written_on_the_pad_and_sent_to_the_storage(filled, view):
    choose_place(filled)
    click(view.set_marker)
    pad = filled.ground.note_pad
    assert pad.isVisible()
    pad.press("metal")
    pad.accept_button.click()
    ((_kind, survey, marker),) = asked(filled, "add marker")
    assert survey == SURVEY
    place = (marker.x_mm, marker.y_mm, marker.depth_mm)
    assert place == (SURE.x_mm, SURE.y_mm, SURE.depth_mm)
    assert marker.text.lower() == "metal"
    filled.on_event(MarkersStored(SURVEY, (MARKER, marker)))
    filled.draw()
    filled.ground.layers.open()
    assert filled.ground.layers.markers.text().endswith(": 2")


def test_a_replay_can_neither_be_marked_nor_measured_finer(filled, view):
    filled.additions.follow(SURVEY, can_read=False)
    choose_place(filled)
    refreshed(view)
    assert not view.set_marker.isEnabled()
    assert not view.finer.isEnabled()


def test_a_marker_that_was_not_stored_opens_a_dialog(filled):
    filled.on_event(MarkingFailed(SURVEY, MARKER.marker_id, verbatim("the disk is full")))
    assert filled.notice.isVisible()


def test_a_marker_is_shown_from_its_list_and_removed_only_by_holding(filled, view):
    filled.ground.layers.open()
    click(filled.ground.layers.markers)
    sheet = filled.ground.markers
    sheet.list.setCurrentRow(0)
    click(sheet.show_button)
    assert filled.ground.model.mark == MARKER
    sheet.show_markers(filled.additions.markers)
    sheet.list.setCurrentRow(0)
    click(sheet.remove)
    assert asked(filled, "remove marker") == []
    hold(sheet.confirm.hold)
    ((_kind, survey, marker_id, _author),) = asked(filled, "remove marker")
    assert (survey, marker_id) == (SURVEY, MARKER.marker_id)
    filled.on_event(MarkersStored(SURVEY, ()))
    filled.refresh()
    assert sheet.list.count() == 0


def test_what_belongs_to_a_survey_is_read_when_it_is_shown_and_when_one_ends(window):
    window.on_event(SurveyDescribed(description()))
    window.refresh()
    assert asked(window, "additions") == [("additions", SURVEY)]
    show(window, in_state(SurveyState.SURVEYING))
    show(window, in_state(SurveyState.FINISHED))
    assert len(asked(window, "additions")) == 3
