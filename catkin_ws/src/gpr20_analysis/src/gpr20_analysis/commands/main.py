"""The command gpr20."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import traceback
from typing import List, Optional

from gpr20_analysis import __version__
from gpr20_analysis.commands import command
from gpr20_analysis.commands.command import EXIT_STATUS, REFUSED
from gpr20_common.errors import Gpr20Error

EXTRAS = {"matplotlib": "plots"}
"""Libraries that whole commands are made of, and the extra that brings each."""
TRACEBACK = "GPR20_TRACEBACK"
"""Environment variable: if set, an error that is a fault of the program shows where it arose."""


def main(arguments: Optional[List[str]] = None) -> int:
    """Run the subcommand that is named; return the exit status."""
    given = sys.argv[1:] if arguments is None else arguments
    if arguments is None:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # it cleans up like Ctrl-C
    try:
        chosen = _parser(given).parse_args(given)
        status: int = chosen.run(chosen)
        sys.stdout.flush()
        return status
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    except BrokenPipeError:
        # Who read it, such as `head`, has enough; the interpreter must not try to write the rest.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return REFUSED
    except (Gpr20Error, OSError, MemoryError) as error:
        return _refused(given, _told(error))
    except ModuleNotFoundError as error:
        return _refused(given, _missing(error))
    except KeyboardInterrupt:
        return _refused(given, "interrupted; nothing half written is left")
    except Exception as error:
        if os.environ.get(TRACEBACK):
            traceback.print_exc()
        return _refused(
            given,
            f"failed by a fault of the program itself ({type(error).__name__}: {error}); please "
            f"report it with what {TRACEBACK}=1 gpr20 {' '.join(given)} prints",
        )


def _refused(given: List[str], reason: str) -> int:
    print(f"gpr20 {' '.join(given[:1])}: {reason}", file=sys.stderr)
    return REFUSED


def _missing(error: ModuleNotFoundError) -> str:
    extra = EXTRAS.get((error.name or "").split(".")[0])
    wanted = f"gpr20_analysis[{extra}]" if extra else "gpr20_analysis"
    return f"{error.name} is not installed: pip install '{wanted}'"


def _told(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return f"the memory does not suffice ({error or 'no more is known'}); use fewer samples"
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.filename}: {error.strerror}"
    return str(error)


def _parser(given: List[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gpr20", description="Offline analysis of GPR-20 surveys.", epilog=EXIT_STATUS
    )
    parser.add_argument("--version", action="version", version=f"gpr20 {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", dest="command", required=True)
    for name, summary in command.SUMMARIES.items():
        # Help lists every command, but only the chosen one's libraries are loaded.
        if given[:1] == [name]:
            chosen = command.load(name)
            own = commands.add_parser(
                name, help=summary, description=chosen.description, epilog=EXIT_STATUS
            )
            chosen.add_arguments(own)
            own.set_defaults(run=chosen.run)
        else:
            commands.add_parser(name, help=summary)
    return parser


if __name__ == "__main__":
    sys.exit(main())
