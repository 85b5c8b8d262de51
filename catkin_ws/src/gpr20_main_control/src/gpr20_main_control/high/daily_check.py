"""The program daily_check: three sweeps in three minutes, against the checks before."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from typing import Any, Callable, Sequence

import rosgraph
import rospy

from gpr20_common.catalogue import (
    Catalogue,
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import NOT_RUNNING, PART_SILENT
from gpr20_common.high.answers import message_from
from gpr20_common.low.clock import time_of_day_us
from gpr20_common.low.data_folder import data_folder, state_folder
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor.high.node_reports import descriptions
from gpr20_doctor.low.masters import MasterState, state_of
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.high.ros_devices import RosAnalyzer
from gpr20_main_control.mid.daily_check import (
    CheckedRobot,
    compare_with_history,
    history_folder,
    make_check,
)
from gpr20_main_control.mid.devices.described_robot import TimeLimits
from gpr20_msgs.msg import ControlStatus, RobotConfiguration
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.folder.data_folder import DataFolderUse
from gpr20_survey.plan.robot_description import ANALYZER, STORAGE
from gpr20_survey.plan.survey_state import RUNNING, SurveyState
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.utc_time import iso_text

PROGRAM = "daily_check"
CONTACT_LIMIT_S = 10.0
GOOD, DIFFERS, NOT_MADE, STOPPED = 0, 1, 3, 130
EXIT_STATUS = (
    "exit status: 0 good, or the first check; 1 something differs; 2 the command line is wrong; "
    "3 the check could not be made; 130 it was stopped by Ctrl-C"
)


def main() -> int:
    """Make the check and print its verdict; return the exit status."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    parser = argparse.ArgumentParser(PROGRAM, description=__doc__, epilog=EXIT_STATUS)
    parser.add_argument("--language", choices=[one.value for one in languages()])
    parser.add_argument("--address", default="", help="of the VNA; default: as the robot has it")
    parser.add_argument("--data", default="", help="folder of the surveys and of the history")
    given = parser.parse_args(rosgraph.myargv()[1:])
    catalogue = read_catalogue(
        language_from_environment(os.environ)
        if given.language is None
        else language_from_code(given.language)
    )
    try:
        return _check(given, catalogue, sys.stdin.readline)
    except KeyboardInterrupt:
        stopped = catalogue.tr("The check was stopped; nothing was stored.")
        say("", stopped, file=sys.stderr)
        return STOPPED
    except (Gpr20Error, OSError, rospy.ROSException) as error:
        _print_failure(error, catalogue)
        return NOT_MADE


def _check(given: argparse.Namespace, catalogue: Catalogue, answer: Callable[[], str]) -> int:
    if state_of(rosgraph.get_master_uri()) is not MasterState.ANSWERS:
        raise RequestRefusedError(
            Message("no ROS master answers; start the robot first"), fault=NOT_RUNNING
        )
    rospy.init_node(
        PROGRAM, anonymous=True, disable_rostime=True, disable_rosout=True, disable_signals=True
    )
    robot, data = _robot(given)
    if robot.simulated:
        say(catalogue.tr("SIMULATED robot: the check shows no real antennas."))

    def instruct(part: Part, instruction: Message) -> None:
        number, total = list(Part).index(part) + 1, len(Part)
        go_on = catalogue.tr("Then press Enter.")
        say(f"[{number}/{total}] {catalogue.text(instruction)} {go_on}", flush=True)
        if not answer():
            raise RequestRefusedError(
                Message("nobody confirmed that the antennas are ready"), fault=CHECK_ORDER.as_note()
            )
        _refuse_beside_survey()

    _refuse_beside_survey()
    check = make_check(RosAnalyzer(TimeLimits()), robot.address, instruct)
    verdict, damaged = compare_with_history(check, robot, data, iso_text(time_of_day_us()))
    lines = [one.message for one in verdict.comparisons]
    if damaged:
        lines.append(Message("Lines of the history that cannot be read: {count}", count=damaged))
    say(*(catalogue.text(one) for one in [*lines, verdict.message]), flush=True)
    return GOOD if verdict.good else DIFFERS


def _robot(given: argparse.Namespace) -> Any:
    """Return which robot is checked, and the folder of its surveys."""
    configuration = _latched("robot_configuration", RobotConfiguration)
    if not configuration.known:
        raise RequestRefusedError(message_from(configuration))
    nodes = descriptions(configuration)
    address = given.address or str(nodes[ANALYZER].configuration.get("address", ""))
    name = str(json.loads(configuration.site_json).get("robot", ""))
    stored = nodes[STORAGE].configuration.get("data", "") if STORAGE in nodes else ""
    data = data_folder(given.data, os.environ) if given.data else history_folder(stored, os.environ)
    use = DataFolderUse(data, state_folder(os.environ))
    return CheckedRobot(name, configuration.simulated, address), use


def _refuse_beside_survey() -> None:
    status = _latched("control_status", ControlStatus)
    if SurveyState(status.code) in RUNNING:
        raise RequestRefusedError(
            Message("a survey is running or paused: stop it, or wait for its end")
        )


def _latched(topic: str, kind: Any) -> Any:
    try:
        return rospy.wait_for_message(topic, kind, CONTACT_LIMIT_S)
    except rospy.ROSException as error:
        raise DeviceError(
            Message("no contact with the main control", details=error), fault=PART_SILENT
        ) from error


def _print_failure(error: BaseException, catalogue: Catalogue) -> None:
    known = (
        error.message
        if isinstance(error, Gpr20Error)
        else Message("the check could not be made: {reason}", reason=str(error))
    )
    lines: Sequence[str] = [catalogue.text(known)]
    if known.remedy is not None:
        lines = [*lines, f"-> {catalogue.text(known.remedy)}"]
    say(*lines, file=sys.stderr, flush=True)
