"""The files of a robot's configuration: what each may hold, and how it is read."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict, Mapping, Set, Tuple, Type, TypeVar

from gpr20_common.errors import InvalidValueError
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Fault, Message
from gpr20_common.mid.records import record_from
from gpr20_common.os_reason import os_reason
from gpr20_height_sensor.mid.height_parameters import HeightParameters
from gpr20_launch import faults
from gpr20_launch.errors import ConfigurationError
from gpr20_main_control.mid.devices.described_robot import TimeLimits
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.sensors import SENSORS, Sensors
from gpr20_survey.plan.site import Site
from gpr20_survey.plan.survey_settings import SurveySettings
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

DEFAULT_FOLDER = "~/.gpr20/robot"
AXES_FILE = "axes.yaml"
Sections = Dict[str, Dict[str, Any]]
Record = TypeVar("Record")


@dataclass(frozen=True)
class RobotFile:
    """One file of the configuration.

    Attributes:
        title: What it is about, for the first line of its template.
        sections: Parts of the configuration whose keys it holds, and the class of each.
    """

    title: str
    sections: Tuple[Tuple[str, Type], ...]


FILES: Mapping[str, RobotFile] = {
    "height.yaml": RobotFile(
        "the height sensor of this robot", (("height_sensor", HeightParameters),)
    ),
    "analyzer.yaml": RobotFile(
        "the network analyzer (VNA) of this robot", (("vna_acquisition", VnaParameters),)
    ),
    "survey.yaml": RobotFile(
        "how surveys are carried out", (("survey", SurveySettings), ("time_limits", TimeLimits))
    ),
    "storage.yaml": RobotFile(
        "where and how surveys are stored", (("storage", ProcessingParameters),)
    ),
    "sensors.yaml": RobotFile(
        "other sensors beside the radar, whose values are stored with each trace",
        ((SENSORS, Sensors),),
    ),
    "site.yaml": RobotFile("this robot, its place and its operator", (("site", Site),)),
}
AXIS_SECTIONS = {axis_id.value: f"{axis_id.value}_axis" for axis_id in AxisId}


def read_configuration(folder: Path, built_axes: Path) -> Sections:
    """Return every section of a configuration; what a file leaves out has its default.

    Args:
        folder: The configuration's folder; files that do not exist are left out.
        built_axes: File with the axes of the robot as it is built.

    Raises:
        ConfigurationError: A file cannot be read, or has an unknown key or a value that is not
            allowed; the message names file, key, value and what is allowed.
    """
    _refuse_unknown_files(folder)
    sections: Sections = {}
    for name, file in FILES.items():
        sections.update(_sections(folder / name, file))
    sections.update(_axes(folder / AXES_FILE, built_axes))
    return sections


def _refuse_unknown_files(folder: Path) -> None:
    known = {AXES_FILE, *FILES}
    for path in sorted(folder.glob("*")):
        # Editors and file managers leave hidden files.
        is_yaml = path.suffix.lower() in (".yaml", ".yml") and not path.name.startswith(".")
        if is_yaml and path.name not in known:
            raise ConfigurationError(
                Message(
                    "{file} is not a file of a robot's configuration, and would not be read; "
                    "allowed: {known}",
                    file=path,
                    known=", ".join(sorted(known)),
                ),
                fault=faults.UNKNOWN_FILE,
            )


def _sections(path: Path, file: RobotFile) -> Sections:
    values = _read(path)
    names = {section: {one.name for one in fields(kind)} for section, kind in file.sections}
    known: Set[str] = set().union(*names.values())
    unknown = [key for key in values if key not in known]
    if unknown:
        raise _wrong(path, _unknown(repr(unknown[0]), known))
    found: Sections = {}
    for section, kind in file.sections:
        own = {key: value for key, value in values.items() if key in names[section]}
        _check(path, kind, own)
        found[section] = own
    return found


def _unknown(key: str, known: Set[str]) -> Message:
    allowed = ", ".join(sorted(known))
    options = ", ".join(sorted(one for one in known if one.endswith("_options")))
    if not options:
        return Message("{place} is unknown; allowed: {known}", place=key, known=allowed)
    return Message(
        "{place} is unknown; allowed: {known}; a setting of a class of another package belongs "
        "in {options}",
        place=key,
        known=allowed,
        options=options,
    )


def _axes(path: Path, built: Path) -> Sections:
    values, defaults = _read(path), _read(built)
    for key in values:
        if key not in AXIS_SECTIONS:
            known = ", ".join(AXIS_SECTIONS)
            message = Message("{place} is unknown; allowed: {known}", place=repr(key), known=known)
            raise _wrong(path, message)
    found: Sections = {}
    axes: Dict[str, AxisParameters] = {}
    for axis, section in AXIS_SECTIONS.items():
        own = values.get(axis) or {}
        if not isinstance(own, dict):
            raise _wrong(
                path,
                Message(
                    "{place} is {value}; it must be a group of values", place=axis, value=repr(own)
                ),
            )
        found[section] = {**defaults[axis], **own}
        axes[axis] = _check(path, AxisParameters, found[section], axis)
    _refuse_shared_pins(path, axes)
    return found


def _refuse_shared_pins(path: Path, axes: Mapping[str, AxisParameters]) -> None:
    """Refuse a pin of two axes, unless it enables the motor drivers of both."""
    users: Dict[int, Tuple[str, Set[str]]] = {}
    for axis, parameters in axes.items():
        # Another controller uses no pins.
        pins = {} if parameters.controller else parameters.pins
        for name, pin in pins.items():
            use = f"{name} {parameters.enable_active}" if name == "enable_pin" else f"{axis} {name}"
            first, uses = users.setdefault(pin, (f"{axis}/{name}", set()))
            uses.add(use)
            if len(uses) > 1:
                raise _wrong(
                    path,
                    Message(
                        "{first} and {second} both use pin {pin}; give each a pin of its own: axes "
                        "can share only {shared}, with the same {level}",
                        first=first,
                        second=f"{axis}/{name}",
                        pin=pin,
                        shared="enable_pin",
                        level="enable_active",
                    ),
                )


def _check(path: Path, kind: Type[Record], values: Mapping[str, Any], place: str = "") -> Record:
    try:
        return record_from(kind, values, place)
    except InvalidValueError as error:
        raise _wrong(path, error.message, place) from error


def _read(path: Path) -> Dict[Any, Any]:
    try:
        values = read_yaml(path)
    except FileNotFoundError as error:
        if _is_broken_link(path) or _is_broken_link(path.parent):
            raise _wrong(path, os_reason(error), fault=faults.UNREADABLE) from error
        return {}
    except OSError as error:
        raise _wrong(path, os_reason(error), fault=faults.UNREADABLE) from error
    except YamlFileError as error:
        raise _wrong(path, error.message) from error
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise _wrong(path, Message("it must be lines of the form {example}", example="key: value"))
    return values


def _is_broken_link(path: Path) -> bool:
    """Return whether a link leads nowhere, such as to a medium that is not there."""
    return path.is_symlink() and not path.exists()


def _wrong(
    path: Path, reason: Message, place: str = "", fault: Fault = faults.WRONG_VALUE
) -> ConfigurationError:
    if place:
        return ConfigurationError(
            Message("{file}, {place}: {reason}", file=path, place=place, reason=reason), fault
        )
    return ConfigurationError(Message("{file}: {reason}", file=path, reason=reason), fault)
