"""The viewer's window, on a screen that nobody sees."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
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

from gpr20_analysis import answer, errors
from gpr20_analysis.candidates.table import places_sentence
from gpr20_analysis.commands.command import DAMAGED, DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import NO_SCREEN
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_common.faults import ASKED_FOR
from gpr20_survey.folder.log_record import PLANNED_PERMITTIVITY
from gpr20_viewer import view_command
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.main_window import MainWindow
from gpr20_viewer.views.sections import NOT_MEASURED
from gpr20_viewer.views.tables import PicksTab

PLACES_MM = np.linspace(140.0, 340.0, 11)
PLACE = Place(0.24, 0.24, 0.083)
LIMIT_S = 60.0


@pytest.fixture(scope="module")
def survey():
    survey = survey_of(scene([point(240.0, 240.0, 0.083)]), PLACES_MM, PLACES_MM)
    return survey.assign_attrs(survey_id="0f8fad5b-d9cb-469f-a165-70867728950e")


class Windows:
    def __init__(self, folder):
        self._folder, self._opened = folder, []
        self.answers, self.export = [], None

    def open(self, survey, **options):
        options = ImageOptions(**{"permittivity": 4.0, **options})
        session = ViewSession(survey, options)
        file = PicksFile(self._folder / "survey.picks.json", SurveyIdentity.of(session.survey))
        picks = PicksTab(file, "", lambda: "2026-11-22T12:00:00Z", lambda: self.export)
        window = MainWindow(session, picks, "survey", lambda _: self.answers.pop())
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


def until(holds):
    deadline_s = time.monotonic() + LIMIT_S
    while not holds():
        assert time.monotonic() < deadline_s
        QApplication.processEvents()
        threading.Event().wait(0.002)


def computed(window):
    until(lambda: not window.is_computing)
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
    sections = window.sections
    window.move_to(PLACE)
    delay_ns = window.scene.delay_ns(PLACE)
    for plot, down in zip(sections.plots, (delay_ns, 83.0, 240.0, 240.0)):
        assert [one.value() for one in plot.cursor] == pytest.approx([240.0, down])
    _x, delays_ns = sections.hyperbola.getData()
    assert np.argmin(delays_ns) == 5 and abs(delays_ns.min() - delay_ns) < 1e-6
    assert "x 240 mm, y 240 mm, depth 83 mm" in window.cursor_text.text()
    # The target is the brightest of its slice, and of all.
    for plot in (sections.slice, sections.maximum):
        levels = plot.image.image
        assert levels[5, 5] == levels.max() > levels.min()
    window.settings.next("section")
    for plot, begin, down in (
        (sections.slice, Place(0.2, 0.3, 0.083), 240.0),
        (sections.maximum, Place(0.2, 0.3, 0.083), 240.0),
        (sections.section, Place(0.24, 0.2, 0.15), 83.0),
        (sections.b_scan, Place(0.24, 0.2, 0.15), delay_ns),
    ):
        window.move_to(begin)
        click_at(plot, 240.0, down)
        assert near(window.place, PLACE), plot


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_single_line_fills_the_window_with_its_traces_and_its_section(windows, survey, along):
    window = windows.open(survey.isel({"y" if along == "x" else "x": [5]}))
    sections = window.sections
    window.resize(800, 480)
    QApplication.processEvents()
    assert (window.width(), window.height()) == (800, 480)
    assert not sections.slice.isVisible() and not sections.maximum.isVisible()
    for plot in (sections.b_scan, sections.section):
        assert plot.isVisible() and plot.width() > 320 and plot.height() > 144
        assert plot.image.image.shape[1] == 11
    click_at(sections.section, 240.0, 83.0)
    assert near(window.place, PLACE)
    assert f"along {along}" in sections.section.getPlotItem().titleLabel.text
    QTest.keyClick(window, Qt.Key_P)
    assert [one.count for one in sections.pick_marks] == [1, 1, 1]


def test_settings_change_what_is_shown_and_the_latest_value_wins(windows, survey):
    window = windows.open(survey, permittivity=None)
    settings, plots = window.settings, window.sections.plots
    assert settings.permittivity == window.image.permittivity == 5.0
    (shown,) = settings.tree.child("permittivity").items
    assert float(shown.widget.text()) == 5.0
    window.sections.scale.setLevels(low=-20.0)
    assert {tuple(plot.image.levels) for plot in plots} == {(-20.0, 0.0)}
    settings.switch_background()
    for steps in range(150, 260, 2):
        settings.slider.setValue(steps)
    # The caption is that of the image that is still shown.
    assert window.is_computing and "computing" in window.caption.text()
    assert "ASSUMED" in window.caption.text()
    computed(window)
    assert window.image.permittivity == settings.permittivity > 10.0
    assert window.image.source == "slider" and not window.image.request.background
    before = settings.permittivity
    assert float(shown.widget.text()) == before
    QTest.keyClick(window, Qt.Key_Plus)
    assert settings.permittivity == pytest.approx(before + 0.1)


def test_an_image_that_cannot_be_made_says_why_and_the_last_one_keeps_its_caption(windows, survey):
    window = windows.open(survey, depth_m=(0.0, 0.5, 1.0))
    window.settings.tree["permittivity"] = 30.0
    computed(window)
    assert "echoes of the deepest layer have a delay of" in window.problem.text()
    assert "permittivity 4 (3.6 to 4.4)," in window.caption.text()
    QTest.keyClick(window, Qt.Key_P)
    assert window.picks.editor.picks == ()
    window.settings.tree["permittivity"] = 5.0
    computed(window)
    assert window.problem.text() == "" and window.image.permittivity == 5.0


def test_picks_are_stored_at_once_shown_again_and_move_with_the_permittivity(
    windows, survey, tmp_path
):
    window = windows.open(survey)
    window.move_to(PLACE)
    QTest.keyClick(window, Qt.Key_P)
    table = window.picks.table
    window.activateWindow()
    table.editItem(table.item(0, 5))
    QApplication.processEvents()
    # Letters of a note are no commands.
    line = table.findChild(QLineEdit)
    QTest.keyClicks(line, "pcbl")
    QTest.keyClick(line, Qt.Key_Return)
    QApplication.processEvents()
    assert window.settings.background and len(window.picks.editor.picks) == 1
    texts = [table.item(0, column).text() for column in range(6)]
    assert texts == ["P1", "240", "240", "83", "0°", "pcbl"]
    windows.close(window)
    again = windows.open(survey)
    assert [one.note for one in again.picks.editor.picks] == ["pcbl"]
    assert [one.count for one in again.sections.pick_marks] == [1, 1, 1]
    windows.export = tmp_path / "picks.csv"
    again.picks.export()
    assert "pcbl" in windows.export.read_text()
    again.settings.tree["permittivity"] = 16.0
    computed(again)
    _traces, section, _slice = again.scene.pick_marks(again.picks.editor.picks)
    assert section[0].down == pytest.approx(41.5)
    assert again.picks.editor.picks[0].depth_m == 0.083
    again.settings.next("polarization")
    assert again.scene.polarization_deg == 90.0
    assert [one.count for one in again.sections.pick_marks] == [0, 0, 0]


def test_picks_that_cannot_be_stored_say_so_and_are_not_lost_silently(windows, survey, tmp_path):
    window = windows.open(survey)
    window.pick()
    (tmp_path / "survey.picks.json").write_text("{}")
    window.move_to(PLACE)
    window.pick()
    assert "NOT SAVED" in window.picks.state.text() and window.picks.is_unsaved
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
    # Beside the cursor's line.
    window.move_to(Place(0.34, 0.22, 0.083))
    QApplication.processEvents()
    b_scan = window.sections.b_scan
    at = b_scan.mapFromScene(b_scan.getViewBox().mapViewToScene(QPointF(220.0, 1.0)))
    pixels = b_scan.grab().toImage()
    assert pixels.pixelColor(at).getRgb()[:3] == NOT_MEASURED
    assert pixels.pixelColor(at.x() + 40, at.y()).getRgb()[:3] != NOT_MEASURED
    assert window.sections.without_data.count == 1
    assert "damaged: x 220 mm" in window.notes.toPlainText()
    assert "the clock was set" in window.problem.text()


def test_the_list_is_that_of_the_survey_with_its_weaker_echoes_for_who_asks(windows, survey):
    known = survey.assign_attrs(survey_json=json.dumps({PLANNED_PERMITTIVITY: 4.0}))
    window = windows.open(known, permittivity=None)
    found, tab = answer(known).found, window.candidates
    assert window.image.candidates == found and found.permittivity == 4.0 and found.weaker
    assert "no clearance" in tab.notice.text() and str(places_sentence(found)) in tab.notes.text()
    assert tab.table.rowCount() == found.primary and tab.table.item(0, 1).text()[:4] == "240 "
    assert tab.weaker.text() == f"{found.weaker} weaker echoes"
    tab.weaker.click()
    assert tab.table.rowCount() == len(found.candidates)
    assert "SIMULATED" in window.windowTitle() and window.banner.isVisible()
    assert "no clearance" in window.picks.notice.text()
    tab.table.selectRow(0)
    assert near(window.place, PLACE)
    assert window.sections.candidate_marks[1].count == found.primary
    window.settings.tree["permittivity"] = 5.0
    computed(window)
    assert window.image.candidates == answer(known, ImageOptions(permittivity=5.0)).found


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


def test_the_command_explains_itself_without_the_libraries_of_the_window(installed, tmp_path):
    program = (
        f"import sys; sys.path[:0] = {[str(tmp_path / 'site'), *sys.path]}\n"
        "from gpr20_analysis.commands.main import main\n"
        "assert main(['--help']) == main(['view', '--help']) == 0\n"
        "assert not {'PyQt5', 'pyqtgraph'} & set(sys.modules)\n"
    )
    printed = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert "look at a survey in a window" in printed and "--picks FILE" in printed


def test_the_command_shows_the_window_until_it_is_closed_or_interrupted(
    application, file, refusals
):
    arguments = ["view", str(file), "--permittivity", "4"]
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
    arguments = ["view", str(file), "--permittivity", "4"]
    with monkeypatch.context() as context:
        context.setattr(view_command, "LIBRARIES", {"no_such_library": "pyqtgraph"})
        assert main(arguments) == REFUSED
    assert "pip install 'gpr20_viewer[qt]'" in capsys.readouterr().err
    # None is named, and one that nobody serves.
    for display, wayland in (("", ""), (":77", ""), ("", "none-77")):
        with monkeypatch.context() as context:
            context.delenv("QT_QPA_PLATFORM")
            context.setenv("DISPLAY", display)
            context.setenv("WAYLAND_DISPLAY", wayland)
            assert main(arguments) == REFUSED
    assert refusals[-4:] == [errors.STEPS.code, *[NO_SCREEN.code] * 3]
    write_dataset(holed, file)
    assert main(arguments) == REFUSED
    assert main([*arguments, "--accept-damaged"]) == REFUSED
    assert refusals[-1:] == [errors.INPUT.code]
    when_computed(lambda window: window.close())
    assert main([*arguments, "--accept-damaged", "--leave-out-missing"]) == DAMAGED
