"""The command gpr20."""

from __future__ import annotations

import argparse
import sys
from typing import List, Optional

from gpr20_analysis import __version__
from gpr20_analysis.commands import registry
from gpr20_analysis.commands.command import EXIT_STATUS, REFUSED
from gpr20_common.errors import Gpr20Error


def main(arguments: Optional[List[str]] = None) -> int:
    """Run the subcommand that is named; return the exit status."""
    given = sys.argv[1:] if arguments is None else arguments
    try:
        chosen = _parser(given).parse_args(given)
        return chosen.run(chosen)
    except SystemExit as ending:
        return REFUSED if ending.code else 0
    except (Gpr20Error, OSError) as error:
        print(f"gpr20 {given[0]}: {error}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print(f"gpr20 {given[0]}: interrupted", file=sys.stderr)
        return REFUSED


def _parser(given: List[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gpr20", description="Offline analysis of GPR-20 surveys.", epilog=EXIT_STATUS
    )
    parser.add_argument("--version", action="version", version=f"gpr20 {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", dest="command", required=True)
    for name, summary in registry.SUMMARIES.items():
        # Help lists every command, but only the chosen one's libraries are loaded.
        if given[:1] == [name]:
            command = registry.load(name)
            own = commands.add_parser(
                name, help=summary, description=command.description, epilog=EXIT_STATUS
            )
            command.add_arguments(own)
            own.set_defaults(run=command.run)
        else:
            commands.add_parser(name, help=summary)
    return parser


if __name__ == "__main__":
    sys.exit(main())
