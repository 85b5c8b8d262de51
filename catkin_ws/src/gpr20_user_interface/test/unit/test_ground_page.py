"""GROUND in the window: touches, layers, candidates, markers, finer surveys, what it says."""

import dataclasses
import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from finger import colours, drag, touch
from map_kit import DOUBTED, MARKER, SURE, focused
from PyQt5.QtTest import QTest
from test_ground_model import image_of
from view_kit import PAST, SURVEY, make_grid, noise, trace_at
from window_helpers import click, close, hold, opened_window

from gpr20_common.catalogue import Language
from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.additions import (
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
)
from gpr20_operator.ground.coverage import CoverageRuns
from gpr20_operator.ground.model import Layer
from gpr20_operator.ground.records import Axis, Colours, Place
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.radar.soils import Soils
from gpr20_user_interface.window.rail import TabName

NO_MINE = "No echo does not mean no mine."


def fill(window, stored=40, s21=None, grid=None, **changes):
    """Let a window show a survey of which the first traces are stored and here."""
    grid = grid or make_grid()
    live = window.traces.live
    live.begin(grid)
    cover(window, stored)
    for index in range(stored):
        live.take_traces([trace_at(grid, index, s21, **changes)])
    window.show_tab(TabName.GROUND)
    window.refresh()
    window.draw()


def cover(window, stored, failures=()):
    """Say that the first traces of the plan are stored, and that the next ones have failed."""
    shown = window.traces.live.map
    planned, failed = shown.grid.planned, stored + len(failures)
    runs = [(0, 1), (stored, 3), (failed, 0)]
    runs = [one for one, end in zip(runs, (stored, failed, planned)) if one[0] < end]
    reasons = {stored + number: reason for number, reason in enumerate(failures)}
    shown.set_coverage(CoverageRuns(shown.grid.survey_id, planned, *zip(*runs), reasons))


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


def refreshed(view):
    """Let the picture that a finger has changed be drawn."""
    view.refresh()
    return view


def said(view):
    """Return the lines about the place that is chosen."""
    return refreshed(view).text.text().splitlines()


def area_px(plots):
    return sum(one.width() * one.height() for one in plots if one.isVisible())


def asked(window, kind):
    return [one for one in window.traces.source.asked if one[0] == kind]


@pytest.mark.parametrize("size", [(800, 480), (1280, 800)])
def test_the_pictures_fill_the_page_and_show_radar_nearly_wherever_they_are(window, view, size):
    window.resize(*size)
    for columns, rows, width, height, survey in (
        *((21, 21, 300, 300, SURVEY), (3, 40, 40, 600, PAST)),
        (40, 3, 600, 40, SURVEY),
    ):
        grid = make_grid(
            *(columns, rows, (0.0,), survey),
            **{"x_start_mm": 10.0, "x_stop_mm": 10.0 + width},
            **{"y_start_mm": 10.0, "y_stop_mm": 10.0 + height},
        )
        fill(window, 1, grid=grid)
        shown = [one for one in view.pictures.plots if one.isVisible()]
        assert area_px(shown) >= 0.55 * size[0] * size[1]
        radar = sum(one.area.width() * one.area.height() for one in shown)
        assert radar >= (0.97 if width == height else 0.6) * area_px(shown)
        assert view.pictures.sections[1].isVisible() == (size == (1280, 800))
        places = [one.geometry() for one in shown]
        assert not any(one.intersects(other) for one, other in itertools.combinations(places, 2))


def test_a_place_that_is_touched_or_shown_from_another_page_is_on_every_picture(filled, view):
    touch(view.pictures.above, 149.0, 91.0)
    assert said(view)[0] == "X 150, Y 90, depth 50 mm"
    assert filled.ground.model.place == Place(150.0, 90.0)
    assert view.pictures.above.crosshair == (150.0, 90.0)
    assert view.pictures.sections[0].labels == ("X mm", "Depth mm, at Y 90 mm")
    filled.show_tab(TabName.SURVEY)
    filled.ground.show_place(150.0, 70.0, 120.0)
    filled.show_tab(TabName.GROUND)
    filled.draw()
    assert view.pictures.above.crosshair == (150.0, 70.0)
    assert filled.ground.model.settings.depth_m == pytest.approx(0.12)


def test_candidates_and_markers_are_counted_visited_and_described(filled, view):
    filled.ground.model.follow(True)
    assert "1 candidate, 1 doubtful" in "\n".join(said(view))
    click(view.next)
    assert filled.ground.model.mark == SURE
    assert said(view) == ["Candidate 1", "X 125, Y 90, depth 85 mm", "21 dB above the clutter"]
    touch(view.pictures.above, SURE.x_mm, SURE.y_mm)
    assert filled.ground.model.mark == DOUBTED
    assert said(view)[0] == "Candidate 2, doubtful" and said(view)[-2:] == ["Clutter", "Edge"]
    touch(view.pictures.above, SURE.x_mm, SURE.y_mm)
    refreshed(view)
    assert filled.ground.model.mark is None
    touch(view.pictures.above, MARKER.x_mm, MARKER.y_mm)
    marker = ["Marker: raíz", "X 175, Y 70, depth 60 mm", "2026-11-21 05:10 UTC Ana"]
    assert said(view) == marker


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
    before = model.settings
    for key in (sheet.axis, sheet.scale, sheet.along, sheet.polarization, sheet.background):
        click(key)
    click(sheet.colours[Colours.GREY])
    assert model.settings == dataclasses.replace(
        before,
        in_depth=not before.in_depth,
        in_db=not before.in_db,
        along=Axis.Y_MM,
        polarization=1,
        remove_background=not before.remove_background,
        colours=Colours.GREY,
    )
    section = view.pictures.sections[0]
    assert section.axis is Axis.DELAY_NS and section.labels[0] == "Y mm"
    assert sheet.polarization.text() == "Antenna\n90°"
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
    assert view.pictures.above.isVisible() and view.layers.isVisible()
    view.begin_fit()
    click(view.drop)
    assert model.settings.permittivity == round(fitted, 1)
    view.begin_fit()
    filled.traces.live.begin(make_grid(survey_id=PAST))
    refreshed(view)
    assert not view.is_fitting


def test_nothing_above_the_noise_is_never_said_while_a_part_is_not_here(window, view):
    grid, draw = make_grid(), np.random.default_rng(1)
    traces = [trace_at(grid, index, noise(draw)) for index in range(40)]
    fill(window, 0, grid=grid)
    window.traces.live.take_traces(traces[:25])
    cover(window, 40)
    window.ground.model.set_depth(0.3)
    refreshed(view)
    assert window.ground.model.waiting is not None
    assert "loading 25/40" in view.note.text()
    assert all(one.notice == "" for one in (view.pictures.above, *view.pictures.sections))
    window.ground.model.choose_place(150.0, 110.0)
    refreshed(view)
    # Of the uppermost line nothing has come: its section is patterned as loading.
    section = view.pictures.sections[0]
    loading = colours(section, 150.0, 200.0, reach=8)
    cover(window, 25)
    refreshed(view)
    assert colours(section, 150.0, 200.0, reach=8) != loading
    cover(window, 40)
    window.traces.live.take_traces(traces[25:])
    refreshed(view)
    assert view.pictures.above.notice == f"Nothing above the noise at this depth. {NO_MINE}"
    assert section.notice == f"Nothing above the noise in this section. {NO_MINE}"
    cover(window, 30)
    refreshed(view)
    assert "A part is not measured." in view.pictures.above.notice


@pytest.mark.parametrize("language", [Language.ENGLISH, Language.SPANISH])
def test_the_safety_notice_is_whole_beside_any_picture_and_band(application, tmp_path, language):
    window = opened_window(application, language, profiles=tmp_path)
    try:
        fill(window)
        view, pictures = window.ground.view, window.ground.view.pictures
        name = Message("PAST SURVEY: {name}", name="2026-11-21 05:10, " + "El Carmen " * 9)
        for size, band in itertools.product([(480, 320), (800, 480), (1280, 800)], (None, name)):
            window.resize(*size)
            view.show_band(band)
            for plot in (None, pictures.above, pictures.sections[0], pictures.trace):
                pictures.enlarge(plot)
                refreshed(view)
                QTest.qWait(1)
                text = view.note.text()
                assert language is not Language.ENGLISH or NO_MINE in text
                assert view.note.isVisible()
                assert view.note.fontMetrics().horizontalAdvance(text) <= view.note.width()
                assert view.note.geometry().right() < view.width()
                assert band is None or view.band.width() >= 0.3 * view.width()
                texts = (text, view.text.text(), *(one.notice for one in pictures.plots))
                words = " ".join(texts).lower().replace(".", "").split()
                assert not {"clear", "free", "safe"} & set(words)
    finally:
        close(window)


def test_what_is_missing_is_said(window, view):
    window.show_tab(TabName.GROUND)
    window.draw()
    assert view.pictures.above.notice.startswith("No survey yet. Start one under")
    for key in (view.next, view.set_marker, view.finer, view.deeper):
        assert not key.isEnabled()
    fill(window, 0)
    assert "Touch the ground" in view.text.text()
    fill(window, 1, height_m=float("nan"))
    assert view.note.text().startswith(f"SIMULATED. {NO_MINE}")
    assert "No height was measured" in view.pictures.above.notice
    assert view.pictures.sections[0].axis is Axis.DELAY_NS
    assert not view.deeper.isEnabled()
    assert "The background is not removed from fewer than 8 traces" in view.note.text()
    window.traces.live.radar.give_up(5, verbatim("torn"))
    refreshed(view)
    assert "Cannot be shown: 1" in view.note.text()


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
    plots = (view.pictures.above, view.pictures.sections[0])
    assert not any("Nothing above" in plot.notice for plot in plots)
    model.choose_place(200.0, 50.0)
    model.set_depth(0.25)
    refreshed(view)
    assert all("Nothing above the clutter" in plot.notice for plot in plots)


def finer_sheet(window):
    """Choose a place and ask for a finer plan of it."""
    click(window.ground.view.next)
    click(window.ground.view.finer)
    return window.ground.finer


def test_a_finer_survey_goes_to_the_plan_and_starts_only_there(filled):
    sheet = finer_sheet(filled)
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


def test_a_marker_is_written_on_the_pad_and_sent_to_the_storage(filled, view):
    click(view.next)
    click(view.set_marker)
    pad = filled.ground.note_pad
    pad.press("metal")
    click(pad.accept_button)
    ((_kind, survey, marker),) = asked(filled, "add marker")
    assert (survey, marker.text.lower()) == (SURVEY, "metal")
    place = (marker.x_mm, marker.y_mm, marker.depth_mm)
    assert place == (SURE.x_mm, SURE.y_mm, SURE.depth_mm)
    filled.on_event(MarkersStored(SURVEY, (MARKER, marker)))
    filled.draw()
    filled.ground.layers.open()
    assert filled.ground.layers.markers.text().endswith(": 2")
    filled.on_event(MarkingFailed(SURVEY, MARKER.marker_id, verbatim("the disk is full")))
    assert filled.notice.isVisible()


def test_a_marker_is_shown_from_its_list_and_removed_only_by_holding(filled):
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
