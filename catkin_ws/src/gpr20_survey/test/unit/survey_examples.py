"""A survey and the axes of the robot, for tests."""

from gpr20_survey.axes import AxisId, AxisParameters
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveyParameters

AXES = {
    AxisId.X: AxisParameters(13, 15, 0.01, 0.0015, 0.005, 0.0001, 0.0, 650.0, "LIN", 16),
    AxisId.Y: AxisParameters(37, 38, 0.01, 0.0025, 0.005, 0.0001, 0.0, 800.0, "LIN", 40),
    AxisId.Z: AxisParameters(11, 12, 1.8, 0.010, 0.025, 0.005, -90.0, 90.0, "ROT"),
}
TRAVEL = RobotConfig(AXES, simulated=True).travel
PARAMETERS = SurveyParameters(
    vna_address="127.0.0.1",
    start_frequency_hz=600.0e6,
    stop_frequency_hz=6.0e9,
    frequency_points=5,
    x_start_mm=10.0,
    x_stop_mm=30.0,
    x_points=3,
    y_start_mm=5.0,
    y_stop_mm=35.0,
    y_points=4,
)
