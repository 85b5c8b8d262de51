import threading
from dataclasses import replace

import pytest

from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.preview import CostEstimated, CostEstimator
from gpr20_operator.robot.events import RobotFigures
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters, AxisType
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_settings import SurveySettings

LINEAR = dict(
    dir_pin=13, step_pin=15, sensor_pin=16, step_size=0.01, min_step=0.0015, max_step=0.005,
    delta_step=0.0001, min_coord=0.0, max_coord=650.0, type=AxisType.LINEAR.value,
)  # fmt: skip
AXIS = AxisParameters(**LINEAR)
FIGURES = RobotFigures(RobotConfig(dict.fromkeys(AxisId, AXIS), simulated=True), SurveySettings())


class Listener:
    """Remembers the answers; a test can wait for one."""

    def __init__(self):
        self.received = []
        self._changed = threading.Condition()

    def tell(self, event):
        with self._changed:
            self.received.append(event)
            self._changed.notify_all()

    def wait_for(self, event):
        with self._changed:
            return self._changed.wait_for(lambda: event in self.received, timeout=20.0)


@pytest.fixture
def listener():
    return Listener()


@pytest.fixture
def estimator(listener):
    estimator = CostEstimator(listener.tell)
    yield estimator
    estimator.close()


def test_the_newest_question_is_answered_as_the_control_would(estimator, listener):
    asked = [replace(default_parameters(), x_points=points) for points in range(3, 30)]
    for parameters in asked:
        estimator.ask(parameters, FIGURES)
    cost = survey_cost(asked[-1], FIGURES.config, FIGURES.settings)
    assert listener.wait_for(CostEstimated(asked[-1], cost))


def test_nothing_is_answered_after_the_end(estimator, listener):
    estimator.close()
    estimator.ask(default_parameters(), FIGURES)
    for thread in threading.enumerate():
        if thread.name == "CostEstimator._estimate":
            thread.join(20.0)
    assert listener.received == []
