"""The program daily_check: three sweeps in three minutes, against the checks before."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from typing import Any

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
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_doctor.low.masters import MasterState, state_of
from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.high.ros_devices import DeviceService
from gpr20_msgs.msg import ControlStatus
from gpr20_msgs.srv import DailyCheck
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.daily_check import INSTRUCTIONS

PROGRAM = "daily_check"
CONTACT_LIMIT_S = 10.0
# The control ends a step sooner, whatever its analyzer does.
STEP_LIMIT_S = 300.0
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
    language = parser.parse_args(rosgraph.myargv()[1:]).language
    catalogue = read_catalogue(
        language_from_environment(os.environ) if language is None else language_from_code(language)
    )
    try:
        return _check(catalogue)
    except KeyboardInterrupt:
        stopped = catalogue.tr("The check was stopped; nothing was stored.")
        say("", stopped, file=sys.stderr)
        return STOPPED
    except (Gpr20Error, OSError, rospy.ROSException) as error:
        known = (
            error.message
            if isinstance(error, Gpr20Error)
            else Message("the check could not be made: {reason}", reason=str(error))
        )
        lines = [known] if known.remedy is None else [known, known.remedy]
        say("\n-> ".join(catalogue.text(one) for one in lines), file=sys.stderr, flush=True)
        return NOT_MADE


def _check(catalogue: Catalogue) -> int:
    if state_of(rosgraph.get_master_uri()) is not MasterState.ANSWERS:
        raise RequestRefusedError(
            Message("no ROS master answers; start the robot first"), fault=NOT_RUNNING
        )
    rospy.init_node(
        PROGRAM, anonymous=True, disable_rostime=True, disable_rosout=True, disable_signals=True
    )
    try:
        status = rospy.wait_for_message("control_status", ControlStatus, CONTACT_LIMIT_S)
    except rospy.ROSException as error:
        raise DeviceError(
            Message("no contact with the main control", details=error), fault=PART_SILENT
        ) from error
    if status.simulated:
        say(catalogue.tr("SIMULATED robot: the check shows no real antennas."))
    step = DeviceService(Message("the main control"), "daily_check", DailyCheck, STEP_LIMIT_S)
    answer: Any = None
    for number, instruction in enumerate(INSTRUCTIONS.values()):
        go_on = catalogue.tr("Then press Enter.")
        place = f"[{number + 1}/{len(INSTRUCTIONS)}]"
        say(f"{place} {catalogue.text(instruction)} {go_on}", flush=True)
        if not sys.stdin.readline():
            raise RequestRefusedError(
                Message("nobody confirmed that the antennas are ready"), fault=CHECK_ORDER.as_note()
            )
        answer = step(step=number)
    say(catalogue.text(message_from(answer)), flush=True)
    return GOOD if answer.good else DIFFERS
