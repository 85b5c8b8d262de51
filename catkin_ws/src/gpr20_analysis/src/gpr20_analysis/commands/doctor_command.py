"""gpr20 doctor: find what is wrong with the robot and this computer."""

from __future__ import annotations

import argparse

from gpr20_analysis import faults
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import MissingLibraryError
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

STATUS = (
    "exit status: 0 nothing is wrong, 1 a warning or something unknown, 2 a fault, 3 the doctor "
    "itself could not work"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments, which are those of the doctor."""
    try:
        from gpr20_doctor.mid import arguments
    except ImportError as error:
        # Installed with pip, without the workspace.
        raise _needs_workspace(error) from error
    arguments.add_arguments(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Check everything and print it; return the exit status."""
    try:
        from gpr20_doctor.high import doctor
    except ImportError as error:
        raise _needs_workspace(error) from error
    return doctor.run(chosen, catalogue)


def _needs_workspace(error: ImportError) -> MissingLibraryError:
    return MissingLibraryError(
        Message(
            "the doctor needs ROS and the workspace; source catkin_ws/devel/setup.bash first",
            details=error,
        ),
        fault=faults.NO_ROS,
    )


COMMAND = Command(
    "Find what is wrong with the robot and this computer. Needs ROS and the workspace.",
    add_arguments,
    run,
    STATUS,
)
