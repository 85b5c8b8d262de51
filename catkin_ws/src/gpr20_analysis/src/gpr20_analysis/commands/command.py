"""What a subcommand of gpr20 is."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Callable

DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
EXIT_STATUS = (
    "exit status: 0 done, 1 survey intact but not complete, 2 survey damaged, 3 refused or failed; "
    "the message says why"
)


@dataclass(frozen=True)
class Command:
    """One subcommand; a module of this package holds it as COMMAND."""

    description: str
    """What it does, for its --help."""
    add_arguments: Callable[[argparse.ArgumentParser], None]
    """Declares its arguments."""
    run: Callable[[argparse.Namespace], int]
    """Does it and returns the exit status; errors of this project are raised."""
