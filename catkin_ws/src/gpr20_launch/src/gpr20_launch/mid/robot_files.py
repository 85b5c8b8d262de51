"""The files of a robot's configuration: what each may hold, and how it is read."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Dict, List, Mapping, Set, Tuple, Type

from gpr20_common.errors import os_reason
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_height_sensor.mid.height_driver import HeightParameters
from gpr20_launch.errors import ConfigurationError
from gpr20_launch.mid import hints
from gpr20_launch.mid.axis_checks import impossible_values
from gpr20_launch.mid.pin_table import GPIO_OF_BOARD
from gpr20_launch.mid.problem import Problem
from gpr20_launch.mid.wiring import Wiring
from gpr20_main_control.mid.devices.described_robot import TimeLimits
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.sensors import SENSORS, Sensors
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters
from gpr20_web.mid.web_parameters import WebParameters

AXES_FILE = "axes.yaml"
Sections = Dict[str, Dict[str, Any]]
NOTHING: Mapping[str, Any] = MappingProxyType({})


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
    "web.yaml": RobotFile(
        "the page that shows this robot to browsers, with web:=true", (("web", WebParameters),)
    ),
    "wiring.yaml": RobotFile("what a person must still check on this robot", (("wiring", Wiring),)),
}
AXIS_SECTIONS = {axis_id.value: f"{axis_id.value}_axis" for axis_id in AxisId}


class Reading:
    """What the files of a configuration hold, and what is wrong with them.

    Attributes:
        folder: Their folder.
        built: The axes of the robot as it is built: the defaults.
        sections: Every section, without the values that are not allowed.
        problems: These values, and files that cannot be read.
        given: The keys that the files name, such as axes.yaml x/dir_pin.
        unsure: Keys whose value was refused or misspelt, so that the default says nothing about
            the robot; without a key: all of the file.
        raw_axes: The values of each axis with the defaults, also those that are not allowed.
    """

    def __init__(self, folder: Path, built_axes: Path) -> None:
        """Read the files that are there.

        Raises:
            OSError: The folder cannot be read.
        """
        self.folder = folder
        self.built: Mapping[str, Mapping[str, Any]] = read_yaml(built_axes)
        self.sections: Sections = {}
        self.problems: List[Problem] = []
        self.given: Set[Tuple[str, str]] = set()
        self.unsure: Set[Tuple[str, str]] = set()
        self.raw_axes: Dict[str, Mapping[str, Any]] = {}
        self._refuse_unknown_files()
        for name, file in FILES.items():
            self._read_sections(folder / name, file)
        self._read_axes(folder / AXES_FILE)

    def record(self, section: str) -> Any:
        """Return the parameters of a section."""
        kinds = dict(one for file in FILES.values() for one in file.sections)
        return record_from(kinds.get(section, AxisParameters), self.sections[section], section)

    def knows(self, file: str, *keys: str) -> bool:
        """Return whether the robot has the values of these keys, or the defaults."""
        wanted = {"", *keys, *(key.partition("/")[0] for key in keys)}
        return not self.unsure & {(file, key) for key in wanted}

    def axes(self) -> Dict[str, AxisParameters]:
        """Return the axes whose values, but for the pins, are known."""
        found = {}
        for axis, section in AXIS_SECTIONS.items():
            keys = [f"{axis}/{one.name}" for one in fields(AxisParameters)]
            if self.knows(AXES_FILE, *(key for key in keys if not key.endswith("_pin"))):
                found[axis] = self.record(section)
        return found

    def _refuse_unknown_files(self) -> None:
        known = ", ".join(sorted({AXES_FILE, *FILES}))
        for path in sorted(self.folder.glob("*")):
            # Editors and file managers leave hidden files.
            is_yaml = path.suffix.lower() in (".yaml", ".yml") and not path.name.startswith(".")
            if is_yaml and path.name not in {AXES_FILE, *FILES}:
                text = Message(
                    "{file} is not a file of a robot's configuration, and would not be read; "
                    "rename it, or move it to another folder; allowed: {known}",
                    file=path,
                    known=known,
                )
                unknown = text.with_fault(CONFIGURATION)
                self.problems.append(Problem(unknown, str(path), allowed=known))

    def _read_sections(self, path: Path, file: RobotFile) -> None:
        values = self._content(path)
        names = {section: {one.name for one in fields(kind)} for section, kind in file.sections}
        self._refuse_unknown_keys(path, values, set().union(*names.values()))
        for section, kind in file.sections:
            own = {key: value for key, value in values.items() if key in names[section]}
            self.sections[section] = self._allowed(path, kind, own)

    def _read_axes(self, path: Path) -> None:
        values = self._content(path)
        self._refuse_unknown_keys(path, values, set(AXIS_SECTIONS))
        names = {one.name for one in fields(AxisParameters)}
        for axis, section in AXIS_SECTIONS.items():
            own = values.get(axis) or {}
            if not isinstance(own, dict):
                reason = Message(
                    "{place} is {value}; it must be a group of values", place=axis, value=repr(own)
                )
                hint = hints.hint_for_value(axis, own, reason) or hints.hint_for_text(path)
                self._wrong(path, hints.with_hint(reason, hint), axis, own)
                own = {}
            own = dict(own)
            self._refuse_unknown_keys(path, own, names, f"{axis}/")
            base = self.built[axis]
            every = {**base, **own}
            known = [key for key in every if self.knows(path.name, f"{axis}/{key}")]
            raw = self.raw_axes[axis] = {key: every[key] for key in known}
            for one in impossible_values(path, axis, raw):
                self.problems.append(one)
                self.unsure.add((path.name, one.key))
                own.pop(one.key.partition("/")[2], None)
            pins = [raw[key] for key in known if key.endswith("_pin")]
            for key in [one for one in own if one.endswith("_pin") and type(own[one]) is int]:
                if own[key] in GPIO_OF_BOARD and pins.count(own[key]) > 1:
                    twice = f"{key} {own[key]}"
                    reason = Message("{pins}: all pins must be different", pins=twice)
                    self._wrong(path, reason, f"{axis}/{key}", own.pop(key), place=axis)
            own = self._allowed(path, AxisParameters, own, axis, base)
            self.sections[section] = {**base, **own}

    def _content(self, path: Path) -> Dict[Any, Any]:
        try:
            values = read_yaml(path)
        except OSError as error:
            # A link that leads nowhere, such as to a medium that is not there, is no default.
            links = any(one.is_symlink() and not one.exists() for one in (path, path.parent))
            if links or not isinstance(error, FileNotFoundError):
                self._wrong(path, os_reason(error))
            return {}
        except YamlFileError as error:
            self._wrong(path, hints.with_hint(error.message, hints.hint_for_text(path)))
            return {}
        if values is not None and not isinstance(values, dict):
            reason = Message("it must be lines of the form {example}", example="key: value")
            self._wrong(path, hints.with_hint(reason, hints.hint_for_text(path)))
        return values if isinstance(values, dict) else {}

    def _refuse_unknown_keys(
        self, path: Path, values: Dict[Any, Any], known: Set[str], below: str = ""
    ) -> None:
        """Remove the keys that are unknown."""
        for key in [one for one in values if one not in known]:
            self._refuse_comma(path, values, key, below)
            if key not in values:
                continue
            value = values.pop(key)
            place = f"{below}{key}" if below else repr(key)
            allowed = ", ".join(sorted(known))
            reason = Message("{place} is unknown; allowed: {known}", place=place, known=allowed)
            options = ", ".join(one for one in sorted(known) if one.endswith("_options"))
            if options:
                text = Message("settings of another class belong in {options}", options=options)
                reason = hints.with_hint(reason, text)
            reason = hints.with_hint(reason, hints.hint_for_key(key, known))
            self._wrong(path, reason, f"{below}{key}", value, allowed)
            meant = hints.nearest(key, known)
            if meant is not None and meant not in values:
                self.unsure.add((path.name, f"{below}{meant}"))
        self.given.update((path.name, f"{below}{key}") for key in values)

    def _refuse_comma(self, path: Path, values: Dict[Any, Any], key: Any, below: str) -> None:
        """Remove both halves of a number such as 0,01 between braces, where 01 is another key."""
        names = list(values)
        before = names[max(0, names.index(key) - 1)]
        if values[key] is None and str(key).isdigit() and type(values[before]) is int:
            number = f"{values.pop(before)},{key}"
            del values[key]
            place = f"{below}{before}"
            reason = Message("{place} is {value}", place=place, value=repr(number))
            hint = hints.hint_for_value("", number, reason)
            self._wrong(path, hints.with_hint(reason, hint), place, number)

    def _allowed(
        self,
        path: Path,
        kind: Type,
        own: Dict[str, Any],
        place: str = "",
        base: Mapping[str, Any] = NOTHING,
    ) -> Dict[str, Any]:
        """Return the values without those that are not allowed, alone or together."""
        below = f"{place}/" if place else ""
        names = [one.name for one in fields(kind)]
        while True:
            unsure = [one for one in names if (path.name, f"{below}{one}") in self.unsure]
            # What is only wrong without them is no mistake of its own.
            for one in {two for key in unsure for two in hints.TOGETHER.get(key, ())} & set(own):
                del own[one]
            error = hints.refusal(kind, {**base, **own}, place)
            if error is None:
                return own
            key = hints.culprit(kind, own, place, base, error)
            value = own.get(key)
            alone = {key: value} if key else {}
            if not any(hints.follows(kind, one, place, base, unsure) for one in (own, alone)):
                reason = hints.with_hint(error, hints.hint_for_value(key, value, error))
                absent = [one for one in names if one not in own] if key else []
                for one in (one for one in absent if hints.follows(kind, own, place, base, (one,))):
                    default = Message("{name} has its default", name=one)
                    reason = hints.with_hint(reason, default)
                self._wrong(path, reason, f"{below}{key}" if key else place, value, place=place)
            if not key:
                return {}
            self.unsure.add((path.name, f"{below}{key}"))
            del own[key]

    def _wrong(
        self,
        path: Path,
        reason: Message,
        key: str = "",
        value: Any = None,
        allowed: str = "",
        place: str = "",
    ) -> None:
        if place:
            text = Message("{file}, {place}: {reason}", file=path, place=place, reason=reason)
        else:
            text = Message("{file}: {reason}", file=path, reason=reason)
        shown = "" if value is None else repr(value)
        self.unsure.add((path.name, key))
        self.problems.append(
            Problem(text.reporting_only(CONFIGURATION), str(path), key, shown, allowed)
        )


def read_configuration(folder: Path, built_axes: Path) -> Sections:
    """Return every section of a configuration; what a file leaves out has its default.

    Raises:
        ConfigurationError: A file cannot be read, or has an unknown key or a value that is not
            allowed; the message names file, key, value and what is allowed.
    """
    found = Reading(folder, built_axes)
    if found.problems:
        raise ConfigurationError(found.problems[0].message)
    return found.sections
