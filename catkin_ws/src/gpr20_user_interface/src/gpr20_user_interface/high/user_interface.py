"""The window: a client of the main control that may start and end during a survey."""

from __future__ import annotations

import argparse
import faulthandler
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, NoReturn, Optional, Tuple

import rosgraph
import rospy
from PyQt5.QtCore import (
    QMessageLogContext,
    QObject,
    Qt,
    QTimer,
    QtMsgType,
    pyqtSignal,
    qInstallMessageHandler,
)
from PyQt5.QtWidgets import QApplication

from gpr20_common.catalogue import Language, language_from_code, read_catalogue
from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.high.graph_keeper import GraphKeeper
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import say
from gpr20_operator.errors import DisplayUnavailableError, MasterUnavailableError
from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.high.control_client import ControlClient, WebPageClient
from gpr20_operator.high.ros_events import join_graph
from gpr20_operator.high.storage_client import StorageClient
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.plan.form import CostEstimated
from gpr20_operator.robot.events import Configured, Senders
from gpr20_operator.robot.remote_control import Arming
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_operator.robot.snapshot import SurveyModel
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.plan.survey_points import survey_cost
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.low.process import StopSignals, check_display, leave_now, wait_for_display
from gpr20_user_interface.low.settings_file import Newest, PlanMemory, SettingsFile
from gpr20_user_interface.pages.settings import WindowMemory
from gpr20_user_interface.presenter import WindowPresenter
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.window.main_window import MainWindow, Presenters

MASTER_WAIT_S = 30.0
DEFAULT_SETTINGS = "~/.config/gpr20/window.yaml"
# Of the parameter ~language: the language that was used last.
REMEMBERED = "auto"
# A disk may be slow; the window does not wait for it longer.
SETTINGS_LIMIT_S = 5.0
# To leave the graph without a display.
LEAVE_LIMIT_S = 3.0
# Between two signs of life of a window that is started again when it hangs.
BEAT_MS = 1000
# Far longer than anything that the window does between two events [s].
HANG_LIMIT_S = 30.0
EXIT_NO_MASTER = 1
EXIT_WRONG_PARAMETER = 2
EXIT_NO_DISPLAY = 3
EXIT_DISPLAY_LOST = 4
EXIT_BY_SIGNAL = 130
# What Qt says before it calls exit(): of X11, and of Wayland.
LOST = "connection broke"


class EventSignal(QObject):
    """Carries events from ROS's threads into that of the window."""

    event_came = pyqtSignal(object)
    # ROS asks this node to end.
    shut_down = pyqtSignal()

    # Methods, not the signals' own emit: a signal does not hold a reference to its object, and
    # threads of ROS may outlive every other reference.
    def emit_event(self, event: object) -> None:
        """Emit an event."""
        self.event_came.emit(event)

    def emit_shut_down(self) -> None:
        """Emit that ROS asks this node to end."""
        self.shut_down.emit()


class UserInterface:
    """The window and its clients of the graph, connected."""

    def __init__(
        self,
        replay: bool,
        languages: Languages,
        plan_settings: SettingsFile,
        memory: Optional[WindowMemory] = None,
        full_screen: bool = False,
    ) -> None:
        self.signal = EventSignal()
        model, senders = SurveyModel(Clock(), replay), Senders(rospy.get_namespace(), replay)
        self.control = ControlClient(self.signal.emit_event, senders)
        self.storage = StorageClient(self.signal.emit_event, senders)
        self.plans = PlanMemory(plan_settings, self.signal.emit_event)
        self.web = WebPageClient(self.signal.emit_event, senders.namespace)
        self._clients = (self.control, self.storage, self.web)
        imaging = Imaging(self.storage, time.monotonic)
        estimates = Newest(self._estimate)
        self.window = MainWindow(
            Presenters(
                WindowPresenter(model, self.control, lambda *asked: estimates.put(asked)),
                TracePresenter(imaging, lambda reason: rospy.logwarn("not shown: %s", reason)),
                imaging,
                ServiceModel(self.storage, self.storage.examine, Clock()),
                self.plans,
                Arming(Clock(), self.web.send),
            ),
            languages,
            memory,
        )
        if replay:
            # What they are about is not there.
            for name in (TabName.SURVEYS, TabName.ROBOT):
                self.window.rail.tabs[name].hide()
        else:
            self.window.top_bar.show_robot(senders.namespace.strip("/"))
        self._full_screen = full_screen
        _connect_queued(self.signal.event_came, self.window.on_event)

    def _estimate(self, asked: Tuple[Configured, SurveyParameters]) -> None:
        """Say what a survey costs; of a large one that takes seconds."""
        robot, parameters = asked
        cost = survey_cost(parameters, robot.config, robot.settings)
        self.signal.emit_event(CostEstimated(parameters, cost))

    def begin(self) -> None:
        """Show the window and listen to the graph."""
        rospy.on_shutdown(self.signal.emit_shut_down)
        for client in self._clients:
            client.listen()
        self.control.set_watched(True)
        self.storage.set_watched(True)
        self.window.begin()
        # Notices a display that was lost meanwhile, without which Qt would crash.
        QApplication.processEvents()
        self.window.show_on_screen(self._full_screen)

    def end(self) -> None:
        """Leave the graph; a survey that runs continues."""
        self.window.end()
        self.plans.wait(SETTINGS_LIMIT_S)
        for client in reversed(self._clients):
            client.close()

    def health(self) -> Health:
        """Return the health of this node."""
        # The snapshot is immutable: safe to read from ROS's threads.
        snapshot = self.window.survey.snapshot
        if snapshot.replay:
            return OK, Message("a replay is shown"), {}
        if snapshot.control_alive:
            return OK, Message("in contact with the main control"), {}
        values = {"silent_s": snapshot.control_silent_s}
        return WARN, Message("no contact with the main control"), values


def main() -> NoReturn:
    """Show the window until it is closed, ROS asks it to end or a signal comes."""
    parser = argparse.ArgumentParser("user_interface", description="The window of the operator.")
    parser.add_argument(
        "--wait-for-display", action="store_true", help="wait until there is a screen"
    )
    parser.add_argument("--replay", action="store_true", help="show a replay, and no robot")
    status = _run(parser.parse_known_args(rospy.myargv()[1:])[0])
    # Without the exit handlers and destructors of libraries: their threads still run.
    leave_now(status)


def _run(options: argparse.Namespace) -> int:
    """Show the window; return the exit status."""
    # It costs memory and time, and crashes when the display closes while the window is made.
    os.environ.setdefault("QT_XCB_GL_INTEGRATION", "none")
    try:
        if options.wait_for_display:
            wait_for_display(_say)
        else:
            check_display()
    except DisplayUnavailableError as error:
        _say(str(error))
        return EXIT_NO_DISPLAY
    if options.replay and _robot_is_here():
        _say(
            f"a robot has the namespace {rospy.get_namespace()}: its window, and STOP with it, "
            "would end; show the replay in another namespace, as in ns:=replay"
        )
        return EXIT_WRONG_PARAMETER
    with StopSignals(_quit_soon, lambda: leave_now(EXIT_BY_SIGNAL)) as signals:
        try:
            join_graph("user_interface", MASTER_WAIT_S, lambda: signals.received, Clock())
        except MasterUnavailableError as error:
            _say(str(error))
            # At once: the exit handlers of rospy would wait for the master.
            return EXIT_NO_MASTER
        _on_display_lost(lambda: _leave_without_display(signals.received))
        application = QApplication(rospy.myargv())
        try:
            return _show(application, signals, options)
        except Gpr20Error as error:
            rospy.logfatal("user_interface cannot start: %s", error)
            return EXIT_WRONG_PARAMETER


def _say(sentence: str) -> None:
    say(f"user_interface: {sentence}", file=sys.stderr, flush=True)


def _quit_soon() -> None:
    application = QApplication.instance()
    if application is not None:
        # A quit() before the event loop runs would be lost; this waits for the loop.
        QTimer.singleShot(0, application.quit)


def _on_display_lost(leave: Callable[[], None]) -> None:
    """Call a function, which ends the process, when the connection to the display breaks.

    Qt aborts, or calls exit() and so the destructors of what other threads still use.
    """

    def handle(kind: QtMsgType, _context: QMessageLogContext, text: Optional[str]) -> None:
        say(text or "", file=sys.stderr, flush=True)
        if kind == QtMsgType.QtFatalMsg or LOST in (text or ""):
            leave()

    qInstallMessageHandler(handle)


def _leave_without_display(asked_to_end: bool) -> NoReturn:
    if not asked_to_end:
        _say("the display was closed, and the window with it; a survey that runs continues")
    status = 0 if asked_to_end else EXIT_DISPLAY_LOST
    # The master may not answer.
    limit = threading.Timer(LEAVE_LIMIT_S, leave_now, (status,))
    limit.daemon = True
    limit.start()
    rospy.signal_shutdown("the display was closed")
    leave_now(status)


def _robot_is_here() -> bool:
    """Return whether a main control is registered in the namespace of this node."""
    try:
        rosgraph.Master("/user_interface").lookupNode(f"{rospy.get_namespace()}main_control")
    except (rosgraph.MasterException, OSError):
        return False
    return True


def _show(application: QApplication, signals: StopSignals, options: argparse.Namespace) -> int:
    settings = Path(rospy.get_param("~settings", DEFAULT_SETTINGS)).expanduser()
    memory = WindowMemory(SettingsFile(settings), _log)
    languages = Languages(application, _language(memory.settings.language))
    interface = UserInterface(
        options.replay,
        languages,
        SettingsFile(settings.with_name(_plan_file(rospy.get_namespace()))),
        memory,
        _covers_screen(),
    )
    _connect_queued(interface.signal.shut_down, application.quit)
    # First: objects made while ROS ends this node would not notice it.
    diagnostics = Diagnostics("user_interface", interface.health)
    interface.begin()
    keeper = GraphKeeper()
    # What came before the event loop may have been handled without effect.
    if signals.received or rospy.is_shutdown():
        _quit_soon()
    beats = QTimer(interface.window)
    # Measured outside Python: it also ends a process whose interpreter hangs.
    beats.timeout.connect(lambda: faulthandler.dump_traceback_later(HANG_LIMIT_S, exit=True))
    if options.wait_for_display:  # only the window of a robot is started again
        beats.start(BEAT_MS)
    status = application.exec_()
    faulthandler.cancel_dump_traceback_later()
    keeper.close()
    interface.end()
    memory.close(SETTINGS_LIMIT_S)
    # While the objects that it calls still exist.
    rospy.signal_shutdown("the window was closed")
    del diagnostics
    return status


def _plan_file(namespace: str) -> str:
    """Return the name of the file, beside the settings, that keeps the plan for a robot."""
    robot = namespace.strip("/").replace("/", ".")
    return f"plan_{robot}.yaml" if robot else "plan.yaml"


def _covers_screen() -> bool:
    return record_from(bool, rospy.get_param("~full_screen", False), "full_screen")


def _language(remembered: Language) -> Language:
    code = rospy.get_param("~language", REMEMBERED)
    if code != REMEMBERED:
        return language_from_code(code)
    try:
        read_catalogue(remembered)
    except InvalidValueError as error:
        # It was damaged since: a window in English is better than none.
        _log(error.message)
        return Language.ENGLISH
    return remembered


def _log(reason: Message) -> None:
    rospy.logwarn("%s", reason)


def _connect_queued(signal: Any, slot: Callable[..., None]) -> None:
    # PyQt's type stubs lack the second argument of connect().
    signal.connect(slot, Qt.ConnectionType.QueuedConnection)
