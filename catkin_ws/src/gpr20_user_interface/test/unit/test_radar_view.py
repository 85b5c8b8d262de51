import os

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from view_kit import depth_echo, make_grid, trace_at

from gpr20_user_interface.mid.radar_model import RadarModel
from gpr20_user_interface.views.plots import LEVELS
from gpr20_user_interface.views.radar_view import RadarView


@pytest.fixture(scope="module")
def application():
    yield QApplication.instance() or QApplication([])


@pytest.fixture
def model():
    model = RadarModel()
    model.begin(make_grid())
    return model


@pytest.fixture
def view(application, model):
    view = RadarView(model)
    view.resize(800, 370)
    view.show()
    yield view
    view.close()


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)


def add(view, model, *indices, **changes):
    for index in indices:
        model.add(trace_at(model.grid, index, **changes))
    view.refresh()


def test_the_last_trace_the_line_and_the_slice_appear(view, model):
    add(view, model, 0)
    levels, places = view.trace_plot.points
    assert places[np.argmax(levels)] == pytest.approx(100.0, abs=7)
    assert (view.line_plot.colour_numbers != LEVELS).any(axis=0).tolist() == [True] + [False] * 4
    assert (view.slice_plot.colour_numbers != LEVELS).sum() == 1


def test_the_line_grows_trace_by_trace(view, model):
    for count, index in enumerate((0, 3, 4, 7, 8), 1):  # of polarization 0
        add(view, model, index)
        assert (view.line_plot.colour_numbers != LEVELS).any(axis=0).sum() == count
    add(view, model, 11)
    # The next line has begun.
    assert (view.line_plot.colour_numbers != LEVELS).any(axis=0).tolist() == [False] * 4 + [True]


def test_buttons_change_the_picture_and_not_the_data(view, model):
    add(view, model, *range(40))
    data = [model.echoes(number).copy() for number in (0, 1)]
    for button in (
        *(view.controls.scale, view.controls.axis, view.controls.background),
        *(view.controls.gain.more, view.controls.permittivity.less, view.controls.polarization),
    ):
        before = view.grab().toImage()
        click(button)
        assert view.grab().toImage() != before
    for number in (0, 1):
        assert (model.echoes(number) == data[number]).all()


def test_permittivity_and_gain_stop_at_their_ends(view):
    for _ in range(40):
        click(view.controls.permittivity.less)
        click(view.controls.gain.more)
    assert view.controls.settings.permittivity == 1.0
    assert not view.controls.permittivity.less.isEnabled()
    assert view.controls.settings.gain_db_per_ns == 10.0


def test_the_slider_chooses_the_depth_of_the_slice(view, model):
    add(view, model, *range(40), s21=depth_echo(0.1))
    click(view.controls.scale)  # linear
    view.depth_slider.setValue(20)
    assert view.controls.settings.depth_m == pytest.approx(0.1)
    near = view.slice_plot.shown_range[1]
    view.depth_slider.setValue(40)
    assert view.slice_plot.shown_range[1] < 0.05 * near
    assert "200 mm" in view.slice_plot.title_text


def test_it_never_says_that_there_is_nothing(view, model):
    add(view, model, *range(40), s21=np.zeros(501))
    assert "No echo does not mean no mine" in view.note.text()
    assert "clear" not in view.note.text().lower()


def test_it_says_what_is_missing_in_the_picture(view, model):
    assert "SIMULATED" in view.note.text()
    add(view, model, 0, height_m=float("nan"))
    assert "no height was measured" in view.note.text()
    click(view.controls.background)
    assert "background is not removed from fewer than 8 traces" in view.note.text()
    model.give_up(5, "torn")
    view.refresh()
    assert "cannot be shown: 1" in view.note.text()
    assert "1 of 40 traces" in view.note.text()


def test_nothing_is_drawn_while_nobody_can_see_it(view, model):
    view.hide()
    add(view, model, 0)
    assert not len(view.trace_plot.points[0])
    view.show()
    assert len(view.trace_plot.points[0])


def test_another_survey_of_the_same_length_is_drawn_anew(view, model):
    add(view, model, 0)
    model.begin(make_grid(survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7"))
    view.refresh()
    assert not len(view.trace_plot.points[0])
    assert view.slice_plot.colour_numbers is None


def test_one_rotation_is_enough(application):
    model = RadarModel()
    model.begin(make_grid(rotations_deg=(45.0,)))
    view = RadarView(model)
    view.show()
    add(view, model, 0)
    click(view.controls.polarization)
    assert view.controls.settings.polarization == 0
    assert "45°" in view.controls.polarization.text()
