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
from PyQt5.QtCore import QPointF, Qt, QTimer
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QLineEdit

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DAMAGED, DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.faults import NO_SCREEN
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_common.faults import ASKED_FOR
from gpr20_survey.results.candidates import Candidate, CandidateList
from gpr20_viewer import view_command
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


@pytest.fixture(scope="module")
def survey():
    survey = survey_of(scene([TARGET]), PLACES_MM, PLACES_MM)
    return survey.assign_attrs(survey_id="0f8fad5b-d9cb-469f-a165-70867728950e")


class Windows:
    def __init__(self, folder):
        self._folder, self._opened = folder, []
        self.answers, self.export = [], None

    def open(self, survey, find_candidates=None, **options):
        session = ViewSession(
            survey, ImageOptions(**{"permittivity": 4.0, **options}), find_candidates
        )
        file = PicksFile(self._folder / "survey.picks.json", SurveyIdentity.of(session.survey))
        desk = PickDesk(file, "", lambda: "2026-11-22T12:00:00Z", lambda: self.export)
        window = MainWindow(session, desk, "survey", True, lambda _: self.answers.pop())
        window.show()
        self._opened.append(window)
        return computed(window)

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


def computed(window):
    deadline_s = time.monotonic() + LIMIT_S
    while window.is_computing:
        assert time.monotonic() < deadline_s, "the image is computed"
        QApplication.processEvents()
        threading.Event().wait(0.002)
    return window


def click_at(plot, across, down):
    QApplication.processEvents()
    at = plot.mapFromScene(plot.getViewBox().mapViewToScene(QPointF(across, down)))
    QTest.mouseClick(plot.viewport(), Qt.LeftButton, Qt.NoModifier, at)


def near(one, other):
    apart = (one.x_m - other.x_m, one.y_m - other.y_m, one.depth_m - other.depth_m)
    return max(map(abs, apart)) < 0.004


def test_every_view_shows_the_same_place_and_a_click_in_any_moves_all(windows, survey):
    window = windows.open(survey)
    sections, plots = window.sections, window.volume.plots
    # Without OpenGL there are projections.
    assert isinstance(window.volume, ProjectionsView)
    window.move_to(PLACE)
    delay_ns = window.scene.delay_ns(PLACE)
    for plot, place in (
        *((sections.slice, (240.0, 240.0)), (sections.section, (240.0, 83.0))),
        *((sections.b_scan, (240.0, delay_ns)), (plots["depth"], (240.0, 240.0))),
        (plots["x"], (240.0, 83.0)),
    ):
        assert plot.cursor_place == pytest.approx(place)
    _x, delays_ns = sections.b_scan.hyperbola.getData()
    assert np.argmin(delays_ns) == 5 and abs(delays_ns.min() - delay_ns) < 1e-6
    assert "x 240 mm, y 240 mm, depth 83 mm" in window.cursor_text.text()
    # The target is the brightest of its slice.
    shown = sections.slice.colours
    assert shown[5, 5] == shown.max() > shown.min()
    window.controls.direction.setCurrentIndex(1)
    for plot, begin, down in (
        (sections.slice, Place(0.2, 0.3, 0.083), 240.0),
        (sections.section, Place(0.24, 0.2, 0.15), 83.0),
        (sections.b_scan, Place(0.24, 0.2, 0.15), delay_ns),
    ):
        window.move_to(begin)
        click_at(plot, 240.0, down)
        assert near(window.place, PLACE), plot


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_single_line_fills_the_window_with_its_traces_and_its_section(windows, survey, along):
    window = windows.open(survey.isel({"y" if along == "x" else "x": [5]}))
    sections, controls = window.sections, window.controls
    window.resize(800, 480)
    QApplication.processEvents()
    assert (window.width(), window.height()) == (800, 480)
    assert not sections.slice.isVisible() and not window.volume.isVisible()
    for plot in (sections.b_scan, sections.section):
        assert plot.isVisible() and plot.width() > 320 and plot.height() > 144
        assert plot.colours.shape[1] == 11 and len(np.unique(plot.colours)) > 20
    assert not controls.direction.isEnabled()
    click_at(sections.section, 240.0, 83.0)
    assert near(window.place, PLACE)
    assert f"along {along}" in sections.section.getPlotItem().titleLabel.text
    QTest.keyClick(window, Qt.Key_P)
    assert sections.b_scan.picks.count == 1 == sections.section.picks.count


def test_settings_change_what_is_shown_and_the_latest_value_wins(windows, survey):
    window = windows.open(survey, permittivity=None)
    controls, section = window.controls, window.sections.section
    assert controls.permittivity == window.image.permittivity == 5.0
    before = section.colours.copy()
    controls.range.setValue(20.0)
    assert (section.colours == 0).sum() > (before == 0).sum()
    traces = window.sections.b_scan.colours.copy()
    controls.gain.setValue(6.0)
    controls.deepest.setValue(150.0)
    controls.background.setChecked(False)
    for steps in range(150, 260, 2):
        controls.slider.setValue(steps)
    # The caption is that of the image that is still shown.
    assert window.is_computing and "computing" in window.status.caption.text()
    assert "ASSUMED" in window.status.caption.text()
    computed(window)
    assert window.image.permittivity == controls.permittivity > 10.0
    assert window.image.source == "slider"
    assert window.image.depth_m[-1] == pytest.approx(0.15, abs=0.003)
    assert "display gain 6 dB/ns" in window.status.caption.text()
    assert not np.array_equal(traces, window.sections.b_scan.colours)


def test_an_image_that_cannot_be_made_says_why_and_the_last_one_keeps_its_caption(windows, survey):
    window = windows.open(survey)
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


def test_picks_are_stored_at_once_shown_again_and_move_with_the_permittivity(
    windows, survey, tmp_path
):
    window = windows.open(survey)
    window.move_to(PLACE)
    QTest.keyClick(window, Qt.Key_P)
    table = window.desk.table.table
    window.activateWindow()
    table.editItem(table.item(0, 5))
    QApplication.processEvents()
    # Letters of a note are no commands.
    line = table.findChild(QLineEdit)
    QTest.keyClicks(line, "pcbl")
    QTest.keyClick(line, Qt.Key_Return)
    QApplication.processEvents()
    assert not window.click_picks.isChecked() and window.controls.background.isChecked()
    texts = [table.item(0, column).text() for column in range(6)]
    assert texts == ["P1", "240", "240", "83", "0°", "pcbl"]
    assert "no clearance" in window.desk.table.notice.text()
    windows.close(window)
    again = windows.open(survey)
    assert [one.note for one in again.desk.editor.picks] == ["pcbl"]
    assert again.sections.slice.picks.count == 1 == again.sections.b_scan.picks.count
    windows.export = tmp_path / "picks.csv"
    again.desk.export()
    assert "pcbl" in windows.export.read_text()
    again.controls.permittivity_box.setValue(16.0)
    computed(again)
    _traces, section, _slice = again.scene.pick_marks(again.desk.editor.picks)
    assert section[0].down == pytest.approx(41.5)
    assert again.desk.editor.picks[0].depth_m == 0.083
    again.controls.polarization.setCurrentIndex(1)
    assert again.scene.polarization_deg == 90.0 and again.sections.slice.picks.count == 0


def test_picks_that_cannot_be_stored_say_so_and_are_not_lost_silently(windows, survey, tmp_path):
    window = windows.open(survey)
    window.pick()
    (tmp_path / "survey.picks.json").write_text("{}")
    window.move_to(PLACE)
    window.pick()
    assert "NOT SAVED" in window.desk.table.state.text() and window.desk.is_unsaved
    windows.answers = [False]
    window.close()
    assert window.isVisible() and windows.answers == []


@pytest.fixture
def holed(survey):
    holed = survey.copy(deep=True)
    holed.s21[0, 4, 4] = np.nan
    holed.quality[0, 4, 4] = int(Quality.DAMAGED)
    holed.attrs["faults"] = ["damaged: x 220 mm, y 220 mm, 0 deg"]
    holed.attrs["doubts"] = ["the clock was set"]
    return holed


def test_what_was_not_measured_is_grey_and_marked(windows, holed):
    window = windows.open(holed, leave_out_missing=True)
    window.move_to(Place(0.24, 0.22, 0.083))
    assert (window.sections.b_scan.colours[:, 4] == LEVELS).all()
    assert window.sections.slice.without_data.count == 1
    assert "damaged: x 220 mm" in window.notes.text.text()
    assert "the clock was set" in window.status.problem.text()


def found_in(image):
    certain = (0.001, 0.001, 0.004, 20.0)
    one = Candidate("C01", 0.24, 0.24, 0.083, *certain, (0.0, 90.0), None, ())
    permittivity = float(image.attrs["permittivity"])
    values = (*[permittivity] * 3, "", 0.04, 10.0, 12.0, 0, None)
    return CandidateList("id", True, "phase-shift", *values, (one,))


def test_candidates_are_listed_with_the_sentence_and_marked(windows, survey):
    window = windows.open(survey, find_candidates=found_in)
    marked = window.sections.slice.candidates, window.sections.section.candidates
    assert [one.count for one in marked] == [0, 0]
    window.candidates.searched.setChecked(True)
    computed(window)
    assert "no clearance" in window.candidates.notice.text()
    assert window.candidates.table.item(0, 1).text() == "240 ±1"
    window.controls.permittivity_box.setValue(5.0)
    computed(window)
    assert window.image.candidates.permittivity == 5.0
    window.candidates.table.selectRow(0)
    assert near(window.place, PLACE)
    assert [one.count for one in marked] == [1, 1]


def test_the_window_says_that_a_survey_is_simulated_and_picks_are_no_clearance(windows, survey):
    window = windows.open(survey)
    assert "SIMULATED" in window.windowTitle() and window.status.banner.isVisible()
    assert "no clearance" in window.desk.table.notice.text()
    measured = windows.open(survey.assign_attrs(simulated=0))
    assert not measured.status.banner.isVisible() and "SIMULATED" not in measured.windowTitle()


def when_computed(act):
    """Do something when the window that a command opened has computed its image."""
    timer = QTimer(QApplication.instance())

    def look():
        for window in QApplication.topLevelWidgets():
            if isinstance(window, MainWindow) and window.isVisible() and not window.is_computing:
                timer.deleteLater()
                act(window)

    timer.timeout.connect(look)
    timer.start(20)


@pytest.fixture
def file(survey, tmp_path, installed):
    path = tmp_path / "survey.nc"
    write_dataset(survey, path)
    return path


def test_the_command_shows_the_window_until_it_is_closed_or_interrupted(
    application, file, refusals
):
    arguments = ["view", str(file), "--permittivity", "4", "--flat"]
    when_computed(lambda window: (window.pick(), window.close()))
    assert main([*arguments, "--author", "Ana"]) == DONE
    picks = file.with_name("survey.nc.picks.json").read_text(encoding="utf-8")
    assert '"author": "Ana"' in picks
    when_computed(lambda _window: os.kill(os.getpid(), signal.SIGINT))
    assert main(arguments) == REFUSED
    assert refusals[-1:] == [ASKED_FOR.code]


def test_a_damaged_survey_a_missing_library_or_no_screen_is_refused(
    application, file, holed, refusals, capsys, monkeypatch
):
    arguments = ["view", str(file), "--permittivity", "4", "--flat"]
    with monkeypatch.context() as context:
        context.setattr(view_command, "LIBRARIES", {"no_such_library": "pyqtgraph"})
        assert main(arguments) == REFUSED
    assert "pip install 'gpr20_viewer[qt]'" in capsys.readouterr().err
    with monkeypatch.context() as context:
        for name in view_command.SCREENS:
            context.delenv(name, raising=False)
        assert main(arguments) == REFUSED
    assert refusals[-2:] == [faults.STEPS.code, NO_SCREEN.code]
    write_dataset(holed, file)
    assert main(arguments) == REFUSED
    assert main([*arguments, "--accept-damaged"]) == REFUSED
    assert refusals[-1:] == [faults.INPUT.code]
    when_computed(lambda window: window.close())
    assert main([*arguments, "--accept-damaged", "--leave-out-missing"]) == DAMAGED
