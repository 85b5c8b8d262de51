import os

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QColor
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from view_kit import make_grid, trace_at

from gpr20_common.message import verbatim
from gpr20_user_interface.mid.map_coverage import CoverageRuns, StopState
from gpr20_user_interface.mid.map_grid import Cell, Stop
from gpr20_user_interface.mid.map_model import MapModel
from gpr20_user_interface.mid.radar_model import RadarModel
from gpr20_user_interface.views.look import Look
from gpr20_user_interface.views.map_canvas import STOP_MARKS
from gpr20_user_interface.views.map_view import MapView
from gpr20_user_interface.views.palette import Mark


@pytest.fixture(scope="module")
def application():
    yield QApplication.instance() or QApplication([])


class Shown:
    """A MAP tab of a survey of 5 x 4 stops; the first row is done, one stop failed."""

    def __init__(self, grid):
        self.grid = grid
        self.model, self.radar = MapModel(), RadarModel()
        self.model.set_grid(grid)
        self.radar.begin(grid)
        self.model.set_coverage(
            CoverageRuns(
                grid.survey_id, 40, (0, 10, 11, 12), (1, 3, 1, 0), {10: verbatim("ADC: no answer")}
            )
        )
        self.radar.add(trace_at(grid, 0))
        self.view = MapView(self.model, self.radar)
        self.view.resize(800, 370)
        self.view.show()

    def place(self, stop):
        x_px, y_px = self.view.canvas.geometry_now.to_screen(
            self.grid.xs_mm[stop.column], self.grid.ys_mm[stop.row]
        )
        return QPoint(round(x_px), round(y_px))

    def colour(self, stop, dx=3, dy=3):
        picture = self.view.canvas.grab().toImage()
        place = self.place(stop)
        return QColor(picture.pixel(place.x() + dx, place.y() + dy)).name()

    def touch(self, stop):
        QTest.mouseClick(self.view.canvas, Qt.LeftButton, Qt.NoModifier, self.place(stop))


@pytest.fixture
def shown(application):
    shown = Shown(make_grid())
    yield shown
    shown.view.close()


@pytest.mark.parametrize(
    ("stop", "state"),
    [
        (Stop(0, 0), StopState.DONE),
        (Stop(0, 4), StopState.DONE),
        (Stop(1, 4), StopState.FAILED),
        (Stop(1, 3), StopState.MISSING),
        (Stop(3, 0), StopState.MISSING),
    ],
)
def test_each_stop_has_the_colour_of_its_state(shown, stop, state):
    assert shown.colour(stop) == Look().colour(STOP_MARKS[state])


def test_the_first_row_lies_below_and_the_area_is_to_scale(shown):
    assert shown.place(Stop(0, 0)).y() > shown.place(Stop(3, 0)).y()
    across = shown.place(Stop(0, 4)).x() - shown.place(Stop(0, 0)).x()
    up = shown.place(Stop(0, 0)).y() - shown.place(Stop(3, 0)).y()
    assert across / up == pytest.approx(100.0 / 60.0, rel=0.02)


def test_a_reverse_survey_is_drawn_where_it_is_measured(application):
    shown = Shown(make_grid(x_start_mm=200.0, x_stop_mm=100.0, y_start_mm=110.0, y_stop_mm=50.0))
    assert shown.place(Stop(0, 0)).x() > shown.place(Stop(0, 4)).x()
    assert shown.colour(Stop(1, 4)) == Look().colour(STOP_MARKS[StopState.FAILED])
    assert shown.colour(Stop(1, 3)) == Look().colour(STOP_MARKS[StopState.MISSING])


def test_the_legend_counts(shown):
    assert shown.view.legend[StopState.DONE].text() == "Done: 5"
    assert shown.view.legend[StopState.FAILED].text() == "Failed: 1"
    assert shown.view.legend[StopState.MISSING].text() == "Missing: 14"


def test_a_touch_shows_the_trace_of_the_stop(shown):
    shown.touch(Stop(0, 0))
    assert shown.view.selected == Cell(Stop(0, 0), 0)
    assert "X 100 mm, Y 50 mm: Done" in shown.view.stop_text.text()
    levels, places = shown.view.trace_plot.points
    assert places[np.argmax(levels)] == pytest.approx(100.0, abs=7)
    QTest.mouseClick(shown.view.polarization, Qt.LeftButton)
    assert shown.view.selected.polarization == 1
    assert not len(shown.view.trace_plot.points[0])


def test_a_plot_without_a_trace_has_no_numbers_on_its_axes(shown):
    assert not shown.view.trace_plot.has_numbers
    shown.touch(Stop(0, 0))
    assert shown.view.trace_plot.has_numbers
    shown.touch(Stop(1, 4))
    assert not shown.view.trace_plot.has_numbers


def test_a_failed_stop_says_why(shown):
    shown.touch(Stop(1, 4))
    assert "ADC: no answer" in shown.view.stop_text.text()
    assert not len(shown.view.trace_plot.points[0])


def test_what_is_not_done_is_found_one_after_the_other(shown):
    QTest.mouseClick(shown.view.next_problem, Qt.LeftButton)
    assert shown.view.selected.stop == Stop(1, 0)
    QTest.mouseClick(shown.view.next_problem, Qt.LeftButton)
    assert shown.view.selected.stop == Stop(1, 1)


def test_the_current_stop_and_the_antennas_are_marked(shown):
    def mark():
        return shown.colour(Stop(2, 2), dx=-round(half_px), dy=5)

    geometry = shown.view.canvas.geometry_now
    half_px = 12.5 * geometry.px_per_mm
    shown.model.set_target((150.0, 90.0))
    shown.view.refresh()
    assert mark() == Look().colour(Mark.CURRENT)
    shown.model.set_target(None)
    shown.view.refresh()
    assert mark() != Look().colour(Mark.CURRENT)
    shown.view.set_carriage((175.0, 90.0))
    assert shown.colour(Stop(2, 3), dx=0, dy=0) == "#000000"
    shown.view.set_carriage(None)
    assert shown.colour(Stop(2, 3), dx=0, dy=0) == Look().colour(STOP_MARKS[StopState.MISSING])


def test_before_any_survey_it_says_so_and_takes_touches(application):
    view = MapView(MapModel(), RadarModel())
    view.resize(800, 370)
    view.show()
    QTest.mouseClick(view.canvas, Qt.LeftButton)
    assert view.selected is None
    assert view.legend[StopState.DONE].text() == "Done: —"
    assert not view.next_problem.isEnabled()


def test_another_survey_forgets_the_touched_stop(shown):
    shown.touch(Stop(3, 4))
    smaller = make_grid(3, 3, survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7")
    shown.model.set_grid(smaller)
    shown.radar.begin(smaller)
    shown.view.refresh()
    assert shown.view.selected is None
