"""The command line of the terminal client."""

from __future__ import annotations

import argparse
from typing import Any, Callable, Sequence

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE, SPECS, FieldSpec
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL, StartPlan
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters

WAIT_S, MAX_WAIT_S = 15.0, 3600.0
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
    "    4  it is paused and stays paused\n"
    "  130  it was stopped by Ctrl-C or SIGTERM; after a second one it may still run\n"
)
SOIL = SPECS["permittivity"]


def parse_arguments(arguments: Sequence[str], catalogue: Catalogue) -> argparse.Namespace:
    """Read the command line, without the name of the program and without ROS remappings.

    Returns:
        `plan`, a StartPlan; `wait`; `resume`, the survey to resume by id or folder (empty: the
        paused one; None: none).

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    tr = catalogue.tr

    def reader(read: Callable[[str], Any]) -> Callable[[str], Any]:
        def read_argument(text: str) -> Any:
            try:
                return read(text)
            except InvalidValueError as error:
                # argparse shows the text of this error, but not that of a ValueError.
                raise argparse.ArgumentTypeError(catalogue.text(error.message)) from None

        return read_argument

    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=catalogue.text(DESCRIPTION),
        epilog=catalogue.text(EXIT_STATUS),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    fields = (*PARAMETERS, SOIL, *PEOPLE)
    for spec in fields:
        parser.add_argument(
            option_of(spec),
            dest=spec.name,
            default=argparse.SUPPRESS,
            type=reader(spec.kind.read),
            metavar=spec.kind.metavar,
            # Percent signs are the formats of argparse.
            help=catalogue.text(_meaning(spec)).replace("%", "%%"),
        )
    parser.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="SURVEY",
        help=tr("resume the paused survey, or the one with this id or folder, and follow it"),
    )
    parser.add_argument(
        "--wait",
        type=reader(lambda text: number_between("S", number_from_text(text), 0.0, MAX_WAIT_S, "s")),
        default=WAIT_S,
        metavar="S",
        help=tr("seconds to wait for the main control (default {default:g})", default=WAIT_S),
    )
    given = parser.parse_args(arguments)
    named = ", ".join(option_of(one) for one in fields if one.name in given)
    if given.resume is not None and named:
        parser.error(
            tr("{options} cannot be given with --resume: that survey has its own", options=named)
        )
    if given.resume is not None:
        # Folders may be given with their path; the main control knows where they are.
        given.resume = given.resume.rstrip("/").rsplit("/", 1)[-1]

    def values(specs: Sequence[FieldSpec]) -> Any:
        return {one.name: getattr(given, one.name, one.kind.read(one.default)) for one in specs}

    parameters, people = SurveyParameters(**values(PARAMETERS)), Annotation(**values(PEOPLE))
    # The window begins with a soil, which a person sees there; a command assumes none.
    given.plan = StartPlan(parameters, people, permittivity=getattr(given, SOIL.name, 0.0))
    return given


def option_of(spec: FieldSpec) -> str:
    """Return the option for a field; frequencies are given in MHz."""
    return "--" + spec.name.replace("_frequency_hz", "_frequency_mhz").replace("_", "-")


def _meaning(spec: FieldSpec) -> Message:
    meaning = Message("{field}: {allowed}", field=spec.title, allowed=spec.hint(DOCUMENTED_TRAVEL))
    if not spec.default or spec is SOIL:
        return meaning
    return Message("{meaning} (default {default})", meaning=meaning, default=spec.default)
