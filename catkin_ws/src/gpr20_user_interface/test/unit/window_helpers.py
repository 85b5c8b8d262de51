"""A window without ROS, the finger on its screen, and what its tests do with them."""

import time
from types import SimpleNamespace

from fake_clock import FakeClock
from PyQt5 import sip
from PyQt5.QtCore import QPoint, QRect, Qt
from PyQt5.QtGui import QColor
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication
from result_kit import Requests, ServiceTools
from storage_kit import AskedStorage
from view_kit import snapshot

from gpr20_common.catalogue import Language
from gpr20_common.low.clock import Clock
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.plan.fields import TILE_FIELDS
from gpr20_operator.plan.form import preview
from gpr20_operator.robot.remote_control import Arming
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.low.settings_file import PlanMemory, SettingsFile
from gpr20_user_interface.pages.plan_sheets import VALUE_TILES
from gpr20_user_interface.touch.guard import QUIET_S
from gpr20_user_interface.touch.hold import HoldButton
from gpr20_user_interface.widgets.keys import OTHERS, PLAIN, SHIFTED
from gpr20_user_interface.window.main_window import MainWindow, Presenters


class Survey:
    """In place of the presenter of the survey: shows what the test says, remembers the wishes."""

    def __init__(self):
        self.snapshot = snapshot()
        self.preview = self.finer = None
        self.asked, self.annotations = [], []

    def nothing(self, *_values):
        """What these are asked is no wish of the operator."""

    on_event = check_master = nothing

    def state(self):
        return self.snapshot

    def set_plan(self, parameters, permittivity):
        self.plan = (parameters, permittivity)

    def preview_of(self, parameters):
        return self.preview or preview(parameters, 4.0)

    def refines(self, parameters):
        return "" if self.finer is None else self.finer.refined_by(parameters)

    def start(self, parameters, permittivity, annotation):
        self.asked.append(parameters)
        self.annotations.append(annotation)

    def stop(self):
        self.asked.append("stop")

    def pause(self):
        self.asked.append("pause")

    def resume(self, folder="", accept_zeros=False):
        self.asked.append(f"resume {folder}".strip() + " without proof" * accept_zeros)

    def resume_with(self, analyzer):
        self.asked.append(f"resume with {analyzer}")


def opened_window(
    application,
    language=Language.ENGLISH,
    survey=None,
    storage=None,
    folder=None,
    imaging=None,
    clock=None,
    memory=None,
    arming=None,
):
    """Return a window without contact to a robot, which without a folder keeps no plan."""
    problems, tools, clock = [], ServiceTools(), clock or Clock()
    languages = Languages(application, language)
    node = imaging or Requests()
    not_kept = SimpleNamespace(read=dict, write=lambda _values: None)
    window = MainWindow(
        Presenters(
            survey or Survey(),
            TracePresenter(Imaging(storage or AskedStorage(), time.monotonic), problems.append),
            Imaging(node, time.monotonic),
            ServiceModel(tools, tools.examine, clock),
            PlanMemory(
                SettingsFile(folder / "window" / "plan.yaml") if folder else not_kept,
                problems.append,
            ),
            arming or Arming(clock),
        ),
        languages,
        memory,
        clock=clock,
    )
    window.languages, window.clock = languages, clock
    window.tools, window.node = tools, node
    window.show()
    return window


def close(window):
    """Let nothing of a window stay: every window that is left makes the next one slower."""
    window.languages.close()
    window.close()
    sip.delete(window)


def show(window, shown):
    window.survey.snapshot = shown
    window.refresh()


def take_list(window, surveys, more=False, before=""):
    """Let the storage have listed surveys."""
    window.traces.past.take(before, surveys, more)
    window.past.on_event(None)


def wishes(window):
    return window.survey.asked


def open_field(window, name):
    """Touch the tile of a field, and the field; return the field, which shows its text."""
    tile = next(tile for tile in VALUE_TILES if name in TILE_FIELDS[tile])
    click(window.control.tiles[tile])
    window.values.choose(name)
    return window.values.fields[TILE_FIELDS[tile].index(name)]


def press_keys(pad, texts):
    """Touch the keys of texts, one by one."""
    for text in texts:
        if text in (" ", "\n"):
            click(pad.space if text == " " else pad.line)
            continue
        block = pad.letters if pad.digits.isHidden() else pad.digits
        if block is pad.letters:
            block.show_page(next(one for one in (PLAIN, SHIFTED, OTHERS) if text in "".join(one)))
        click(next(key for key in block.keys if key.property("character") == text))


def click(button):
    QTest.mouseClick(button, Qt.LeftButton)


def hold(button, seconds=1.1):
    """Hold a HoldButton for a time that need not pass."""
    clock = FakeClock()
    button.set_clock(clock)
    QTest.mousePress(button, Qt.LeftButton)
    for _ in range(round(seconds / 0.05)):
        clock.advance(0.05)
        button.tick()
    QTest.mouseRelease(button, Qt.LeftButton)


def start(window):
    click(window.control.start)
    hold_to_start(window)


def hold_to_start(window):
    if window.start_sheet.isVisible():
        hold(window.start_sheet.hold)


STEP_S = 0.05
# Touches count again after something has opened or closed.
AFTER_S = QUIET_S + 0.05


class Finger:
    """Touches a window through its screen, so that nothing of the window is left out.

    Time passes only by `wait`.
    """

    def __init__(self, window, clock):
        self._window = window
        self._clock = clock
        self._held = window.findChildren(HoldButton)
        for button in self._held:
            button.set_clock(clock)
        QApplication.processEvents()
        # The window has just opened.
        self.wait(1.0)

    def wait(self, seconds):
        """Let time pass; buttons that are held notice it."""
        while seconds > 0.0:
            self._clock.advance(min(STEP_S, seconds))
            seconds -= STEP_S
            for button in self._held:
                button.tick()

    def press(self, where):
        QTest.mousePress(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def move(self, where):
        QTest.mouseMove(self._screen, self._place(where))

    def release(self, where):
        QTest.mouseRelease(self._screen, Qt.LeftButton, Qt.NoModifier, self._place(where))

    def tap(self, where, seconds=0.03):
        place = self._place(where)
        self.press(place)
        self.wait(seconds)
        self.release(place)

    def hold(self, where, seconds=1.1):
        self.tap(where, seconds)

    @property
    def _screen(self):
        return self._window.windowHandle()

    def _place(self, where):
        return where if isinstance(where, QPoint) else place_of(self._window, where).center()


def place_of(window, widget):
    return QRect(widget.mapTo(window, QPoint()), widget.size())


def pixel_of(plot, across, second):
    place = plot.to_screen(across, second)
    return QPoint(round(place.x()), round(place.y()))


def touch(plot, across, second):
    QTest.mouseClick(plot, Qt.LeftButton, pos=pixel_of(plot, across, second))


def colours(plot, across, second, reach=0):
    image, at = plot.grab().toImage(), pixel_of(plot, across, second)
    around = range(-reach, reach + 1)
    return {QColor(image.pixel(at.x() + dx, at.y() + dy)).name() for dx in around for dy in around}
