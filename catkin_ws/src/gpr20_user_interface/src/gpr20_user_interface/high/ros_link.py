"""main_control on the ROS graph, for objects that live in the thread of a window."""

from __future__ import annotations

import rospy
from PyQt5.QtCore import QObject, pyqtSignal

from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.high.control_client import ControlClient
from gpr20_user_interface.mid.events import Event


class RosLink(QObject):
    """Emits every event as a signal; Qt carries it from ROS's threads to the receiver's."""

    event = pyqtSignal(object)
    # ROS asks this node to end.
    shut_down = pyqtSignal()

    def __init__(self) -> None:
        super().__init__()
        self._client = ControlClient(self._tell)

    def listen(self) -> None:
        """Begin to emit events."""
        rospy.on_shutdown(self._tell_shut_down)
        self._client.listen()
        self._client.listen_to_robot()

    def close(self) -> None:
        """Emit nothing more."""
        self._client.close()

    def start_survey(self, parameters: SurveyParameters) -> None:
        """Ask to accept the parameters and to start."""
        self._client.start_survey(parameters)

    def stop_survey(self) -> None:
        """Ask to stop."""
        self._client.stop_survey()

    def pause_survey(self) -> None:
        """Ask to hold the survey."""
        self._client.pause_survey()

    def resume_survey(self, survey: str = "") -> None:
        """Ask to go on with the paused survey, or with one by its id or its folder's name."""
        self._client.resume_survey(survey)

    def read_axis_limits(self) -> None:
        """Read what the axes can do."""
        self._client.read_axis_limits()

    # Methods, not the signals' own emit: a signal does not keep its object alive, and threads
    # of ROS may outlive everybody else who does.
    def _tell(self, event: Event) -> None:
        self.event.emit(event)

    def _tell_shut_down(self) -> None:
        self.shut_down.emit()
