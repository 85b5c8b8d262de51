"""Everything that the window shows and asks through."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_operator.ground.traces import TracePresenter
from gpr20_operator.jobs.pictures import Imaging
from gpr20_operator.plan.stored import PlanMemory
from gpr20_operator.robot.remote_control import Arming
from gpr20_operator.robot.robots import Robots
from gpr20_operator.robot.service_model import ServiceModel
from gpr20_operator.robot.survey_control import WindowPresenter


@dataclass(frozen=True)
class Presenters:
    """The parts of the window without their widgets.

    Attributes:
        survey: The survey that runs, and the requests to the main control.
        traces: The traces, and the requests to the storage.
        imaging: Focused images, results and exports.
        service: Maintenance of the robot.
        plans: What the operator planned last.
        robots: The robots that share the ROS master.
        arming: Whether the web page may start and resume.
    """

    survey: WindowPresenter
    traces: TracePresenter
    imaging: Imaging
    service: ServiceModel
    plans: PlanMemory
    robots: Robots
    arming: Arming
