"""What a survey was to measure, from what was recorded of it."""

from __future__ import annotations

from typing import Any, Mapping, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_survey import faults
from gpr20_survey.plan.survey_parameters import (
    RobotTravel,
    SurveyParameters,
    Travel,
    check,
)


def recorded_plan(description: Mapping[str, Any]) -> Tuple[SurveyParameters, RobotTravel]:
    """Return the parameters of a survey and the travel of its axes.

    Args:
        description: What the log says of the survey.

    Raises:
        InvalidValueError: Parameters or axes are missing or not allowed.
    """
    try:
        axes = description["axes"]
        travel = RobotTravel(**{axis: _travel(axes[axis], axis) for axis in ("x", "y", "z")})
        parameters = record_from(SurveyParameters, description["parameters"], "parameters")
        check(parameters, travel)
    except (KeyError, TypeError, ArithmeticError) as error:
        raise InvalidValueError(
            Message("survey.json is incomplete", details=repr(error)), fault=faults.PLAN_UNREADABLE
        ) from error
    except InvalidValueError as error:
        # Nobody can correct the plan of a survey that was measured.
        raise InvalidValueError(error.message, fault=faults.PLAN_UNREADABLE) from error
    return parameters, travel


def _travel(axis: Any, name: str) -> Travel:
    numbers = [axis[key] for key in ("min_coord", "max_coord", "step_size")]
    if not all(isinstance(one, float) for one in numbers) or not numbers[2] > 0.0:
        raise InvalidValueError(
            Message("axes/{axis} of survey.json does not hold the numbers of an axis", axis=name),
            fault=faults.PLAN_UNREADABLE,
        )
    return Travel(*numbers)
