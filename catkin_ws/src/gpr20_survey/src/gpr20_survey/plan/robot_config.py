"""What is fixed for one robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict

from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.survey_parameters import RobotTravel, Travel


@dataclass(frozen=True)
class RobotConfig:
    """What is fixed for one robot.

    Attributes:
        axes: Parameters of its axes.
        simulated: Whether it is simulated.
        time_scale: How many times faster than the real robot it runs; 1 if it is real.
    """

    axes: Dict[AxisId, AxisParameters]
    simulated: bool
    time_scale: float = 1.0

    @property
    def travel(self) -> RobotTravel:
        """What the axes can do."""
        x, y, z = (self.axes[axis_id] for axis_id in AxisId)
        return RobotTravel(_travel(x), _travel(y), _travel(z))


def _travel(parameters: AxisParameters) -> Travel:
    return Travel(parameters.min_coord, parameters.max_coord, parameters.step_size)
