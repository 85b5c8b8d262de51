"""The command gpr20."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import traceback
from typing import List, Optional, Tuple

from gpr20_analysis import __version__
from gpr20_analysis.commands import command
from gpr20_analysis.commands.command import EXIT_STATUS, REFUSED
from gpr20_analysis.errors import library_missing
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import (
    Catalogue,
    Language,
)
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.catalogue_file import (
    language_from_code,
    language_from_environment,
    languages,
    read_catalogue,
)
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey.errors import printable

EXTRAS = {"matplotlib": "plots"}
"""Optional libraries that whole commands need, and the extra of each."""
EXPECTED = (Gpr20Error, OSError, MemoryError, ModuleNotFoundError)
"""Errors whose message is sufficient; all others are program errors."""
TRACEBACK = "GPR20_TRACEBACK"
"""Environment variable: if set, a program error prints its traceback."""


def main(arguments: Optional[List[str]] = None) -> int:
    """Run a subcommand; return the exit status."""
    given = sys.argv[1:] if arguments is None else arguments
    if arguments is None:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # it cleans up like Ctrl-C
    try:
        language, given = _language(given)
        catalogue = read_catalogue(language)
    except SystemExit:
        return REFUSED
    try:
        return _run(given, language, catalogue)
    except KeyboardInterrupt:
        reason = Message("interrupted; no partial output is left")
    except Exception as error:
        if os.environ.get(TRACEBACK) and not isinstance(error, EXPECTED):
            traceback.print_exc()
        reason = _reason(error, given)
    print(f"gpr20 {' '.join(given[:1])}: {printable(shown(reason, catalogue))}", file=sys.stderr)
    return REFUSED


def _run(given: List[str], language: Language, catalogue: Catalogue) -> int:
    try:
        chosen = _parser(given).parse_args(given)
        chosen.language = language.value
        status: int = chosen.run(chosen, catalogue)
        sys.stdout.flush()
        return status
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    except BrokenPipeError:
        # The reader, such as `head`, has closed the pipe: the rest must not be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return REFUSED


def _reason(error: Exception, given: List[str]) -> Message:
    if isinstance(error, Gpr20Error):
        return error.message
    if isinstance(error, ModuleNotFoundError):
        name = error.name or ""
        return library_missing(name, EXTRAS.get(name.split(".")[0], ""))
    if isinstance(error, MemoryError):
        return Message("not enough memory; use fewer samples", details=error)
    if isinstance(error, OSError) and error.filename:
        return Message("{file}: {reason}", file=error.filename, reason=os_reason(error))
    if isinstance(error, OSError):
        return os_reason(error)
    return Message(
        "program error {error}; please report it with the output of {command}",
        error=f"{type(error).__name__}: {error}",
        command=f"{TRACEBACK}=1 gpr20 {' '.join(given)}",
    )


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
        help="language of messages, reports and figures; default from the environment (LANG)",
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
    for name, summary in command.SUMMARIES.items():
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
            chosen.add_arguments(own)
            own.set_defaults(run=chosen.run)
        else:
            commands.add_parser(name, help=summary)
    return parser


if __name__ == "__main__":
    sys.exit(main())
