"""Whether a survey on the disk can go on with this robot, and with which parameters."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any, Dict

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import record_from
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.robot import ReopenedSurvey
from gpr20_survey.plan.robot_config import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveyParameters

# What of an axis decides where its coordinates are on the ground.
GRID_PARAMETERS = ("step_size", "min_coord", "max_coord", "type", "homing_backoff")


def resumable_parameters(reopened: ReopenedSurvey, facts: RobotConfig) -> SurveyParameters:
    """Return the parameters with which a survey began, if this robot can go on with it.

    Raises:
        RequestRefusedError: The survey is another robot's, or its metadata are not whole.
    """
    try:
        metadata = json.loads(reopened.metadata_json)
        parameters = record_from(SurveyParameters, metadata["parameters"], "parameters")
        simulated, axes = metadata["simulated"], metadata["axes"]
    except (ValueError, KeyError, TypeError, InvalidValueError) as error:
        raise RequestRefusedError(
            f"the survey in {reopened.folder} cannot go on, its survey.json is not whole: {error}"
        ) from error
    if simulated is not facts.simulated:
        kinds = {True: "a simulated", False: "the real"}
        raise RequestRefusedError(
            f"the survey in {reopened.folder} was measured by {kinds[bool(simulated)]} robot; it "
            f"cannot go on with {kinds[facts.simulated]} one"
        )
    _check_axes(axes, facts, reopened.folder)
    return parameters


def _check_axes(recorded: Dict[str, Dict[str, Any]], facts: RobotConfig, folder: str) -> None:
    for axis_id, parameters in facts.axes.items():
        present = asdict(parameters)
        for name in GRID_PARAMETERS:
            former = recorded.get(axis_id.value, {}).get(name)
            if former != present[name]:
                raise RequestRefusedError(
                    f"the survey in {folder} was measured with {name} {former} of the "
                    f"{axis_id.value} axis, which is {present[name]} now: its points would lie "
                    "elsewhere; launch with the former parameters, or start a new survey"
                )
