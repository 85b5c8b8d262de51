"""The command gpr20."""

from __future__ import annotations

import argparse
import gc
import json
import os
import signal
import sys
import traceback
from typing import List, Optional

from gpr20_analysis import __version__
from gpr20_analysis.commands import command
from gpr20_analysis.commands.command import REFUSED
from gpr20_analysis.sentences import (
    EXPECTED,
    TRACEBACK,
    first_steps,
    json_fields,
    message_of,
    shown,
)
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
        gc.disable()  # until all is imported
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a second one spins
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # it cleans up like Ctrl-C
    chosen = argparse.Namespace(call=[""])
    try:
        return _run(given, chosen)
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    except BrokenPipeError:
        # The reader, such as `head`, has closed the pipe: the rest must not be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return REFUSED
    except (Exception, KeyboardInterrupt) as error:
        if os.environ.get(TRACEBACK) and not isinstance(error, (*EXPECTED, KeyboardInterrupt)):
            traceback.print_exc()
        reason = message_of(error, f"gpr20 {' '.join(given)}")
    say(f"gpr20 {chosen.call[0]}: {shown(reason)}", file=sys.stderr)
    for step in first_steps(reason):
        say(shown(step), file=sys.stderr)
    if "--json" in given:
        print(json.dumps({"error": json_fields(reason)}))  # noqa: T201
    return REFUSED


def _run(given: List[str], chosen: argparse.Namespace) -> int:
    first = _Parser(
        prog="gpr20",
        description="Offline analysis of GPR-20 surveys.",
        epilog=command.EXIT_STATUS,
    )
    first.add_argument("--version", action="version", version=f"gpr20 {__version__}")
    first.add_argument(
        "call", nargs=argparse.PARSER, metavar="COMMAND", help="and its arguments, see below"
    )
    _add_language(first)
    first.parse_args(given, chosen)
    name, *others = chosen.call
    called = command.load(name)
    parser = command.parser_of(name, called)
    _add_language(parser)
    parser.parse_args(others, chosen)
    if not gc.isenabled():
        gc.freeze()  # what is imported is never garbage; looking through it takes 0.2 s
        gc.enable()
    asked = (
        language_from_code(chosen.language)
        if hasattr(chosen, "language")
        else language_from_environment(os.environ)
    )
    language = Language.ENGLISH if name in command.ENGLISH else asked
    chosen.language = language.value
    status = called.run(chosen, read_catalogue(language))
    sys.stdout.flush()
    return status


class _Parser(argparse.ArgumentParser):
    """Lists the commands in its help, and only there looks for those of other packages."""

    def format_help(self) -> str:
        rows = [f"  {name:12}{summary}\n" for name, summary in command.summaries().items()]
        return "".join([super().format_help(), "\ncommands:\n", *rows])


def _add_language(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--language",
        choices=[one.value for one in languages()],
        default=argparse.SUPPRESS,
        help="language of reports, figures and lists; default from the environment (LANG)",
    )


if __name__ == "__main__":
    sys.exit(main())
