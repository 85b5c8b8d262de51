"""The command line of the terminal client."""

from __future__ import annotations

import argparse
import enum
import math
from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Sequence

from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.mid.parameter_form import FIELDS, Field
from gpr20_user_interface.mid.survey_follower import Mode, OnPause

DESCRIPTION = """\
Run a survey without a window: set its parameters, start it and follow it to its end.
Ctrl-C stops the survey and waits until main_control says that it has stopped."""

EXIT_STATUS = """\
exit status:
    0  the survey finished: every planned trace is stored
    1  it was refused or could not be started
    2  the command line is wrong
    3  it failed, was stopped by somebody else, or main_control was lost
    4  it is paused and was left so (--on-pause exit)
  130  it was stopped by Ctrl-C or by SIGTERM; after a second one it may still run
"""

_METAVARS = {"address": "A.B.C.D", "hz": "MHZ", "mm": "MM", "deg": "DEG,DEG"}
_HELP = {
    "vna_address": "address of the network analyzer",
    "start_frequency_hz": "start of the sweep",
    "stop_frequency_hz": "stop of the sweep",
    "frequency_points": "points of the sweep",
    "x_start_mm": "start of the area along x",
    "x_stop_mm": "stop of the area along x",
    "x_points": "stops along x",
    "y_start_mm": "start of the area along y",
    "y_stop_mm": "stop of the area along y",
    "y_points": "stops along y",
    "polarizations_deg": "rotations measured at each stop",
}


class Bar(enum.Enum):
    """How progress is shown."""

    AUTO = "auto"
    ALWAYS = "always"
    NEVER = "never"


@dataclass(frozen=True)
class Options:
    """What the command line asks for."""

    mode: Mode
    resume_id: str
    parameters: SurveyParameters
    wait_s: float
    on_pause: OnPause
    bar: Bar


def parse_arguments(arguments: Sequence[str]) -> Options:
    """Read the command line.

    Args:
        arguments: Without the program's name and without ROS remappings.

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=DESCRIPTION,
        epilog=EXIT_STATUS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parameters = _add_parameters(parser.add_argument_group("what to measure"))
    _add_conduct(parser.add_argument_group("how to run it"))
    given = parser.parse_args(arguments)
    mode = _mode(given.attach, given.resume)
    if mode is not Mode.START:
        _refuse_parameters(parser, parameters, arguments, mode)
    return Options(
        mode=mode,
        # Folders are told with their path; the control knows where they are.
        resume_id=(given.resume or "").rstrip("/").rsplit("/", 1)[-1],
        parameters=SurveyParameters(**{field.name: getattr(given, field.name) for field in FIELDS}),
        wait_s=given.wait,
        on_pause=OnPause(given.on_pause),
        bar=Bar(given.bar),
    )


def _mode(attach: bool, resume: Optional[str]) -> Mode:
    if attach:
        return Mode.ATTACH
    return Mode.START if resume is None else Mode.RESUME


def _refuse_parameters(
    parser: argparse.ArgumentParser,
    parameters: List[argparse.Action],
    arguments: Sequence[str],
    mode: Mode,
) -> None:
    """End with a message if parameters were given that a survey which exists cannot take."""
    # Defaults are not put over what is there already.
    given = argparse.Namespace(**{one.dest: None for one in parameters})
    parser.parse_args(arguments, given)
    named = [one.option_strings[0] for one in parameters if getattr(given, one.dest) is not None]
    if named:
        option = "--attach" if mode is Mode.ATTACH else "--resume"
        parser.error(
            f"{', '.join(named)} cannot be given with {option}: that survey keeps the "
            "parameters with which it was begun"
        )


def _add_parameters(group: argparse._ArgumentGroup) -> List[argparse.Action]:
    return [
        group.add_argument(
            "--" + field.name.replace("_hz", "_mhz").replace("_", "-"),
            dest=field.name,
            type=_reader(field),
            # argparse converts a default that is a string like an argument.
            default=field.default,
            metavar=_METAVARS.get(field.name.rsplit("_", 1)[-1], "N"),
            help=_HELP[field.name] + " (default %(default)s)",
        )
        for field in FIELDS
    ]


def _reader(field: Field) -> Callable[[str], Any]:
    def read(text: str) -> Any:
        try:
            return field.read(text)
        except ValueError as error:
            # argparse shows the text of this error, but not that of a ValueError.
            raise argparse.ArgumentTypeError(str(error)) from None

    return read


def _add_conduct(group: argparse._ArgumentGroup) -> None:
    which = group.add_mutually_exclusive_group()
    which.add_argument(
        "--attach",
        action="store_true",
        help="follow the survey that runs now, whoever started it; "
        "Ctrl-C stops that survey, a closed terminal leaves it running",
    )
    which.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="SURVEY",
        help="go on with the paused survey, or with the one of this id or folder, and follow it",
    )
    group.add_argument(
        "--on-pause",
        choices=[choice.value for choice in OnPause],
        default=OnPause.EXIT.value,
        help="when the survey pauses: leave it paused and exit with status 4, "
        "or wait until somebody resumes it (default %(default)s)",
    )
    group.add_argument(
        "--wait",
        type=_seconds,
        default=15.0,
        metavar="S",
        help="seconds to wait for main_control (default %(default)g)",
    )
    group.add_argument(
        "--bar",
        choices=[choice.value for choice in Bar],
        default=Bar.AUTO.value,
        help="progress bar, or plain lines; auto: a bar on a terminal (default %(default)s)",
    )


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of seconds above zero")
    return seconds
