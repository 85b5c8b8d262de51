import os
from dataclasses import replace

import pytest

pytest.importorskip("PyQt5")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PyQt5.QtCore import Qt
from PyQt5.QtTest import QTest
from window_helpers import application

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters, AxisType
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_cost import survey_cost
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_user_interface.mid.events import RobotFigures
from gpr20_user_interface.mid.parameter_form import default_parameters
from gpr20_user_interface.mid.survey_preview import CostEstimator

__all__ = ["application"]

LINEAR = dict(
    dir_pin=13, step_pin=15, sensor_pin=16, step_size=0.01, min_step=0.0015, max_step=0.005,
    delta_step=0.0001, min_coord=0.0, max_coord=650.0, type=AxisType.LINEAR.value,
)  # fmt: skip
AXIS = AxisParameters(**LINEAR)
FIGURES = RobotFigures(RobotConfig(dict.fromkeys(AxisId, AXIS), simulated=True), SurveySettings())


@pytest.fixture
def estimator(application):
    estimator = CostEstimator()
    estimator.heard = []
    estimator.estimated.connect(
        lambda parameters, cost: estimator.heard.append((parameters, cost)),
        Qt.ConnectionType.QueuedConnection,
    )
    yield estimator
    estimator.close()


def wait_for(condition):
    for _ in range(500):
        if condition():
            return
        QTest.qWait(10)
    raise AssertionError("not within 5 s")


def test_the_newest_question_is_answered_as_the_control_would(estimator):
    asked = [replace(default_parameters(), x_points=points) for points in range(3, 30)]
    for parameters in asked:
        estimator.ask(parameters, FIGURES)
    wait_for(lambda: estimator.heard and estimator.heard[-1][0] == asked[-1])
    assert estimator.heard[-1][1] == survey_cost(asked[-1], FIGURES.facts, FIGURES.settings)


def test_nothing_is_answered_after_the_end(estimator):
    estimator.close()
    estimator.ask(default_parameters(), FIGURES)
    wait_for(lambda: not estimator._working)
    QTest.qWait(1)
    assert estimator.heard == []
