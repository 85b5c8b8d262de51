"""The viewer's window, on a screen that nobody sees."""

from __future__ import annotations

import os
import signal
import threading
import time

import numpy as np
import pytest

pytest.importorskip("PyQt5")
pytest.importorskip("pyqtgraph")

from ground_kit import point, scene, survey_of
from PyQt5 import sip
from PyQt5.QtCore import QPoint, QPointF, Qt, QTimer
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLineEdit

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DAMAGED, DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_survey.results.candidates import Candidate, CandidateList
from gpr20_viewer import view_command
from gpr20_viewer.faults import NO_SCREEN
from gpr20_viewer.identity import SurveyIdentity
from gpr20_viewer.picks_file import PicksFile
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.colours import LEVELS
from gpr20_viewer.views.main_window import MainWindow
from gpr20_viewer.views.pick_desk import PickDesk
from gpr20_viewer.views.volume_view import ProjectionsView

PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(240.0, 240.0, 0.083)
PLACE = Place(0.24, 0.24, 0.083)
LIMIT_S = 60.0
WORKER = "latest worker"


@pytest.fixture(scope="module")
def survey():
    survey = survey_of(scene([TARGET]), PLACES_MM, PLACES_MM)
    return survey.assign_attrs(survey_id="0f8fad5b-d9cb-469f-a165-70867728950e")


class Windows:
    """Opens windows, and closes them when the test ends."""

    def __init__(self, folder):
        self._folder, self._opened = folder, []
        self.answers, self.export = [], None

    def open(self, survey, catalogue=None, find_candidates=None, **options):
        catalogue = catalogue or Catalogue()
        session = ViewSession(
            survey, ImageOptions(**{"permittivity": 4.0, **options}), find_candidates
        )
        file = PicksFile(self._folder / "survey.picks.json", SurveyIdentity.of(session.survey))
        desk = PickDesk(file, "", lambda: "2026-11-22T12:00:00Z", catalogue, lambda: self.export)
        window = MainWindow(session, desk, "survey", catalogue, True, lambda _: self.answers.pop())
        window.show()
        self._opened.append(window)
        return window

    def close(self, window):
        window.close()
        self._opened.remove(window)
        window.bridge.close()
        sip.delete(window)

    def close_all(self):
        for window in list(self._opened):
            self.answers = [True]
            self.close(window)


@pytest.fixture
def windows(application, tmp_path):
    windows = Windows(tmp_path)
    yield windows
    windows.close_all()


def wait(condition, what):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s, what
        QApplication.processEvents()
        threading.Event().wait(0.002)


def computed(window):
    wait(lambda: not window.is_computing, "the image is computed")
    return window


def click_at(plot, across, down):
    """Click where a place of a plot is drawn."""
    QApplication.processEvents()
    at = plot.mapFromScene(plot.getViewBox().mapViewToScene(QPointF(across, down)))
    QTest.mouseClick(plot.viewport(), Qt.LeftButton, Qt.NoModifier, at)


def near(one, other, apart_m=0.004):
    return (
        max(abs(one.x_m - other.x_m), abs(one.y_m - other.y_m), abs(one.depth_m - other.depth_m))
        < apart_m
    )


def test_every_view_shows_the_same_place(windows, survey):
    window = computed(windows.open(survey))
    window.move_to(PLACE)
    assert window.sections.slice.cursor_place == (240.0, 240.0)
    assert window.sections.section.cursor_place == pytest.approx((240.0, 83.0))
    across_mm, delay_ns = window.sections.b_scan.cursor_place
    assert across_mm == 240.0 and abs(delay_ns - window.scene.delay_ns(PLACE)) < 1e-6
    _x, delays_ns = window.sections.b_scan.hyperbola.getData()
    assert np.argmin(delays_ns) == 5 and abs(delays_ns.min() - delay_ns) < 1e-6
    plots = window.volume.plots
    assert plots["depth"].cursor_place == (240.0, 240.0)
    assert plots["x"].cursor_place == pytest.approx((240.0, 83.0))
    assert "x 240 mm, y 240 mm, depth 83 mm" in window.cursor_text.text()
    # Without OpenGL there are projections.
    assert isinstance(window.volume, ProjectionsView)
    assert all(plot.colours is not None for plot in plots.values())
    QApplication.processEvents()
    picture = window.grab().toImage()
    assert (picture.width(), picture.height()) == (window.width(), window.height())
    assert len({picture.pixel(x, y) for x in range(0, 900, 5) for y in range(0, 800, 5)}) > 50


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_single_line_fills_the_window_with_its_traces_and_its_section(windows, survey, along):
    across = "y" if along == "x" else "x"
    line = survey.isel({across: [5]})
    window = computed(windows.open(line))
    sections, controls = window.sections, window.controls
    for width, height in ((800, 480), (1280, 800)):
        window.resize(width, height)
        QApplication.processEvents()
        assert (window.width(), window.height()) == (width, height)
        assert not sections.slice.isVisible() and not window.volume.isVisible()
        for plot in (sections.b_scan, sections.section):
            assert plot.isVisible() and plot.width() > 0.4 * width and plot.height() > 0.3 * height
            assert plot.colours.shape[1] == 11 and len(np.unique(plot.colours)) > 20
    assert not controls.direction.isEnabled()
    assert controls.direction.currentText() == f"along {along}: a single line"
    QTest.keyClick(window, Qt.Key_L)
    click_at(sections.section, 240.0, 83.0)
    assert near(window.place, PLACE)
    title = sections.section.getPlotItem().titleLabel.text
    assert f"along {along}" in title
    QTest.keyClick(window, Qt.Key_P)
    assert sections.b_scan.picks.count == 1 == sections.section.picks.count


def test_a_click_in_any_view_moves_all(windows, survey):
    window = computed(windows.open(survey))
    sections = window.sections
    for along, start in enumerate((Place(0.2, 0.24, 0.15), Place(0.24, 0.2, 0.15))):
        window.controls.direction.setCurrentIndex(along)
        window.move_to(PLACE)
        delay_ns = window.scene.delay_ns(PLACE)
        for plot, begin, across, down in (
            (sections.slice, Place(0.2, 0.3, 0.083), 240.0, 240.0),
            (sections.section, start, 240.0, 83.0),
            (sections.b_scan, start, 240.0, delay_ns),
        ):
            window.move_to(begin)
            click_at(plot, across, down)
            assert near(window.place, PLACE), plot


def test_the_slider_makes_a_new_image_and_the_latest_value_wins(windows, survey):
    window = computed(windows.open(survey))
    before = window.sections.section.colours.copy()
    for steps in range(150, 260, 2):
        window.controls.slider.setValue(steps)
    assert window.is_computing and "computing" in window.status.caption.text()
    # Of the image that is still shown.
    assert "permittivity 4 (3.6 to 4.4)," in window.status.caption.text()
    computed(window)
    assert window.image.permittivity == window.controls.permittivity > 10.0
    assert window.image.source == "slider"
    assert "set with the slider" in window.status.caption.text()
    assert not np.array_equal(before, window.sections.section.colours)


def test_without_a_permittivity_the_slider_is_at_what_is_assumed(windows, survey):
    window = computed(windows.open(survey, permittivity=None))
    assert window.controls.permittivity == window.image.permittivity == 5.0
    assert "ASSUMED" in window.status.caption.text()
    assert not window.is_computing


def test_settings_change_what_is_shown(windows, survey):
    window = computed(windows.open(survey))
    controls, sections = window.controls, window.sections
    first = sections.section.colours.copy()
    controls.range.setValue(20.0)
    assert (sections.section.colours == 0).sum() > (first == 0).sum()
    assert "-20 to 0 dB" in window.scale.text.text()
    controls.range.setValue(40.0)
    controls.gain.setValue(6.0)
    assert "display gain 6 dB/ns" in window.status.caption.text()
    controls.gain.setValue(0.0)
    controls.deepest.setValue(150.0)
    computed(window)
    assert window.image.depth_m[-1] == pytest.approx(0.15, abs=0.003)
    traces = sections.b_scan.colours.copy()
    controls.background.setChecked(False)
    computed(window)
    assert not np.array_equal(traces, sections.b_scan.colours)
    controls.polarization.setCurrentIndex(1)
    assert window.scene.polarization_deg == 90.0


def test_an_image_that_cannot_be_made_says_why_and_the_last_one_keeps_its_caption(windows, survey):
    window = computed(windows.open(survey))
    window.controls.deepest.setValue(5000.0)
    window.controls.permittivity_box.setValue(30.0)
    computed(window)
    assert "frequency step" in window.status.problem.text()
    assert "permittivity 4 (3.6 to 4.4)," in window.status.caption.text()
    QTest.keyClick(window, Qt.Key_P)
    assert window.desk.editor.picks == ()
    window.controls.deepest.setValue(300.0)
    computed(window)
    assert window.status.problem.text() == "" and window.image.permittivity == 30.0


def test_picks_are_stored_at_once_and_shown_again(windows, survey, tmp_path):
    window = computed(windows.open(survey))
    window.move_to(PLACE)
    window.pick()
    window.desk.set_note("P1", "strong echo")
    table = window.desk.table.table
    assert [table.item(0, column).text() for column in range(6)] == [
        "P1", "240", "240", "83", "0°", "strong echo",
    ]  # fmt: skip
    assert window.sections.slice.picks.count == 1 == window.sections.b_scan.picks.count
    assert "no clearance" in window.desk.table.notice.text()
    windows.close(window)
    again = computed(windows.open(survey))
    assert again.desk.editor.picks[0].note == "strong echo"
    again.controls.polarization.setCurrentIndex(1)
    assert again.sections.slice.picks.count == 0
    windows.export = tmp_path / "picks.csv"
    again.desk.export()
    assert "strong echo" in windows.export.read_text()


def test_a_pick_moves_with_the_permittivity_of_the_image(windows, survey):
    window = computed(windows.open(survey))
    window.move_to(PLACE)
    window.pick()
    window.controls.permittivity_box.setValue(16.0)
    computed(window)
    _traces, section, _slice = window.scene.pick_marks(window.desk.editor.picks)
    assert section[0].down == pytest.approx(41.5)
    assert window.desk.editor.picks[0].depth_m == 0.083


def test_a_bounced_click_makes_one_pick(windows, survey):
    window = computed(windows.open(survey))
    window.click_picks.setChecked(True)
    plot = window.sections.slice
    for _ in range(3):
        click_at(plot, 220.0, 260.0)
    assert len(window.desk.editor.picks) == 1
    click_at(plot, 300.0, 200.0)
    assert len(window.desk.editor.picks) == 2


KEYS = (
    Qt.Key_Left, Qt.Key_Right, Qt.Key_Up, Qt.Key_Down, Qt.Key_PageUp, Qt.Key_PageDown,
    Qt.Key_Plus, Qt.Key_Minus, Qt.Key_P, Qt.Key_P, Qt.Key_C, Qt.Key_Delete, Qt.Key_R, Qt.Key_L,
    Qt.Key_B, Qt.Key_F,
)  # fmt: skip


def test_random_keys_and_clicks_leave_picks_whole(windows, survey):
    draw = np.random.default_rng(0)
    window = computed(windows.open(survey))
    plots = [*window.sections.plots, *window.volume.plots.values()]
    for _ in range(100):
        kind = draw.integers(4)
        if kind == 0:
            plot = plots[draw.integers(len(plots))]
            at = QPoint(draw.integers(plot.width()), draw.integers(plot.height()))
            QTest.mouseClick(plot.viewport(), Qt.LeftButton, Qt.NoModifier, at)
        elif kind == 1:
            key = (Qt.Key_Z, Qt.Key_Y)[draw.integers(2)]
            QTest.keyClick(window, key, Qt.ControlModifier)
        else:
            QTest.keyClick(window, KEYS[draw.integers(len(KEYS))])
        if draw.random() < 0.1:
            computed(window)
    computed(window)
    picks = window.desk.editor.picks
    if window.desk.editor.can_undo:
        window.desk.undo()
        window.desk.redo()
    assert window.desk.editor.picks == picks
    windows.close(window)
    assert computed(windows.open(survey)).desk.editor.picks == picks


def test_letters_of_a_note_are_no_commands(windows, survey):
    window = computed(windows.open(survey))
    window.activateWindow()
    QTest.keyClick(window, Qt.Key_P)
    table = window.desk.table.table
    table.editItem(table.item(0, 5))
    QApplication.processEvents()
    line = table.findChild(QLineEdit)
    QTest.keyClicks(line, "pcbl")
    QTest.keyClick(line, Qt.Key_Return)
    QApplication.processEvents()
    assert [one.note for one in window.desk.editor.picks] == ["pcbl"]
    assert not window.click_picks.isChecked() and window.controls.background.isChecked()


def test_picks_that_cannot_be_stored_say_so_and_are_not_lost_silently(windows, survey, tmp_path):
    window = computed(windows.open(survey))
    window.pick()
    (tmp_path / "survey.picks.json").write_text("{}")
    window.move_to(PLACE)
    window.pick()
    assert "NOT SAVED" in window.desk.table.state.text() and window.desk.is_unsaved
    windows.answers = [False]
    window.close()
    assert window.isVisible() and windows.answers == []


def test_a_simulated_survey_says_so_and_a_measured_one_does_not(windows, survey):
    window = windows.open(survey)
    assert window.status.banner.isVisible() and "SIMULATED" in window.windowTitle()
    measured = windows.open(survey.assign_attrs(simulated=0))
    assert not measured.status.banner.isVisible() and "SIMULATED" not in measured.windowTitle()


def test_what_was_not_measured_is_grey_and_marked(windows, survey):
    holed = survey.copy(deep=True)
    holed.s21[0, 4, 4] = np.nan
    holed.quality[0, 4, 4] = 1
    holed.attrs["missing"] = ["missing: x 220 mm, y 220 mm, 0 deg"]
    window = computed(windows.open(holed, leave_out_missing=True))
    window.move_to(Place(0.24, 0.22, 0.083))
    assert (window.sections.b_scan.colours[:, 4] == LEVELS).all()
    assert window.sections.slice.without_data.count == 1
    assert "missing: x 220 mm" in window.notes.text.text()


def started_workers(before):
    # Libraries start and end threads of their own.
    return [one for one in threading.enumerate() if one.name == WORKER and one not in before]


def test_closing_during_a_computation_ends_the_thread(windows, survey):
    before = set(threading.enumerate())
    for _ in range(5):
        window = windows.open(survey)
        assert started_workers(before)
        windows.close(window)
    assert not started_workers(before)


def found_in(image):
    certain = (0.001, 0.001, 0.004, 20.0, 1e-6)
    one = Candidate("C01", 0.24, 0.24, 0.083, *certain, (0.0, 90.0), None, ())
    permittivity = float(image.attrs["permittivity"])
    return CandidateList(
        "id",
        True,
        "phase-shift",
        permittivity,
        (permittivity, permittivity),
        0.04,
        9.0,
        (5.0, 16.0),
        0,
        (one,),
    )


def test_candidates_are_listed_with_the_sentence_and_marked(windows, survey):
    window = computed(windows.open(survey, find_candidates=found_in))
    assert window.sections.slice.candidates.count == 0
    window.candidates.searched.setChecked(True)
    computed(window)
    assert window.status.problem.text() == ""
    assert "no clearance" in window.candidates.notice.text()
    assert window.candidates.table.item(0, 1).text() == "240 ±1"
    window.controls.permittivity_box.setValue(5.0)
    assert window.candidates.table.rowCount() == 1  # of the image that is still shown
    computed(window)
    assert window.image.candidates.permittivity == 5.0
    window.candidates.table.selectRow(0)
    assert near(window.place, PLACE)
    assert window.sections.slice.candidates.count == 1 == window.sections.section.candidates.count


def test_the_window_speaks_spanish(windows, survey):
    window = computed(windows.open(survey, read_catalogue(Language.SPANISH)))
    assert "SIMULADO" in window.windowTitle()
    assert "despeje" in window.desk.table.notice.text()
    assert "permitividad" in window.status.caption.text()


def when_computed(act):
    """Do something when the window that a command opened has computed its image."""
    timer = QTimer()

    def look():
        for window in QApplication.topLevelWidgets():
            if isinstance(window, MainWindow) and window.isVisible() and not window.is_computing:
                timer.stop()
                act(window)

    timer.timeout.connect(look)
    timer.start(20)
    return timer


@pytest.fixture
def file(survey, tmp_path, installed):
    path = tmp_path / "survey.nc"
    write_dataset(survey, path)
    return path


def test_the_command_shows_the_window_until_it_is_closed(application, file):
    def pick_and_close(window):
        window.pick()
        window.close()

    timer = when_computed(pick_and_close)
    assert main(["view", str(file), "--permittivity", "4", "--flat", "--author", "Ana"]) == DONE
    timer.stop()
    picks = file.with_name("survey.nc.picks.json").read_text(encoding="utf-8")
    assert '"author": "Ana"' in picks


def test_ctrl_c_closes_the_window(application, file, refusals):
    timer = when_computed(lambda _window: os.kill(os.getpid(), signal.SIGINT))
    assert main(["view", str(file), "--permittivity", "4", "--flat"]) == REFUSED
    timer.stop()
    assert refusals[-1:] == [faults.INTERRUPTED.code]


def test_a_damaged_survey_is_refused_unless_accepted(
    application, survey, tmp_path, refusals, installed
):
    damaged = survey.copy(deep=True)
    damaged.s21[0, 4, 4] = np.nan
    damaged.quality[0, 4, 4] = 2
    damaged.attrs["faults"] = ["damaged: x 220 mm, y 220 mm, 0 deg"]
    path = tmp_path / "damaged.nc"
    write_dataset(damaged, path)
    arguments = ["view", str(path), "--permittivity", "4", "--flat"]
    assert main(arguments) == REFUSED
    assert main([*arguments, "--accept-damaged"]) == REFUSED
    assert refusals[-1:] == [faults.SAMPLES_MISSING.code]
    timer = when_computed(lambda window: window.close())
    assert main([*arguments, "--accept-damaged", "--leave-out-missing"]) == DAMAGED
    timer.stop()


def test_a_missing_library_names_the_extra(file, refusals, capsys, monkeypatch):
    monkeypatch.setattr(view_command, "LIBRARIES", {"no_such_library": "pyqtgraph"})
    assert main(["view", str(file)]) == REFUSED
    assert "pip install 'gpr20_viewer[qt]'" in capsys.readouterr().err
    assert refusals[-1:] == [faults.LIBRARY.code]


def test_without_a_screen_it_is_refused(file, refusals, capsys, monkeypatch):
    for name in view_command.SCREENS:
        monkeypatch.delenv(name, raising=False)
    assert main(["view", str(file)]) == REFUSED
    assert refusals[-1:] == [NO_SCREEN.code]
    assert str(NO_SCREEN.remedy) in capsys.readouterr().err
