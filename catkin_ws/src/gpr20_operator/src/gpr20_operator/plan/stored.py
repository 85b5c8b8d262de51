"""Plans on the disk: what was planned last, and parameters with a name."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Collection, FrozenSet, List, Mapping, Optional

from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.faults import DISK_REFUSES, NOT_ALLOWED
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.codec import plain, record_from
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import (
    SettingsFile,
    settings_writer,
)
from gpr20_operator.plan.fields import PLAN
from gpr20_operator.plan.presets import AREA_FIELDS
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation
from gpr20_survey.plan.survey_parameters import SurveyParameters

ARROW_STEPS = (1, 10, 100)
REMEMBERED = tuple(one.name for one in PLAN if one.remembered)


@dataclass(frozen=True)
class RememberedPlan:
    """What the window starts with; fields that are missing have their defaults.

    Attributes:
        following: The axes whose number of points follows from the spacing.
        last_area: Texts of the area of the last survey; empty if there was none.
        configured_address: The address that was proposed when the texts were entered.
    """

    texts: Mapping[str, str] = field(default_factory=dict)
    following: FrozenSet[str] = frozenset("xy")
    arrow_step: int = ARROW_STEPS[0]
    annotation: Annotation = EMPTY
    last_area: Mapping[str, str] = field(default_factory=dict)
    configured_address: str = ""


def plan_from(values: Mapping[str, Any]) -> RememberedPlan:
    """Return the plan of a settings file.

    Raises:
        SettingsError: A value is not one that this program writes.
    """
    try:
        plan = record_from(RememberedPlan, values, "plan")
    except InvalidValueError as error:
        raise _damaged(error.message) from error
    for key, right in {
        "texts": _are_known(plan.texts, REMEMBERED),
        "following": plan.following <= set("xy"),
        "arrow_step": plan.arrow_step in ARROW_STEPS,
        "last_area": _are_known(plan.last_area, AREA_FIELDS),
    }.items():
        if not right:
            raise _damaged(verbatim(key))
    return plan


def _are_known(texts: Mapping[str, str], names: Collection[str]) -> bool:
    return texts.keys() <= set(names) and all(
        len(text) <= MAX_NAME_CHARACTERS for text in texts.values()
    )


def _damaged(reason: Message) -> SettingsError:
    return SettingsError(
        Message(
            "the remembered plan is damaged ({reason}); the defaults are used", reason=reason
        ).reporting_only(SettingsError.fault)
    )


@dataclass(frozen=True)
class PlanMemoryFailed:
    """The plan could not be stored."""

    reason: Message


class PlanMemory:
    """Reads the plan once, and writes it beside the window's thread; failures are events."""

    def __init__(
        self, settings: SettingsFile, listener: Callable[[PlanMemoryFailed], None]
    ) -> None:
        self._settings = settings
        self._writer = settings_writer(settings, lambda reason: listener(PlanMemoryFailed(reason)))
        self._stored: Optional[RememberedPlan] = None
        self.problem: Optional[Message] = None

    def load(self) -> RememberedPlan:
        """Return what was stored; the defaults, and `problem` says why, if it is damaged."""
        try:
            self._stored = plan_from(self._settings.read())
        except SettingsError as error:
            self.problem = error.message
            return RememberedPlan()
        return self._stored

    def save(self, plan: RememberedPlan) -> None:
        """Store a plan soon; only the newest one counts."""
        if plan != self._stored:
            self._stored = plan
            self._writer.put(plain(plan))

    def wait(self, timeout_s: float) -> bool:
        """Return whether everything is written within a time [s]."""
        return self._writer.wait(timeout_s)


SUFFIX = ".yaml"
MAX_NAME_LENGTH = 32
# Nothing with a meaning in a path: neither slash nor dot.
NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9 _-]{{0,{MAX_NAME_LENGTH - 1}}}")


def is_name(name: str) -> bool:
    """Return whether a text may become the name of a profile and of its file."""
    return NAME.fullmatch(name) is not None and name == name.strip()


class Profiles:
    """Parameters by name; checks every name and every value. Every method raises SettingsError.

    Args:
        folder: Of the files; it need not exist.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def names(self) -> List[str]:
        """Return the names of all profiles, sorted."""
        try:
            # Reading a pipe would block the window.
            found = [one.stem for one in self._folder.glob(f"*{SUFFIX}") if one.is_file()]
        except OSError as error:
            raise _refused(self._folder, error) from error
        return sorted(name for name in found if is_name(name))

    def load(self, name: str) -> SurveyParameters:
        """Return the parameters of a profile; whether this robot allows them is not checked."""
        path = self.path(name)
        values = SettingsFile(path).read()
        try:
            return record_from(SurveyParameters, values, path.name)
        except InvalidValueError as error:
            raise SettingsError(error.message.reporting_only(SettingsError.fault)) from error

    def save(self, name: str, parameters: SurveyParameters) -> None:
        """Store parameters under a name, durably; they replace those that were there."""
        SettingsFile(self.path(name)).write(plain(parameters))

    def remove(self, name: str) -> None:
        """Delete a profile."""
        path = self.path(name)
        try:
            path.unlink()
        except OSError as error:
            raise _refused(path, error) from error

    def path(self, name: str) -> Path:
        """Return the file of a profile, which need not exist."""
        if not is_name(name):
            text = Message(
                "{name} is not a valid profile name; use 1 to {most} letters, digits, spaces, - "
                "and _; begin with a letter or digit and do not end with a space",
                name=repr(name[:64]),
                most=MAX_NAME_LENGTH,
            )
            raise SettingsError(text, fault=NOT_ALLOWED)
        return self._folder / f"{name}{SUFFIX}"


def _refused(path: Path, error: OSError) -> SettingsError:
    text = Message("{path} cannot be used: {reason}", path=path, reason=os_reason(error))
    return SettingsError(text, fault=DISK_REFUSES)
