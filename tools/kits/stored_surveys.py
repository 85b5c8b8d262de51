"""What must be true of the surveys that a robot in one process has stored, file by file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np
from robot_in_process import RobotInProcess
from storage_kit import bag_traces, mcap_traces, torn_mcap_traces, with_bag
from trace_examples import assert_same_numbers

from gpr20_common.catalogue import FOLDER, read_translations
from gpr20_main_control.mid.survey.survey import NOTHING, Accepted
from gpr20_main_control.mid.survey.survey_status import Status
from gpr20_simulator.mid.world.medium import probed_rotation_deg
from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import Trace

TRACES = 18
SPANISH = read_translations(FOLDER / "es.po")
NUMERAL = re.compile(r"\{number:[^{}]*\}")


def folder_of(robot: RobotInProcess, survey_id: str = "") -> Path:
    """Return the folder of a survey; of the present or last one by default."""
    (folder,) = robot.world.data.glob(f"*_{(survey_id or robot.status.status.survey_id)[:8]}")
    return folder


def description_in(robot: RobotInProcess, survey_id: str = "") -> Dict[str, Any]:
    """Return what the log of a survey says of it."""
    return read_description(folder_of(robot, survey_id))


def json_traces(robot: RobotInProcess, survey_id: str = "") -> List[Dict[str, Any]]:
    """Return the JSON traces of a survey in the order of their index."""
    files = sorted((folder_of(robot, survey_id) / "traces").glob("*.json"))
    return [json.loads(path.read_text()) for path in files]


def check_state(robot: RobotInProcess, state: SurveyState) -> Status:
    """Return the status with which the survey ends or pauses; all of it is in Spanish too."""
    status = robot.wait_for_end()
    assert status.state is state, status.message
    assert str(status.full_message).isprintable()
    shown = {one.template for one in status.full_message.nested()}
    assert {one for one in shown if not NUMERAL.fullmatch(one)} <= SPANISH.keys()
    return status


def check_pause(robot: RobotInProcess, code: str, *values: str) -> None:
    """Wait until the survey pauses with a fault; the operator must read these values."""
    message = check_state(robot, SurveyState.PAUSED).message
    assert message.fault_code == code, message
    assert all(value in str(message) for value in values), message


def check_resumed(robot: RobotInProcess, accepted: Accepted = NOTHING) -> List[Dict[str, Any]]:
    """Resume the paused survey; it must end complete. Return its traces."""
    robot.go_on(accepted)
    check_state(robot, SurveyState.FINISHED)
    return check_complete(robot)


def check_complete(robot: RobotInProcess, survey_id: str = "") -> List[Dict[str, Any]]:
    """Return the traces: each point once, a whole sweep of its own that was made there."""
    stored = json_traces(robot, survey_id)
    assert [one["index"] for one in stored] == list(range(TRACES))
    places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
    assert len(places) == TRACES
    check_places(stored, [0.0] * TRACES)
    return stored


def check_places(stored: List[Dict[str, Any]], turned_deg: Sequence[float]) -> None:
    """Check that each trace is a whole sweep of its own that was made where it says.

    Args:
        stored: The traces of a survey.
        turned_deg: By how much the zero of z was off the mark of the antennas [deg].
    """
    sweeps = [one["s21_real"][0] for one in stored]
    assert len(set(sweeps)) == len(stored), "a sweep was stored twice"
    for one, sweep, angle_deg in zip(stored, sweeps, turned_deg):
        assert set(one["s21_real"]) == {sweep}, "two sweeps are mixed"
        place = np.float32(one["x_coord_mm"] + one["y_coord_mm"] / 1000.0)
        assert set(one["s21_imag"]) == {float(place)}
        off_deg = probed_rotation_deg(complex(sweep)) - one["z_coord_deg"] - angle_deg
        assert abs((off_deg + 100.0) % 200.0 - 100.0) < 0.4
        assert abs(one["antennae_height_m"] - 0.20) < 0.01


def check_acknowledged(
    robot: RobotInProcess, acknowledged: List[Trace], survey_id: str = ""
) -> None:
    """Find each trace whose storage was acknowledged, once, in every form of the survey."""
    folder = folder_of(robot, survey_id)
    stored = {one["index"]: one for one in json_traces(robot, survey_id)}
    if (folder / "manifest.json").exists():
        bag = with_bag(folder) / "survey.bag"
        recordings = [bag_traces(bag), mcap_traces(folder / "survey.mcap")]
    else:
        # It was cut off, and nobody has resumed it: it has no bag.
        recordings = [torn_mcap_traces(folder / "survey.mcap")]
    recorded = [{one.index: one for one in found} for found in recordings]
    assert all(stored.keys() == found.keys() for found in recorded)
    for trace in acknowledged:
        for form in (stored, *recorded):
            assert_same_numbers(trace, form[trace.index])
