"""The command line of the terminal client."""

from __future__ import annotations

import argparse
import enum
import math
from dataclasses import dataclass
from typing import List, Mapping, Optional, Sequence

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.errors import InvalidValueError
from gpr20_common.low.catalogue_file import language_from_environment, languages
from gpr20_common.message import Message
from gpr20_operator.plan.parameter_form import (
    ADDRESS,
    AVERAGES,
    FIELDS,
    IF_BANDWIDTH,
    OUTPUT_POWER,
)
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.terminal.arguments import add_annotation, annotation_from, argument_reader
from gpr20_user_interface.terminal.follower import Mode, OnPause

DESCRIPTION = Message(
    "Run a survey without a window: set its parameters, start it and follow it to its end.\n"
    "Ctrl-C stops the survey and waits for the confirmation of the main control."
)
EXIT_STATUS = Message(
    "exit status:\n"
    "    0  the survey finished: every planned trace is stored\n"
    "    1  it was refused or could not be started\n"
    "    2  the command line is wrong\n"
    "    3  it failed, another client stopped it, or contact with the main control was lost\n"
    "    4  it is paused and stays paused (--on-pause exit)\n"
    "  130  it was stopped by Ctrl-C or SIGTERM; after a second one it may still run\n"
)

DEFAULT_WAIT_S = 15.0
_METAVARS = {"address": "A.B.C.D", "mm": "MM", "deg": "DEG,DEG", "power": "POWER"}
_HELP: Mapping[str, Message] = {
    "vna_address": Message("address of the network analyzer"),
    "start_frequency_hz": Message("start of the sweep"),
    "stop_frequency_hz": Message("stop of the sweep"),
    "frequency_points": Message("points of the sweep"),
    "x_start_mm": Message("start of the area along x"),
    "x_stop_mm": Message("stop of the area along x"),
    "x_points": Message("stops along x"),
    "y_start_mm": Message("start of the area along y"),
    "y_stop_mm": Message("stop of the area along y"),
    "y_points": Message("stops along y"),
    "polarizations_deg": Message("antenna rotations measured at each stop"),
    IF_BANDWIDTH: Message("IF bandwidth of the network analyzer in Hz"),
    AVERAGES: Message("sweeps averaged for one trace"),
    OUTPUT_POWER: Message("output power of the network analyzer; LOW or HIGH for the MS2026C"),
}


class Bar(enum.Enum):
    """How progress is shown."""

    AUTO = "auto"
    ALWAYS = "always"
    NEVER = "never"


@dataclass(frozen=True)
class Options:
    """The command line."""

    mode: Mode
    resume_id: str
    accept_analyzer: str
    accept_zeros: bool
    parameters: SurveyParameters
    annotation: Annotation
    wait_s: float
    on_pause: OnPause
    bar: Bar


def terminal_language(arguments: Sequence[str], environment: Mapping[str, str]) -> Language:
    """Return the language that the command line names, else that of the environment.

    Read before everything else, so that the help is in this language too.
    """
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--language", nargs="?")
    code = parser.parse_known_args(arguments)[0].language
    named = (language for language in languages() if language.value == code)
    return next(named, language_from_environment(environment))


def parse_arguments(arguments: Sequence[str], catalogue: Catalogue) -> Options:
    """Read the command line.

    Args:
        arguments: Without the program's name and without ROS remappings.
        catalogue: Language of the help and of the messages.

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=catalogue.text(DESCRIPTION),
        epilog=catalogue.text(EXIT_STATUS),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    group = parser.add_argument_group(catalogue.tr("what to measure"))
    parameters = _add_parameters(group, catalogue)
    group = parser.add_argument_group(catalogue.tr("what to note"))
    parameters += add_annotation(group, catalogue)
    _add_run_options(parser.add_argument_group(catalogue.tr("how to run it")), catalogue)
    given = parser.parse_args(arguments)
    mode = _mode(given.attach, given.resume)
    if given.accept_analyzer and mode is not Mode.RESUME:
        parser.error(catalogue.tr("--accept-analyzer can be given only with --resume"))
    if given.accept_zeros and mode is not Mode.RESUME:
        parser.error(catalogue.tr("--accept-zeros can be given only with --resume"))
    if mode is not Mode.START:
        _refuse_parameters(parser, parameters, arguments, mode, catalogue)
    return Options(
        mode=mode,
        # Folders may be given with their path; the main control knows where they are.
        resume_id=(given.resume or "").rstrip("/").rsplit("/", 1)[-1],
        accept_analyzer=given.accept_analyzer,
        accept_zeros=given.accept_zeros,
        parameters=SurveyParameters(**{field.name: getattr(given, field.name) for field in FIELDS}),
        annotation=annotation_from(given),
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
    catalogue: Catalogue,
) -> None:
    """End with a message if parameters are given for a survey that exists already."""
    # Values that are there already are not replaced by defaults.
    given = argparse.Namespace(**{one.dest: None for one in parameters})
    parser.parse_args(arguments, given)
    named = [one.option_strings[0] for one in parameters if getattr(given, one.dest) is not None]
    if named:
        parser.error(
            catalogue.tr(
                "{options} cannot be given with {mode}: that survey has its own",
                options=", ".join(named),
                mode="--attach" if mode is Mode.ATTACH else "--resume",
            )
        )


def _add_parameters(group: argparse._ArgumentGroup, catalogue: Catalogue) -> List[argparse.Action]:
    return [
        group.add_argument(
            _option(field.name),
            dest=field.name,
            type=argument_reader(field.read, catalogue),
            # argparse converts a default that is a string like an argument.
            default=field.default,
            metavar=_metavar(field.name),
            help=catalogue.tr(
                "{meaning} (default {default})",
                meaning=_HELP[field.name],
                default=field.default or _default_meaning(field.name),
            ),
        )
        for field in FIELDS
    ]


def _option(name: str) -> str:
    # Frequencies are given in MHz.
    unit = name.replace("_frequency_hz", "_frequency_mhz")
    return "--" + unit.replace("_", "-")


def _metavar(name: str) -> str:
    if name.endswith("_hz"):
        return "HZ" if name == IF_BANDWIDTH else "MHZ"
    return _METAVARS.get(name.rsplit("_", 1)[-1], "N")


def _default_meaning(name: str) -> Message:
    if name == ADDRESS:
        return Message("that of the robot's configuration")
    return Message("as set on the VNA")


def _add_run_options(group: argparse._ArgumentGroup, catalogue: Catalogue) -> None:
    tr = catalogue.tr
    which = group.add_mutually_exclusive_group()
    which.add_argument(
        "--attach",
        action="store_true",
        help=tr(
            "follow the running survey; Ctrl-C stops it, closing the terminal leaves it running"
        ),
    )
    which.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="SURVEY",
        help=tr("resume the paused survey, or the one with this id or folder, and follow it"),
    )
    group.add_argument(
        "--accept-analyzer",
        default="",
        metavar="IDENTITY",
        help=tr(
            "with --resume: continue with another network analyzer than that of the survey; its "
            "identity is in the message of the refusal"
        ),
    )
    group.add_argument(
        "--accept-zeros",
        action="store_true",
        help=tr(
            "with --resume: continue although nothing proves that the zeros of the axes are those "
            "of the survey; its traces since then are marked"
        ),
    )
    group.add_argument(
        "--on-pause",
        choices=[choice.value for choice in OnPause],
        default=OnPause.EXIT.value,
        help=tr(
            "when the survey pauses: leave it paused and exit with status 4, or wait until it is "
            "resumed (default {default})",
            default=OnPause.EXIT.value,
        ),
    )
    group.add_argument(
        "--wait",
        type=argument_reader(_seconds, catalogue),
        default=DEFAULT_WAIT_S,
        metavar="S",
        help=tr(
            "seconds to wait for the main control (default {default:g})", default=DEFAULT_WAIT_S
        ),
    )
    group.add_argument(
        "--bar",
        choices=[choice.value for choice in Bar],
        default=Bar.AUTO.value,
        help=tr(
            "progress bar or plain lines; auto: a bar on a terminal (default {default})",
            default=Bar.AUTO.value,
        ),
    )
    group.add_argument(
        "--language",
        choices=[language.value for language in languages()],
        help=tr("language of the messages (default: that of the terminal)"),
    )


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise InvalidValueError(
            Message("'{text}' is not a number of seconds above zero", text=text)
        )
    return seconds
