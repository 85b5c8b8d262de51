"""GROUND in the window: touches, layers, candidates, markers, finer surveys, what it says."""

import dataclasses
import itertools

import numpy as np
import pytest
from candidate_examples import candidate, candidate_list
from finger import colours, drag, touch
from map_kit import DOUBTED, MARKER, SURE, focused
from PyQt5.QtTest import QTest
from test_ground_model import cover, image_of
from view_kit import PAST, SURVEY, make_grid, noise, trace_at
from window_helpers import click, hold

from gpr20_common.message import Message, verbatim
from gpr20_operator.ground.additions import (
    AdditionsRead,
    MarkersStored,
    MarkingFailed,
)
from gpr20_operator.ground.model import Layer
from gpr20_operator.ground.records import Axis, Colours
from gpr20_operator.robot.events import Answer, Request
from gpr20_survey.radar.soils import Soils
from gpr20_user_interface.window.rail import TabName

NO_MINE = "No echo does not mean no mine."


def fill(window, stored=40, **changes):
    """Let a window show a survey of which the first traces are stored and here."""
    grid, live = make_grid(), window.traces.live
    live.begin(grid)
    cover(window.ground.model, stored)
    live.take_traces([trace_at(grid, index, **changes) for index in range(stored)])
    window.show_tab(TabName.GROUND)
    window.refresh()
    window.draw()


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
    view.refresh()
    return view


def said(view):
    return refreshed(view).text.text().splitlines()


def test_a_place_that_is_touched_or_shown_from_another_page_is_on_every_picture(filled, view):
    touch(view.pictures.above, 149.0, 91.0)
    assert said(view)[0] == "X 150, Y 90, depth 50 mm"
    assert view.pictures.above.crosshair == (150.0, 90.0)
    assert view.pictures.sections[0].labels == ("X mm", "Depth mm, at Y 90 mm")
    filled.ground.show_place(150.0, 70.0, 120.0)
    filled.draw()
    assert view.pictures.above.crosshair == (150.0, 70.0)
    assert filled.ground.model.settings.depth_m == pytest.approx(0.12)


def test_candidates_and_markers_are_counted_visited_and_described(filled, view):
    filled.ground.model.follow(True)
    assert "2 places to check, 0 weaker echoes" in "\n".join(said(view))
    click(view.next)
    assert said(view) == ["Candidate 1", "X 125, Y 90, depth 85 mm", "21 dB above the clutter"]
    touch(view.pictures.above, SURE.x_mm, SURE.y_mm)
    assert filled.ground.model.mark == DOUBTED
    assert said(view)[0] == "Candidate 2" and said(view)[-1] == "Edge"
    touch(view.pictures.above, MARKER.x_mm, MARKER.y_mm)
    marker = ["Marker: raíz", "X 175, Y 70, depth 60 mm", "2026-11-21 05:10 UTC Ana"]
    assert said(view) == marker


def test_the_settings_change_what_is_drawn_and_never_the_data(filled, view):
    sheet, model = filled.ground.layers, filled.ground.model
    echoes = filled.traces.live.radar.echoes[0].copy()
    before = model.settings
    sheet.open()
    for name in ("axis", "scale", "along", "polarization", "background", "follow"):
        click(getattr(sheet, name))
    for key in (sheet.soils[Soils.WET_SAND], sheet.gain.more, sheet.colours[Colours.GREY]):
        click(key)
    now = dataclasses.asdict(model.settings).items()
    assert {name for name, value in now if getattr(before, name) == value} == {"depth_m"}
    section = view.pictures.sections[0]
    assert section.axis is Axis.DELAY_NS and section.labels[0] == "Y mm"
    assert not model.follows
    assert (filled.traces.live.radar.echoes[0] == echoes).all()


def test_another_permittivity_is_fitted_by_a_hyperbola(filled, view):
    model, section = filled.ground.model, view.pictures.sections[0]
    touch(view.pictures.above, 150.0, 90.0)
    filled.ground.layers.open()
    click(filled.ground.layers.fit)
    assert view.pictures.enlarged is section and not view.layers.isVisible()
    before = model.hyperbola
    drag(section, section.grip, (section.grip[0], section.grip[1] + 40.0))
    drag(refreshed(view).pictures.sections[0], (120.0, 300.0), (115.0, 160.0))
    fitted = model.hyperbola
    assert fitted.apex_delay_s > before.apex_delay_s
    assert fitted.permittivity != before.permittivity
    click(view.use)
    assert view.pictures.above.isVisible() and view.layers.isVisible()
    assert model.settings.permittivity == round(fitted.permittivity, 1)
    view.begin_fit()
    filled.traces.live.begin(make_grid(survey_id=PAST))
    assert not refreshed(view).is_fitting


def test_nothing_above_the_noise_is_never_said_while_a_part_is_not_here(window, view):
    fill(window, 0)
    draw, model = np.random.default_rng(1), window.ground.model
    traces = [trace_at(make_grid(), index, noise(draw)) for index in range(40)]
    window.traces.live.take_traces(traces[:25])
    cover(model, 40)
    model.set_depth(0.3)
    model.choose_place(150.0, 110.0)
    section = refreshed(view).pictures.sections[0]
    assert "loading 25/40" in view.note.text()
    assert all(one.notice == "" for one in (view.pictures.above, *view.pictures.sections))
    # Of the uppermost line nothing has come: its section is patterned as loading.
    loading = colours(section, 150.0, 200.0, reach=8)
    cover(model, 25)
    assert colours(refreshed(view).pictures.sections[0], 150.0, 200.0, reach=8) != loading
    cover(model, 40)
    window.traces.live.take_traces(traces[25:])
    refreshed(view)
    assert view.pictures.above.notice == f"Nothing above the noise at this depth. {NO_MINE}"
    assert section.notice == f"Nothing above the noise in this section. {NO_MINE}"
    cover(model, 30)
    assert "A part is not measured." in refreshed(view).pictures.above.notice


def test_the_safety_notice_is_whole_beside_any_picture_and_band(filled, view):
    pictures = view.pictures
    name = Message("PAST SURVEY: {name}", name="2026-11-21 05:10, " + "El Carmen " * 9)
    plots = (None, pictures.above, pictures.sections[0], pictures.trace)
    for size, band, plot in itertools.product([(480, 320), (800, 480)], (None, name), plots):
        filled.resize(*size)
        view.show_band(band)
        pictures.enlarge(plot)
        refreshed(view)
        QTest.qWait(1)
        text = view.note.text()
        assert NO_MINE in text and view.note.isVisible()
        assert view.note.fontMetrics().horizontalAdvance(text) <= view.note.width()
        assert view.note.geometry().right() < view.width()
        texts = (text, view.text.text(), *(one.notice for one in pictures.plots))
        words = " ".join(texts).lower().replace(".", "").split()
        assert not {"clear", "free", "safe"} & set(words)


def test_what_is_missing_is_said(window, view):
    window.show_tab(TabName.GROUND)
    window.draw()
    assert view.pictures.above.notice.startswith("No survey yet. Start one under")
    for key in (view.next, view.set_marker, view.finer, view.deeper):
        assert not key.isEnabled()
    fill(window, 1, height_m=float("nan"))
    assert view.note.text().startswith(f"SIMULATED. {NO_MINE}")
    assert "No height was measured" in view.pictures.above.notice
    assert view.pictures.sections[0].axis is Axis.DELAY_NS and not view.deeper.isEnabled()
    assert "The background is not removed from fewer than 8 traces" in view.note.text()
    window.traces.live.radar.give_up(5, verbatim("torn"))
    assert "Cannot be shown: 1" in refreshed(view).note.text()


def test_over_a_candidate_nothing_is_said_to_be_nothing(window, view):
    fill(window)
    faint = candidate_list([candidate(level_db=7.0)], survey_id=SURVEY)
    window.additions.pictures.add_image(image_of(window.traces.live.map.grid, 7.0, faint))
    model = window.ground.model
    model.switch(Layer.FOCUSED)
    model.choose_mark(faint.candidates[0])
    refreshed(view)
    assert not model.pictures(()).above.above_noise
    plots = (view.pictures.above, view.pictures.sections[0])
    assert not any("Nothing above" in plot.notice for plot in plots)
    model.choose_place(200.0, 50.0, 250.0)
    refreshed(view)
    assert all("Nothing above the clutter" in plot.notice for plot in plots)


def test_a_finer_survey_goes_to_the_plan_and_starts_only_there(filled):
    sheet = filled.ground.finer
    click(filled.ground.view.next)
    click(filled.ground.view.finer)
    click(sheet.sizes[1])
    click(sheet.use)
    assert filled.control.isVisible()
    # The address is that of the configuration, which the plan follows.
    planned = dataclasses.replace(sheet.plan.parameters, vna_address="")
    assert filled.control.parameters == planned
    assert filled.survey.asked == []
    assert filled.survey.finer == filled.additions.plan == sheet.plan
    filled.on_event(Answer(Request.START, True, verbatim("Survey started")))
    assert filled.survey.finer is filled.additions.plan is None


def test_a_marker_is_written_on_the_pad_and_removed_only_by_holding(filled, view):
    asked, sheet = filled.traces.source.asked, filled.ground.markers
    click(view.next)
    click(view.set_marker)
    filled.ground.note_pad.press("metal")
    click(filled.ground.note_pad.accept_button)
    kind, survey, marker = asked[-1]
    assert (kind, survey, marker.text.lower()) == ("add marker", SURVEY, "metal")
    place = (marker.x_mm, marker.y_mm, marker.depth_mm)
    assert place == (SURE.x_mm, SURE.y_mm, SURE.depth_mm)
    filled.on_event(MarkersStored(SURVEY, (marker,)))
    filled.draw()
    filled.ground.layers.open()
    click(filled.ground.layers.markers)
    sheet.list.setCurrentRow(0)
    before = len(asked)
    click(sheet.remove)
    assert len(asked) == before
    hold(sheet.confirm.hold)
    assert asked[-1][:3] == ("remove marker", SURVEY, marker.marker_id)
    filled.on_event(MarkingFailed(SURVEY, MARKER.marker_id, verbatim("the disk is full")))
    assert filled.notice.isVisible()
