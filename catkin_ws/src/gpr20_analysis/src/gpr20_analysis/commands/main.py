"""The command gpr20."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import traceback
from typing import List, Optional, Tuple

from gpr20_analysis import __version__
from gpr20_analysis.commands import command
from gpr20_analysis.commands.command import EXIT_STATUS, REFUSED
from gpr20_analysis.commands.failure import EXPECTED, TRACEBACK, first_steps, message_of
from gpr20_analysis.sentences import json_fields, shown
from gpr20_common.catalogue import (
    Language,
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.terminal_text import say


def main(arguments: Optional[List[str]] = None) -> int:
    """Run a subcommand; return the exit status."""
    given = sys.argv[1:] if arguments is None else arguments
    if arguments is None:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # it cleans up like Ctrl-C
    try:
        language, given = _language(given)
    except SystemExit:
        return REFUSED
    chosen = argparse.Namespace()
    try:
        return _run(given, chosen, language)
    except (Exception, KeyboardInterrupt) as error:
        if os.environ.get(TRACEBACK) and not isinstance(error, (*EXPECTED, KeyboardInterrupt)):
            traceback.print_exc()
        reason = message_of(error, f"gpr20 {' '.join(given)}")
    say(f"gpr20 {' '.join(given[:1])}: {shown(reason)}", file=sys.stderr)
    for step in first_steps(reason):
        say(shown(step), file=sys.stderr)
    if getattr(chosen, "json", False):
        print(json.dumps({"error": json_fields(reason)}))
    return REFUSED


def _run(given: List[str], chosen: argparse.Namespace, asked: Language) -> int:
    try:
        _parser(given).parse_args(given, chosen)
        language = Language.ENGLISH if chosen.command in command.ENGLISH else asked
        chosen.language = language.value
        status: int = chosen.run(chosen, read_catalogue(language))
        sys.stdout.flush()
        return status
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    except BrokenPipeError:
        # The reader, such as `head`, has closed the pipe: the rest must not be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return REFUSED


def _number(text: str) -> float:
    """Return the number of an option, also as people write it who have decimal commas."""
    return float(text if "." in text else text.replace(",", "."))


def _language(given: List[str]) -> Tuple[Language, List[str]]:
    """Return the language of the output, and the arguments without the option that sets it."""
    parser = argparse.ArgumentParser(
        prog="gpr20", parents=[_language_option()], add_help=False, allow_abbrev=False
    )
    chosen, others = parser.parse_known_args(given)
    if chosen.language is None:
        return language_from_environment(os.environ), others
    return language_from_code(chosen.language), others


def _language_option() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument(
        "--language",
        choices=[one.value for one in languages()],
        help="language of reports, figures and lists; default from the environment (LANG)",
    )
    return parser


def _parser(given: List[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gpr20",
        description="Offline analysis of GPR-20 surveys.",
        epilog=EXIT_STATUS,
        parents=[_language_option()],
    )
    parser.add_argument("--version", action="version", version=f"gpr20 {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", dest="command", required=True)
    # Other packages are looked for only for help and for a command that may be theirs.
    of_gpr20 = given and given[0] in command.SUMMARIES
    for name, text in (command.SUMMARIES if of_gpr20 else command.summaries()).items():
        summary = text.replace("%", "%%")
        # Help lists every command, but only the libraries of the chosen one are loaded.
        if given[:1] == [name]:
            chosen = command.load(name)
            own = commands.add_parser(
                name,
                help=summary,
                description=chosen.description,
                epilog=chosen.exit_status,
                parents=[_language_option()],
            )
            own.register("type", float, _number)
            chosen.add_arguments(own)
            own.set_defaults(run=chosen.run)
        else:
            commands.add_parser(name, help=summary)
    return parser


if __name__ == "__main__":
    sys.exit(main())
