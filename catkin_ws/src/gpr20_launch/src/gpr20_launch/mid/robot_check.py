"""The one check of a whole robot: what is wrong or doubtful in its configuration."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator, List, Mapping, Optional, Tuple

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_launch import faults
from gpr20_launch.mid.axis_checks import DescriptionError, Frame, check_axes, read_frame
from gpr20_launch.mid.pin_checks import check_pins, is_pin
from gpr20_launch.mid.place_checks import Use, check_place
from gpr20_launch.mid.problem import Problem
from gpr20_launch.mid.robot_files import AXES_FILE, DEFAULT_FOLDER, read_files


@dataclass(frozen=True)
class BuiltRobot:
    """The robot as it is built.

    Attributes:
        axes: File with its axes.
        urdf: Its description; None: not known.
    """

    axes: Path
    urdf: Optional[Path] = None


def check_robot(
    folder: Path,
    built: BuiltRobot,
    environment: Mapping[str, str],
    data: str = "",
    real: bool = True,
    stores: bool = True,
) -> Tuple[Problem, ...]:
    """Return what is wrong with the configuration of a robot, and what is doubtful, gravest first.

    Nothing is started, and nothing written.

    Args:
        folder: Folder of the configuration; files that are not there mean the defaults.
        built: The robot as it is built.
        environment: The environment variables, with those of the services.
        data: Folder of the surveys that a launch is given; empty: as configured.
        real: Whether the real robot is to use it.
        stores: Whether surveys are stored on this computer.
    """
    use = Use(folder, environment, data, real, stores)
    found: List[Problem] = []
    try:
        found.extend(_check(use, built))
    except OSError as error:
        text = Message("{file}: {reason}", file=printable(folder), reason=os_reason(error))
        found.append(Problem(text.with_fault(faults.UNREADABLE), str(folder)))
    return tuple(sorted(found, key=lambda one: not one.refuses))


def _check(use: Use, built: BuiltRobot) -> Iterator[Problem]:
    frame: Optional[Frame] = None
    if built.urdf is not None:
        try:
            frame = read_frame(built.urdf)
        except DescriptionError as error:
            yield Problem(error.message.as_warning(), str(built.urdf))
    if use.folder.exists() and not use.folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
    if not use.folder.exists() and use.folder != Path(DEFAULT_FOLDER).expanduser():
        text = Message(
            "the folder {folder} does not exist: the defaults are used", folder=use.folder
        )
        yield Problem(text.with_fault(faults.NO_FOLDER).as_warning(), str(use.folder))
    reading = read_files(use.folder, built.axes)
    pins = tuple(check_pins(reading))
    for one in reading.problems:
        # A pin that exists is refused for a second use in its axis, which has a problem of its own.
        axis, _slash, key = one.key.partition("/")
        if not is_pin(key, reading.raw_axes.get(axis, {}).get(key)):
            yield one
    yield from pins
    yield from check_axes(use.folder / AXES_FILE, reading.axes(), frame)
    yield from check_place(reading, use)
