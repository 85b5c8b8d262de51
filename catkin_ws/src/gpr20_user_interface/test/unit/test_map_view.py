import numpy as np
import pytest
from hiding_kit import a_map
from map_kit import DOUBTED, FINER, MARKER, SURE, focused
from PyQt5.QtCore import QPoint, Qt
from PyQt5.QtGui import QColor
from PyQt5.QtTest import QTest
from view_kit import make_grid, trace_at
from window_helpers import Storage

from gpr20_common.message import verbatim
from gpr20_operator.ground.additions import AdditionsPresenter, AdditionsRead, RelatedSurvey
from gpr20_operator.ground.coverage import CoverageRuns, StopState
from gpr20_operator.ground.echoes import RadarModel
from gpr20_operator.ground.geometry import Area
from gpr20_operator.ground.grid import Cell, Stop
from gpr20_operator.ground.map_model import MapModel
from gpr20_operator.jobs.imaging import HidingMapped, ImageFocused
from gpr20_user_interface.look.look import Look, Mark
from gpr20_user_interface.pages.ground.map_view import MapView


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
        self.storage = Storage()
        self.additions = AdditionsPresenter(self.storage, lambda: "Ana")
        self.additions.follow(grid.survey_id, True)
        self.view = MapView(self.model, self.radar, self.additions)
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


def test_each_stop_has_the_colour_of_its_state(shown):
    # In the middle, and to the right of it: the pattern differs too.
    done, failed = (Mark.STOP_DONE, Mark.STOP_DONE), (Mark.PAPER, Mark.STOP_FAILED)
    missing = (Mark.STOP_MISSING, Mark.PAPER)
    for stop, colours in (
        (Stop(0, 0), done),
        (Stop(0, 4), done),
        (Stop(1, 4), failed),
        (Stop(1, 3), missing),
        (Stop(3, 0), missing),
    ):
        found = (shown.colour(stop, 0, 0), shown.colour(stop, 18, 1))
        assert found == tuple(Look().colour(one) for one in colours), stop
    legend = [shown.view.legend[state].text() for state in (*StopState,)]
    assert {"Done: 5", "Failed: 1", "Missing: 14"} <= set(legend)


def test_the_first_row_lies_below_and_the_area_is_to_scale(shown):
    assert shown.place(Stop(0, 0)).y() > shown.place(Stop(3, 0)).y()
    across = shown.place(Stop(0, 4)).x() - shown.place(Stop(0, 0)).x()
    up = shown.place(Stop(0, 0)).y() - shown.place(Stop(3, 0)).y()
    assert across / up == pytest.approx(100.0 / 60.0, rel=0.02)


def test_a_reverse_survey_is_drawn_where_it_is_measured(application):
    shown = Shown(make_grid(x_start_mm=200.0, x_stop_mm=100.0, y_start_mm=110.0, y_stop_mm=50.0))
    assert shown.place(Stop(0, 0)).x() > shown.place(Stop(0, 4)).x()
    assert shown.colour(Stop(1, 4), 18, 1) == Look().colour(Mark.STOP_FAILED)
    assert shown.colour(Stop(1, 3), 0, 0) == Look().colour(Mark.STOP_MISSING)


def test_a_touch_says_what_the_stop_is_and_offers_its_trace(shown):
    assert not shown.view.trace.isEnabled()
    shown.touch(Stop(0, 0))
    assert shown.view.selected.cell == Cell(Stop(0, 0), 0)
    assert shown.view.text.text() == "X 100 mm, Y 50 mm: Done"
    wanted = []
    shown.view.trace_wanted.connect(wanted.append)
    QTest.mouseClick(shown.view.trace, Qt.LeftButton)
    assert wanted == [Cell(Stop(0, 0), 0)]


def test_what_is_not_done_is_found_one_after_the_other_and_says_why(shown):
    for column in (0, 1):
        QTest.mouseClick(shown.view.next_problem, Qt.LeftButton)
        assert shown.view.selected.cell.stop == Stop(1, column)
    shown.touch(Stop(1, 4))
    assert "ADC: no answer" in shown.view.text.text()
    assert "No trace to show" in shown.view.text.text()


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
    assert shown.colour(Stop(2, 3), dx=0, dy=0) == Look().colour(Mark.STOP_MISSING)


def test_before_any_survey_it_says_so_and_takes_touches(application):
    view = MapView(MapModel(), RadarModel(), AdditionsPresenter(Storage(), str))
    view.resize(800, 370)
    view.show()
    QTest.mouseClick(view.canvas, Qt.LeftButton)
    assert view.selected is None
    assert not view.set_marker.isEnabled()
    assert not view.finer.isEnabled()
    assert view.legend[StopState.DONE].text() == "Done: —"
    assert not view.next_problem.isEnabled()


def test_another_survey_forgets_the_touched_stop(shown):
    shown.touch(Stop(3, 4))
    smaller = make_grid(3, 3, survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7")
    shown.model.set_grid(smaller)
    shown.radar.begin(smaller)
    shown.view.refresh()
    assert shown.view.selected is None


def clicked(shown, button, signal):
    """Return what a signal of the view carries after a click."""
    found = []
    signal.connect(lambda *values: found.append(values))
    QTest.mouseClick(button, Qt.LeftButton)
    return found


def touch_place(shown, x_mm, y_mm):
    x_px, y_px = shown.view.canvas.geometry_now.to_screen(x_mm, y_mm)
    place = QPoint(round(x_px), round(y_px))
    QTest.mouseClick(shown.view.canvas, Qt.LeftButton, Qt.NoModifier, place)


def test_a_candidate_is_touched_and_described(shown):
    shown.additions.on_event(ImageFocused(focused()))
    shown.view.refresh()
    touch_place(shown, SURE.x_mm, SURE.y_mm)
    assert shown.view.selected.mark == SURE
    text = shown.view.text.text()
    assert text == "Candidate 1\nX 125 mm, Y 90 mm, depth 85 mm\n21 dB above the clutter"
    touch_place(shown, SURE.x_mm, SURE.y_mm)
    assert shown.view.selected.mark == DOUBTED
    assert "doubtful" in shown.view.text.text()
    assert shown.view.text.text().splitlines()[-2:] == ["Clutter", "Edge"]
    assert clicked(shown, shown.view.set_marker, shown.view.marker_wanted) == [(125.0, 90.0, 140.0)]


def test_candidates_are_drawn_with_the_sentence_that_they_are_no_clearance(shown):
    def is_white_below_the_axis():
        picture = shown.view.canvas.grab().toImage()
        line_px = shown.view.canvas.fontMetrics().height()
        top = round(shown.view.canvas.geometry_now.bottom_px) + line_px + 8
        return all(
            QColor(picture.pixel(x, y)).name() == "#ffffff"
            for y in range(top, min(top + line_px, picture.height()))
            for x in range(picture.width())
        )

    height = shown.view.canvas.geometry_now.bottom_px
    assert is_white_below_the_axis()
    shown.additions.on_event(ImageFocused(focused(candidates=())))
    shown.view.refresh()
    assert shown.view.canvas.geometry_now.bottom_px < height
    assert not is_white_below_the_axis()


def test_a_candidate_that_is_gone_is_no_longer_selected(shown):
    shown.additions.on_event(ImageFocused(focused()))
    shown.view.refresh()
    QTest.mouseClick(shown.view.next_candidate, Qt.LeftButton)
    assert shown.view.selected.mark == SURE
    shown.additions.on_event(ImageFocused(focused((DOUBTED,))))
    shown.view.refresh()
    assert shown.view.selected is None


def test_a_marker_is_drawn_touched_and_described(shown):
    before = shown.colour(Stop(1, 3), 0, -8)
    shown.additions.on_event(AdditionsRead(shown.grid.survey_id, (MARKER,), ()))
    shown.view.refresh()
    assert shown.colour(Stop(1, 3), 0, -8) == Look().colour(Mark.MARKER) != before
    assert shown.view.markers.text() == "Markers\n1"
    touch_place(shown, MARKER.x_mm, MARKER.y_mm)
    assert shown.view.selected.mark == MARKER
    assert shown.view.text.text().splitlines() == [
        "Marker: raíz",
        "X 175 mm, Y 70 mm, depth 60 mm",
        "2026-11-21 05:10 UTC Ana",
    ]


def test_a_finer_survey_is_framed_and_named(shown):
    folder = "20261121T061000_7c9e6679"
    related = RelatedSurvey(FINER, folder, True, Area(130.0, 170.0, 60.0, 100.0))
    shown.additions.on_event(AdditionsRead(shown.grid.survey_id, (), (related,)))
    shown.view.refresh()
    assert folder in shown.view.text.text()
    x_px, y_px = shown.view.canvas.geometry_now.to_screen(150.0, 100.0)
    picture = shown.view.canvas.grab().toImage()
    assert QColor(picture.pixel(round(x_px), round(y_px))).name() == Look().colour(Mark.INK)


def test_the_frame_of_a_larger_survey_crosses_no_axis(shown):
    canvas = shown.view.canvas
    related = RelatedSurvey(
        FINER, "20261121T061000_7c9e6679", False, Area(-900.0, 900.0, 62.0, 900.0)
    )
    shown.additions.on_event(AdditionsRead(shown.grid.survey_id, (), (related,)))
    geometry = canvas.geometry_now
    picture = canvas.grab().toImage()
    y_px = round(geometry.to_screen(0.0, 62.0)[1])
    left_px = round(geometry.to_screen(geometry.shown.left_mm, 0.0)[0])
    ink = Look().colour(Mark.INK)
    assert QColor(picture.pixel(left_px + 3, y_px)).name() == ink
    assert QColor(picture.pixel(left_px - 8, y_px)).name() != ink


def test_a_place_is_measured_finer_or_marked_but_not_that_of_a_replay(shown):
    shown.touch(Stop(2, 2))
    ((selected,),) = clicked(shown, shown.view.finer, shown.view.finer_wanted)
    assert (selected.x_mm, selected.y_mm) == (150.0, 90.0)
    assert clicked(shown, shown.view.set_marker, shown.view.marker_wanted) == [(150.0, 90.0, None)]
    shown.additions.follow(shown.grid.survey_id, can_read=False)
    shown.touch(Stop(2, 2))
    assert not shown.view.set_marker.isEnabled()
    assert not shown.view.finer.isEnabled()


def test_where_a_mine_could_hide_is_hatched(shown):
    stops = [Stop(0, 0), Stop(0, 4)]
    places = [shown.place(one) for one in stops]

    def colours(place):
        picture = shown.view.canvas.grab().toImage()
        return {
            QColor(picture.pixel(place.x() + dx, place.y() + dy)).name()
            for dx in range(-6, 7) for dy in range(-6, 7)
        }  # fmt: skip

    before = [colours(one) for one in places]
    x_m, y_m = shown.grid.xs_mm / 1e3, shown.grid.ys_mm / 1e3
    shape = (1, len(y_m), len(x_m))
    tried, found = np.full(shape, 10), np.full(shape, 10)
    found[0, :, : shape[2] // 2] = 0
    shown.additions.on_event(
        HidingMapped(
            "a",
            a_map(found, tried, x_m=np.sort(x_m), y_m=np.sort(y_m), survey_id=shown.grid.survey_id),
        )
    )
    hidden = [Look().colour(Mark.PAPER) in colours(one) - was for one, was in zip(places, before)]
    assert hidden == [bool(shown.grid.xs_mm[0] < shown.grid.xs_mm[-1]), False] or hidden == [
        False,
        bool(shown.grid.xs_mm[0] > shown.grid.xs_mm[-1]),
    ]
