"""The files of a robot's configuration: what each may hold, how it is read, what is wrong."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict, Iterable, List, Literal, Mapping, NamedTuple, Set, Tuple, Type, Union

from gpr20_common.errors import os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Fault, Message, Severity
from gpr20_common.mid.codec import mistakes, record_from
from gpr20_common.terminal_text import printable
from gpr20_height_sensor.height_driver import HeightParameters
from gpr20_survey.axes import BOARD_PINS, AxisId, AxisParameters
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import SENSORS, Sensors
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters
from gpr20_web.mid.web_parameters import WebParameters

AXES_FILE = "axes.yaml"
REAL = "gpr20"
ROBOTS = ("simulated", REAL)
# What runs on this computer.
PARTS = ROBOT, SERVER, SURVEY = ("robot", "server", "survey")
Sections = Dict[str, Dict[str, Any]]


# What is checked with everything off; and with the robot running, at the first power-up.
Before = Literal["unread", "pins", "z_direction_or_step", "endstop_levels", "no_5_v"]
WithRobot = Literal["emergency_stop", "directions", "travel"]


@dataclass(frozen=True)
class Wiring:
    """What a person must still check on this robot.

    Attributes:
        unchecked: Delete each word when a person has checked it, as
            docs/coming_from_the_original.md describes. With unread, pins, z_direction_or_step,
            no_5_v or endstop_levels in the list the robot is not launched; with emergency_stop,
            directions or travel it warns.
    """

    unchecked: Union[Tuple[Literal[Before, WithRobot], ...], None] = ()


# The keys of each file are those of these sections of the configuration.
FILES: Mapping[str, Mapping[str, Type]] = {
    "height.yaml": {"height_sensor": HeightParameters},
    "analyzer.yaml": {"vna_acquisition": VnaParameters},
    "survey.yaml": {"survey": SurveySettings},
    "storage.yaml": {"storage": ProcessingParameters},
    "sensors.yaml": {SENSORS: Sensors},
    "site.yaml": {"site": Site},
    "web.yaml": {"web": WebParameters},
    "wiring.yaml": {"wiring": Wiring},
}
AXIS_SECTIONS = {axis_id.value: f"{axis_id.value}_axis" for axis_id in AxisId}
KINDS: Dict[str, Type] = dict.fromkeys(AXIS_SECTIONS.values(), AxisParameters)
KINDS.update((section, kind) for file in FILES.values() for section, kind in file.items())
# Between these keys there is a relation: the first one that the file has is named.
RELATED: Mapping[str, Tuple[str, ...]] = {
    "min_step": ("max_step",),
    "max_coord": ("min_coord", "step_size"),
    "late_limit_s": ("min_step",),
    "gap_limit_s": ("late_limit_s",),
    "homing_backoff": ("sensor_pin", "step_size"),
    "max_frequency_hz": ("min_frequency_hz",),
    "min_level_db": ("max_level_db",),
    "min_distance_m": ("max_distance_m",),
}


@dataclass(frozen=True)
class Problem:
    """One mistake, or something doubtful, in the configuration of a robot.

    Attributes:
        message: All of it as one sentence, with its fault.
        file: The file; empty: a setting of the computer.
        key: The key in it, such as y/sensor_pin; empty: the whole file.
        value: Its value as Python shows it.
    """

    message: Message
    file: str = ""
    key: str = ""
    value: str = ""

    @property
    def refuses(self) -> bool:
        """Whether the robot must not be launched; otherwise it is doubtful."""
        return self.message.severity in (None, Severity.FAULT)

    def record(self) -> Dict[str, Any]:
        """Return the sentence as it travels, and the place beside it."""
        return {**self.message.record(), "file": self.file, "key": self.key, "value": self.value}


def problem(
    file: Union[Path, str],
    key: str,
    value: object,
    reason: object,
    allowed: object,
    doubtful: bool = False,
    fault: Fault = CONFIGURATION,
) -> Problem:
    """Return a problem of one value; a doubtful one may be right on some robot."""
    place = f"{printable(str(file))}: {key} is {printable(str(value))}"
    text = Message(
        "{place}: {reason}; allowed: {allowed}", place=place, reason=reason, allowed=allowed
    )
    fault = fault.as_warning() if doubtful else fault
    return Problem(text.reporting_only(fault), str(file), key, str(value))


class Use(NamedTuple):
    """How a configuration is used: variables, data:= of the launch, real robot or not, and part."""

    environment: Mapping[str, str]
    data: str = ""
    real: bool = True
    part: str = SURVEY


class Reading:
    """What the files of a configuration hold, and what is wrong with them.

    Attributes:
        folder: Their folder.
        built: The axes of the robot as it is built: the defaults.
        sections: Every section as the nodes get it, with the values that are wrong.
        problems: These values, and files that cannot be read.
        given: The keys that each file names, such as x/dir_pin of axes.yaml.
        unsure: The sections with a mistake, so that their defaults say nothing of the robot.
    """

    def __init__(self, folder: Path, built_axes: Path) -> None:
        """Read the files that are there."""
        self.folder = folder
        self.built: Mapping[str, Mapping[str, Any]] = read_yaml(built_axes)
        self.sections: Sections = {}
        self.problems: List[Problem] = []
        self.given: Set[Tuple[str, str]] = set()
        self.unsure: Set[str] = set()
        try:
            self._refuse_unknown_files(sorted(folder.iterdir()))
        except FileNotFoundError:
            pass
        except OSError as error:
            self._wrong(folder, os_reason(error))
        for name, sections in FILES.items():
            self._read_sections(folder / name, sections)
        self._read_axes(folder / AXES_FILE)

    def record(self, section: str) -> Any:
        """Return the parameters of a section; the defaults if something is wrong with them."""
        values = {} if section in self.unsure else self.sections[section]
        return record_from(KINDS[section], values, section)

    def axes(self) -> Dict[str, AxisParameters]:
        """Return the axes with which nothing is wrong."""
        known = {axis: one for axis, one in AXIS_SECTIONS.items() if one not in self.unsure}
        return {axis: self.record(section) for axis, section in known.items()}

    def _refuse_unknown_files(self, entries: Iterable[Path]) -> None:
        known = {AXES_FILE, *FILES}
        for path in entries:
            # Editors and file managers leave hidden files.
            is_yaml = path.suffix.lower() in (".yaml", ".yml") and not path.name.startswith(".")
            if is_yaml and path.name not in known:
                reason = "it is not a file of a robot's configuration, and would not be read; "
                reason += "rename it, or move it to another folder; allowed: "
                self._wrong(path, reason + ", ".join(sorted(known)))

    def _read_sections(self, path: Path, sections: Mapping[str, Type]) -> None:
        values, wrong = self._content(path)
        names = {section: {one.name for one in fields(kind)} for section, kind in sections.items()}
        wrong |= self._refuse_unknown_keys(path, values, set().union(*names.values()))
        for section in sections:
            own = {key: value for key, value in values.items() if key in names[section]}
            self._read(path, section, own, own, wrong)

    def _read_axes(self, path: Path) -> None:
        values, wrong = self._content(path)
        names = {one.name for one in fields(AxisParameters)}
        self._refuse_unknown_keys(path, values, set(AXIS_SECTIONS))
        for axis, section in AXIS_SECTIONS.items():
            own, mistaken = values.get(axis), wrong
            own = {} if own is None else own
            if not isinstance(own, dict):
                reason = f"{axis} is {own!r}; it must be a group of values, with a space behind "
                self._wrong(path, reason + "each colon", axis, own)
                own, mistaken = {}, True
            mistaken |= self._refuse_unknown_keys(path, own, names, f"{axis}/")
            self._read(path, section, own, {**self.built[axis], **own}, mistaken, axis)

    def _content(self, path: Path) -> Tuple[Dict[Any, Any], bool]:
        """Return the lines of a file, and whether they cannot be read."""
        if any(one.file == str(self.folder) for one in self.problems):
            return {}, True
        try:
            values = read_yaml(path)
            if values is None or isinstance(values, dict):
                return values or {}, False
            self._wrong(path, "it must be lines of the form key: value")
        except OSError as error:
            # A link that leads nowhere, such as to a medium that is not there, is no default.
            links = any(one.is_symlink() and not one.exists() for one in (path, path.parent))
            if not links and isinstance(error, FileNotFoundError):
                return {}, False
            self._wrong(path, os_reason(error))
        except YamlFileError as error:
            self._wrong(path, error.message)
        return {}, True

    def _refuse_unknown_keys(
        self, path: Path, values: Dict[Any, Any], known: Set[str], below: str = ""
    ) -> bool:
        """Remove the keys that are unknown; return whether there were any."""
        unknown = [one for one in values if one not in known]
        for key in unknown:
            before = ([""] + list(values))[list(values).index(key)]
            value = values.pop(key)
            if value is None and str(key).isdigit() and type(values.get(before)) is int:
                # Between braces 0,01 is the number 0 and a key 01.
                place, number = f"{below}{before}", f"{values.pop(before)},{key}"
                reason = f"{place} is {number!r}; write a point, not a comma"
                self._wrong(path, reason, place, number)
                continue
            place = f"{below}{key}" if below else repr(key)
            reason = f"{place} is unknown; allowed: {', '.join(sorted(known))}"
            self._wrong(path, reason, f"{below}{key}", value)
        self.given.update((path.name, f"{below}{key}") for key in values)
        return bool(unknown)

    def _read(
        self,
        path: Path,
        section: str,
        own: Mapping[str, Any],
        every: Dict[str, Any],
        wrong: bool,
        axis: str = "",
    ) -> None:
        """Keep the values of a section; find what is wrong with each, then with them together."""
        self.sections[section] = every
        found = mistakes(KINDS[section], every, axis)
        if wrong or found:
            self.unsure.add(section)
        below = f"{axis}/" if axis else ""
        for key, error in found.items():
            related: List[str] = []
            if not key and (wrong or (axis and _has_wrong_pins(every))):
                continue
            if not key:
                names = (error.values.get(one) for one in ("name", "place", "key"))
                named = next((str(one) for one in names if one), "")
                keys = [named, *RELATED.get(named, ())]
                key = next((one for one in keys if one in own), "")
                # Its value the error says already.
                related = [
                    f"{one} is {own[one]!r}" if one in own else f"{one} has its default"
                    for one in (keys if key else ())
                    if one != named or one not in own
                ]
                error = Message("{name}: {state}", name=axis, state=error) if axis else error
            place = f"{below}{key}" if key else axis
            self._wrong(path, error, place, own.get(key), "; ".join(related))

    def _wrong(
        self, path: Path, reason: object, key: str = "", value: Any = None, related: str = ""
    ) -> None:
        said = Message("{reason}; {hint}", reason=reason, hint=related) if related else reason
        text = Message("{file}: {reason}", file=path, reason=said).reporting_only(CONFIGURATION)
        self.problems.append(Problem(text, str(path), key, "" if value is None else repr(value)))


def _has_wrong_pins(values: Mapping[str, Any]) -> bool:
    """Return whether the check of all pins finds what is wrong in an axis."""
    pins = [pin for key, pin in values.items() if key.endswith("_pin") and pin is not None]
    return not values.get("controller") and (
        not BOARD_PINS.issuperset(pins) or len(set(pins)) < len(pins)
    )
