"""The command line of the terminal client."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE, SPECS, FieldSpec
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters

WAIT_S = 15.0
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
FIELDS = (*PARAMETERS, SOIL, *PEOPLE)


@dataclass(frozen=True)
class Options:
    """The command line.

    Attributes:
        resume: The survey to resume, by id or folder; empty: the paused one; None: none.
    """

    attach: bool
    resume: Optional[str]
    accept_analyzer: str
    accept_zeros: bool
    parameters: SurveyParameters
    annotation: Annotation
    permittivity: float
    wait_s: float


def parse_arguments(arguments: Sequence[str], catalogue: Catalogue) -> Options:
    """Read the command line, without the name of the program and without ROS remappings.

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=catalogue.text(DESCRIPTION),
        epilog=catalogue.text(EXIT_STATUS),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    measured = parser.add_argument_group(catalogue.tr("what to measure"))
    noted = parser.add_argument_group(catalogue.tr("what to note"))
    for spec in FIELDS:
        _add_field(measured if spec in PARAMETERS else noted, spec, catalogue)
    _add_run_options(parser.add_argument_group(catalogue.tr("how to run it")), catalogue)
    given = parser.parse_args(arguments)
    if given.resume is None and (given.accept_analyzer or given.accept_zeros):
        option = "--accept-analyzer" if given.accept_analyzer else "--accept-zeros"
        parser.error(catalogue.tr("{option} can be given only with --resume", option=option))
    named = [option_of(one) for one in FIELDS if getattr(given, one.name) is not None]
    if named and (given.attach or given.resume is not None):
        parser.error(
            catalogue.tr(
                "{options} cannot be given with {mode}: that survey has its own",
                options=", ".join(named),
                mode="--attach" if given.attach else "--resume",
            )
        )

    def value(spec: FieldSpec) -> Any:
        found = getattr(given, spec.name)
        return spec.kind.read(spec.default) if found is None else found

    return Options(
        attach=given.attach,
        # Folders may be given with their path; the main control knows where they are.
        resume=None if given.resume is None else given.resume.rstrip("/").rsplit("/", 1)[-1],
        accept_analyzer=given.accept_analyzer,
        accept_zeros=given.accept_zeros,
        parameters=SurveyParameters(**{one.name: value(one) for one in PARAMETERS}),
        annotation=Annotation(**{one.name: value(one) for one in PEOPLE}),
        # The window begins with a soil, which a person sees there; a command assumes none.
        permittivity=given.permittivity or 0.0,
        wait_s=given.wait,
    )


def option_of(spec: FieldSpec) -> str:
    """Return the option for a field; frequencies are given in MHz."""
    return "--" + spec.name.replace("_frequency_hz", "_frequency_mhz").replace("_", "-")


def _add_field(group: argparse._ArgumentGroup, spec: FieldSpec, catalogue: Catalogue) -> None:
    allowed = spec.hint(DOCUMENTED_TRAVEL)
    meaning = Message("{field}: {allowed}", field=spec.title, allowed=allowed)
    if spec.default and spec is not SOIL:
        meaning = Message("{meaning} (default {default})", meaning=meaning, default=spec.default)
    group.add_argument(
        option_of(spec),
        dest=spec.name,
        type=_reader(spec.kind.read, catalogue),
        metavar=spec.kind.metavar,
        # Percent signs are the formats of argparse.
        help=catalogue.text(meaning).replace("%", "%%"),
    )


def _reader(read: Callable[[str], Any], catalogue: Catalogue) -> Callable[[str], Any]:
    """Return a function for argparse that reads an argument."""

    def read_argument(text: str) -> Any:
        try:
            return read(text)
        except InvalidValueError as error:
            # argparse shows the text of this error, but not that of a ValueError.
            raise argparse.ArgumentTypeError(catalogue.text(error.message)) from None

    return read_argument


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
        "--wait",
        type=_reader(number_from_text, catalogue),
        default=WAIT_S,
        metavar="S",
        help=tr("seconds to wait for the main control (default {default:g})", default=WAIT_S),
    )
