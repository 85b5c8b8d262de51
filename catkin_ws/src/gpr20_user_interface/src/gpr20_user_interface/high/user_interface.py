"""The window: a client of the main control that may start and end during a survey."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any, Callable

import rospy
from PyQt5.QtCore import QObject, Qt, QTimer, pyqtSignal
from PyQt5.QtWidgets import QApplication

from gpr20_common.catalogue import Language, language_from_code
from gpr20_common.errors import Gpr20Error
from gpr20_common.high.connection_keeper import ConnectionKeeper
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_user_interface.errors import MasterUnavailableError
from gpr20_user_interface.high.control_client import ControlClient, main_control_name
from gpr20_user_interface.high.master import join_graph
from gpr20_user_interface.high.service_client import ServiceToolsClient
from gpr20_user_interface.high.storage_client import StorageClient
from gpr20_user_interface.low.analysis_program import AnalysisProgram
from gpr20_user_interface.low.profile_folder import ProfileFolder
from gpr20_user_interface.low.stop_signals import StopSignals, leave_now
from gpr20_user_interface.mid.candidate_search import CandidateSearch
from gpr20_user_interface.mid.message_source import MessageSources
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.service_model import ServiceModel
from gpr20_user_interface.mid.shown_model import ShownModel
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.mid.survey_preview import CostEstimator
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.main_window import MainWindow
from gpr20_user_interface.views.translation import Languages

MASTER_WAIT_S = 30.0
DEFAULT_PROFILES = "~/.config/gpr20/profiles"
EXIT_NO_MASTER = 1
EXIT_WRONG_PARAMETER = 2
EXIT_BY_SIGNAL = 130


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

    def __init__(self, model: SurveyModel, languages: Languages, profiles: Profiles) -> None:
        self.signal = EventSignal()
        self.control = ControlClient(self.signal.emit_event)
        self.storage = StorageClient(self.signal.emit_event)
        self.service = ServiceToolsClient(self.signal.emit_event)
        shown = ShownModel(Clock(), MessageSources(main_control_name()), model)
        self.window = MainWindow(
            WindowPresenter(shown, self.control, CostEstimator(self.signal.emit_event)),
            TracePresenter(self.storage, lambda reason: rospy.logwarn("not shown: %s", reason)),
            profiles,
            languages,
            CandidateSearch(AnalysisProgram(self.signal.emit_event), time.monotonic),
            ServiceModel(self.service, Clock()),
        )
        _connect_queued(self.signal.event_came, self.window.on_event)

    def begin(self) -> None:
        """Show the window and listen to the graph."""
        rospy.on_shutdown(self.signal.emit_shut_down)
        self.control.listen()
        self.control.listen_to_robot()
        self.storage.listen()
        self.service.listen()
        self.window.begin()
        self.window.show()

    def end(self) -> None:
        """Leave the graph; a survey that runs continues."""
        self.window.end()
        self.storage.close()
        self.service.close()
        self.control.close()

    def health(self) -> Health:
        """Return the health of this node."""
        # The snapshot is immutable: safe to read from ROS's threads.
        snapshot = self.window.survey.snapshot
        if snapshot.replay is not None:
            return OK, Message("a replay is shown"), {}
        if snapshot.control_alive:
            return OK, Message("in contact with the main control"), {}
        values = {"silent_s": snapshot.control_silent_s}
        return WARN, Message("no contact with the main control"), values


def main() -> int:
    """Show the window until it is closed, ROS asks it to end or a signal comes."""
    application = QApplication(rospy.myargv())

    def quit_soon(_name: str) -> None:
        # A quit() before the event loop runs would be lost; this waits for the loop.
        QTimer.singleShot(0, application.quit)

    with StopSignals(quit_soon, on_next=lambda: leave_now(EXIT_BY_SIGNAL)) as signals:
        try:
            join_graph("user_interface", MASTER_WAIT_S, lambda: signals.received, Clock())
        except MasterUnavailableError as error:
            print(f"user_interface: {error}", file=sys.stderr)
            # At once: the exit handlers of rospy would wait for the master.
            leave_now(EXIT_NO_MASTER)
        try:
            return _show(application)
        except Gpr20Error as error:
            rospy.logfatal("user_interface cannot start: %s", error)
            return EXIT_WRONG_PARAMETER


def _show(application: QApplication) -> int:
    code = rospy.get_param("~language", Language.ENGLISH.value)
    languages = Languages(application, language_from_code(code))
    folder = Path(rospy.get_param("~profiles", DEFAULT_PROFILES)).expanduser()
    interface = UserInterface(SurveyModel(Clock()), languages, Profiles(ProfileFolder(folder)))
    _connect_queued(interface.signal.shut_down, application.quit)
    # First: objects made while ROS ends this node would not notice it.
    diagnostics = Diagnostics("user_interface", interface.health)
    interface.begin()
    keeper = ConnectionKeeper()
    status = application.exec_()
    keeper.close()
    interface.end()
    # While the objects that it calls still exist.
    rospy.signal_shutdown("the window was closed")
    del diagnostics
    return status


def _connect_queued(signal: Any, slot: Callable[..., None]) -> None:
    # PyQt's type stubs lack the second argument of connect().
    signal.connect(slot, Qt.ConnectionType.QueuedConnection)
