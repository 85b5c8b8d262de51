"""The command line of the terminal client."""

from __future__ import annotations

import argparse
import contextlib
import enum
from dataclasses import dataclass, replace
from typing import Any, Callable, Iterator, List, Mapping, Optional, Sequence

from gpr20_common.catalogue import Catalogue, Language, language_from_environment, languages
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.fields import PARAMETERS, PEOPLE, SPECS
from gpr20_operator.plan.spec import FieldSpec
from gpr20_operator.robot.events import DOCUMENTED_TRAVEL
from gpr20_operator.words import number_from_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.terminal.follower import Limits, Mode, OnPause

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
    "    5  it was a replay: nothing was measured\n"
    "  130  it was stopped by Ctrl-C or SIGTERM; after a second one it may still run\n"
)
OF_ARGPARSE = (
    Message("usage: "),
    Message("options"),
    Message("optional arguments"),  # of Python 3.8 and 3.9
    Message("show this help message and exit"),
    Message("argument %(argument_name)s: %(message)s"),
    Message("not allowed with argument %s"),
    Message("expected one argument"),
    Message("ignored explicit argument %r"),
    Message("unrecognized arguments: %s"),
    Message("ambiguous option: %(option)s could match %(matches)s"),
    Message("invalid choice: %(value)r (choose from %(choices)s)"),
)
"""Sentences that argparse says itself, which it looks up by its own function `_`."""
_PLANNED = SPECS["permittivity"]
# The window begins with a soil, which a person sees there; a command assumes none.
SOIL = replace(
    _PLANNED,
    kind=replace(_PLANNED.kind, read=lambda text: _PLANNED.kind.read(text) if text else 0.0),
    default="",
    empty=Message("not known"),
)


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
    permittivity: float
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
    """Read the command line, without the name of the program and without ROS remappings.

    Raises:
        SystemExit: With status 2 after a message, or 0 after the help.
    """
    with _argparse_in(catalogue):
        return _parse(arguments, catalogue)


@contextlib.contextmanager
def _argparse_in(catalogue: Catalogue) -> Iterator[None]:
    known = {one.template for one in OF_ARGPARSE}
    own = argparse._, argparse.ngettext  # type: ignore[attr-defined]

    def look_up(template: str) -> str:
        return catalogue.template(template) if template in known else template

    try:
        argparse._ = look_up  # type: ignore[attr-defined]
        argparse.ngettext = lambda one, _many, _count: look_up(one)  # type: ignore[attr-defined]
        yield
    finally:
        argparse._, argparse.ngettext = own  # type: ignore[attr-defined]


def _parse(arguments: Sequence[str], catalogue: Catalogue) -> Options:
    parser = argparse.ArgumentParser(
        prog="run_survey",
        description=catalogue.text(DESCRIPTION),
        epilog=catalogue.text(EXIT_STATUS),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    measured = parser.add_argument_group(catalogue.tr("what to measure"))
    noted = parser.add_argument_group(catalogue.tr("what to note"))
    fields = [_add_field(measured, spec, catalogue) for spec in PARAMETERS]
    fields += [_add_field(noted, spec, catalogue) for spec in (SOIL, *PEOPLE)]
    _add_run_options(parser.add_argument_group(catalogue.tr("how to run it")), catalogue)
    given = parser.parse_args(arguments)
    mode = _mode(given.attach, given.resume)
    if given.accept_analyzer and mode is not Mode.RESUME:
        parser.error(catalogue.tr("--accept-analyzer can be given only with --resume"))
    if given.accept_zeros and mode is not Mode.RESUME:
        parser.error(catalogue.tr("--accept-zeros can be given only with --resume"))
    if mode is not Mode.START:
        _refuse_fields(parser, fields, arguments, mode, catalogue)
    return Options(
        mode=mode,
        # Folders may be given with their path; the main control knows where they are.
        resume_id=(given.resume or "").rstrip("/").rsplit("/", 1)[-1],
        accept_analyzer=given.accept_analyzer,
        accept_zeros=given.accept_zeros,
        parameters=SurveyParameters(**{one.name: getattr(given, one.name) for one in PARAMETERS}),
        annotation=Annotation(**{one.name: getattr(given, one.name) for one in PEOPLE}),
        permittivity=given.permittivity,
        wait_s=given.wait,
        on_pause=OnPause(given.on_pause),
        bar=Bar(given.bar),
    )


def _mode(attach: bool, resume: Optional[str]) -> Mode:
    if attach:
        return Mode.ATTACH
    return Mode.START if resume is None else Mode.RESUME


def _refuse_fields(
    parser: argparse.ArgumentParser,
    fields: List[argparse.Action],
    arguments: Sequence[str],
    mode: Mode,
    catalogue: Catalogue,
) -> None:
    """End with a message if values are given for a survey that exists already."""
    # Values that are there already are not replaced by defaults.
    given = argparse.Namespace(**{one.dest: None for one in fields})
    parser.parse_args(arguments, given)
    named = [one.option_strings[0] for one in fields if getattr(given, one.dest) is not None]
    if named:
        parser.error(
            catalogue.tr(
                "{options} cannot be given with {mode}: that survey has its own",
                options=", ".join(named),
                mode="--attach" if mode is Mode.ATTACH else "--resume",
            )
        )


def option_of(spec: FieldSpec) -> str:
    """Return the option for a field; frequencies are given in MHz."""
    return "--" + spec.name.replace("_frequency_hz", "_frequency_mhz").replace("_", "-")


def _add_field(
    group: argparse._ArgumentGroup, spec: FieldSpec, catalogue: Catalogue
) -> argparse.Action:
    meaning = Message("{field}: {allowed}", field=spec.title, allowed=_allowed(spec))
    if spec.default:
        meaning = Message("{meaning} (default {default})", meaning=meaning, default=spec.default)
    return group.add_argument(
        option_of(spec),
        dest=spec.name,
        type=_reader(spec.kind.read, catalogue),
        # argparse converts a default that is a string like an argument.
        default=spec.default,
        metavar=spec.kind.metavar,
        # Percent signs are the formats of argparse.
        help=catalogue.text(meaning).replace("%", "%%"),
    )


def _allowed(spec: FieldSpec) -> Message:
    if spec.name == "position":
        text = "--position=LAT,LON"
        note = Message("with a negative latitude write {option}", option=verbatim(text))
        return Message("{first}; {second}", first=spec.hint(DOCUMENTED_TRAVEL), second=note)
    return spec.hint(DOCUMENTED_TRAVEL)


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
        type=_reader(_seconds, catalogue),
        default=Limits.wait_s,
        metavar="S",
        help=tr(
            "seconds to wait for the main control (default {default:g})", default=Limits.wait_s
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
        seconds = number_from_text(text)
    except InvalidValueError:
        seconds = 0.0
    if seconds <= 0.0:
        raise InvalidValueError(
            Message("'{text}' is not a number of seconds above zero", text=text)
        )
    return seconds
