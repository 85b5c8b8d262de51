"""The window: a client of main_control that may come and go without touching the survey."""

from __future__ import annotations

import sys
from pathlib import Path

import rospy
from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import QApplication

from gpr20_common.errors import Gpr20Error
from gpr20_common.high.diagnostics import OK, WARN, Diagnostics, Health
from gpr20_common.low.clock import Clock
from gpr20_user_interface.errors import MasterUnavailableError
from gpr20_user_interface.high.master import join_graph
from gpr20_user_interface.high.ros_link import RosLink
from gpr20_user_interface.high.storage_client import StorageClient
from gpr20_user_interface.low.profile_folder import ProfileFolder
from gpr20_user_interface.low.stop_signals import StopSignals, leave_now
from gpr20_user_interface.mid.profiles import Profiles
from gpr20_user_interface.mid.profiles_presenter import ProfilesPresenter
from gpr20_user_interface.mid.survey_model import SurveyModel
from gpr20_user_interface.mid.trace_presenter import TracePresenter
from gpr20_user_interface.mid.window_presenter import WindowPresenter
from gpr20_user_interface.views.control_view import ControlView
from gpr20_user_interface.views.main_window import MainWindow, TabName, Tabs
from gpr20_user_interface.views.status_view import StatusView
from gpr20_user_interface.views.translation import Language, Languages, language_from_code

MASTER_WAIT_S = 30.0
DEFAULT_PROFILES = "~/.config/gpr20/profiles"
EXIT_NO_MASTER = 1
EXIT_WRONG_PARAMETER = 2
EXIT_BY_SIGNAL = 130


class UserInterface:
    """The window and everything that it needs, connected."""

    def __init__(self, model: SurveyModel, languages: Languages, profiles: Profiles) -> None:
        self.trace_link = StorageClient()
        self.traces = TracePresenter(self.trace_link)
        views = self.traces.views
        tabs = Tabs(ControlView(), StatusView(), views.map, views.radar, views.past)
        self.window = MainWindow(tabs, languages.language)
        self.window.language_requested.connect(languages.use_next)
        languages.changed.connect(self.window.show_language)
        self.link = RosLink()
        self.presenter = WindowPresenter(model, self.window, self.link)
        self._profiles = ProfilesPresenter(self.window, profiles)
        # The signals come from ROS's threads: Qt carries them into the thread of the window.
        self.link.event.connect(self.presenter.on_event, Qt.ConnectionType.QueuedConnection)
        self.trace_link.event.connect(self.traces.on_event, Qt.ConnectionType.QueuedConnection)
        self.presenter.refreshed.connect(self.traces.show_state)
        self.traces.resume_requested.connect(self.presenter.resume_past_survey)
        self.traces.radar_wanted.connect(lambda: self.window.show_tab(TabName.RADAR))
        self.traces.problem.connect(lambda text: rospy.logwarn("not shown: %s", text))

    def begin(self) -> None:
        """Show the window and listen to the graph."""
        self.link.listen()
        self.trace_link.listen()
        self.presenter.begin()
        self.traces.begin()
        self.window.show()

    def end(self) -> None:
        """Let go of the graph; a survey that runs is not touched."""
        self.traces.end()
        self.presenter.end()
        self.trace_link.close()
        self.link.close()

    def health(self) -> Health:
        """Return what this node says of itself."""
        # The snapshot is immutable: safe to look at from ROS's threads.
        snapshot = self.presenter.snapshot
        if snapshot.control_alive:
            return OK, "shows main_control", {}
        return WARN, "main_control is not heard", {"silent_s": snapshot.control_silent_s}


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
            # Nobody to take leave of; rospy would wait for the master once more.
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
    profiles = Profiles(ProfileFolder(folder))
    interface = UserInterface(SurveyModel(Clock()), languages, profiles)
    interface.link.shut_down.connect(application.quit, Qt.ConnectionType.QueuedConnection)
    # First: what is made while ROS ends this node would not notice it.
    diagnostics = Diagnostics("user_interface", interface.health)
    interface.begin()
    status = application.exec_()
    interface.end()
    # While the objects that it tells still exist.
    rospy.signal_shutdown("the window was closed")
    del diagnostics
    return status
