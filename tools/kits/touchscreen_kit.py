"""The window of the robot as far as the page at a distance needs it."""

from __future__ import annotations

from gpr20_common.low.clock import Clock
from gpr20_operator.high.control_client import ControlClient
from gpr20_operator.high.remote_control import WebPageClient
from gpr20_operator.robot.events import Senders
from gpr20_operator.robot.remote_control import Arming, RemotePlan
from gpr20_operator.robot.survey_model import SurveyModel
from gpr20_survey.plan.annotation import EMPTY
from gpr20_survey.plan.survey_parameters import SurveyParameters

PLAN = SurveyParameters(
    vna_address="127.0.0.1",
    start_frequency_hz=600e6,
    stop_frequency_hz=6e9,
    frequency_points=101,
    x_start_mm=100.0,
    x_stop_mm=300.0,
    x_points=21,
    y_start_mm=100.0,
    y_stop_mm=300.0,
    y_points=21,
)


class Touchscreen:
    """It follows the robot, and allows remote control."""

    def __init__(self) -> None:
        self.model = SurveyModel(Clock())
        senders = Senders("/")
        self.control = ControlClient(self._take, senders)
        self.web = WebPageClient(self._take, senders)
        self.arming = Arming(Clock(), self.web.send)
        for client in (self.control, self.web):
            client.listen()
        self.control.set_watched(True)

    def _take(self, event: object) -> None:
        self.model.handle(event)
        self.arming.take(event)

    def note(self) -> None:
        """Take what is known now, as the window does five times a second."""
        self.arming.note(self.model.snapshot(), RemotePlan(PLAN, EMPTY, "", 4.0))

    def close(self) -> None:
        """Leave the graph."""
        self.control.close()
        self.web.close()
