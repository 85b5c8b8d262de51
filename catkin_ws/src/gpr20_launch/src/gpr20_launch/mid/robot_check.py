"""The one check of a whole robot: what is wrong or doubtful in its configuration."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator, List, Tuple

from gpr20_axis_driver.controller import check_controller
from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import Clock
from gpr20_common.low.data_folder import DEFAULT_FOLDER
from gpr20_common.message import Message
from gpr20_common.mid.extension import is_extension
from gpr20_common.terminal_text import printable
from gpr20_launch.mid.axis_checks import check_axes
from gpr20_launch.mid.launch_request import ROBOT, SERVER
from gpr20_launch.mid.pin_checks import check_pins
from gpr20_launch.mid.place_checks import ANALYZER_FILE, Use, check_place
from gpr20_launch.mid.problem import Problem
from gpr20_launch.mid.robot_files import AXES_FILE, Reading
from gpr20_survey.plan.sensors import SENSORS
from gpr20_vna_acquisition.mid.analyzers import make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline


@dataclass(frozen=True)
class BuiltRobot:
    """The robot as it is built, and the computer.

    Attributes:
        axes: File with its axes, whose travel is that of its description (URDF).
        message_field: Finds a field of the messages of a type that is installed here, such as
            data of std_msgs/Float64, and raises InvalidValueError if there is none.
    """

    axes: Path
    message_field: Callable[[str, str], object] = lambda _type, _field: None


def check_robot(use: Use, built: BuiltRobot) -> Tuple[Problem, ...]:
    """Return what is wrong with the configuration of a robot, and what is doubtful, gravest first.

    Nothing is started, and nothing written. Files that are not there mean the defaults.
    """
    found: List[Problem] = []
    try:
        found.extend(_check(use, built))
    except OSError as error:
        text = Message("{file}: {reason}", file=printable(use.folder), reason=os_reason(error))
        found.append(Problem(text.reporting_only(CONFIGURATION), str(use.folder)))
    return tuple(sorted(found, key=lambda one: not one.refuses))


def _check(use: Use, built: BuiltRobot) -> Iterator[Problem]:
    if use.folder.exists() and not use.folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
    if not use.folder.exists() and use.folder != Path(DEFAULT_FOLDER).expanduser():
        text = Message(
            "the folder {folder} does not exist: the defaults are used; correct config:=, or "
            "create it with robot_config create",
            folder=use.folder,
        )
        yield Problem(text.with_fault(CONFIGURATION).as_warning(), str(use.folder))
    reading = Reading(use.folder, built.axes)
    pins = tuple(check_pins(reading))
    shared = [use for one in pins for use in one.uses]
    for one in reading.problems:
        # The parameters of an axis refuse a pin with a second use in it, but not that of others.
        if not any(use.partition(" (")[0] == f"{AXES_FILE} {one.key}" for use in shared):
            yield one
    yield from pins
    yield from check_axes(use.folder / AXES_FILE, reading.axes(), reading.built)
    yield from check_place(reading, use)
    # What a class of others prints when it is imported is no part of this answer.
    with redirect_stdout(sys.stderr):
        yield from tuple(_extensions(reading, use, built))


def _extensions(reading: Reading, use: Use, built: BuiltRobot) -> Iterator[Problem]:
    """Find classes and message types that are not installed on the computer that needs them."""

    def missing(
        name: str, key: str, check: Callable[..., object], *given: object
    ) -> Iterator[Problem]:
        file = reading.folder / name
        try:
            check(*given)
        except Gpr20Error as error:
            text = Message(
                "{file}, {place}: {reason}; correct it, or install what it needs",
                file=printable(file),
                place=key,
                reason=error.message,
            )
            yield Problem(text.reporting_only(CONFIGURATION), str(file), key)

    for axis, own in reading.axes().items():
        if own.controller and use.real and use.part != SERVER:
            yield from missing(AXES_FILE, f"{axis}/controller", check_controller, own)
    if use.part == ROBOT:
        return
    vna = reading.record("vna_acquisition")
    if use.real and is_extension(vna.analyzer):
        deadline = RequestDeadline(Clock())
        yield from missing(ANALYZER_FILE, "analyzer", make_foreign_analyzer, vna, deadline)
    for number, one in enumerate(reading.record(SENSORS).sensors):
        key, field = f"{SENSORS}[{number}]", (one.message, one.field)
        yield from missing("sensors.yaml", key, built.message_field, *field)
