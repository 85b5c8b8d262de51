"""Small files with what a screen remembers, such as the last plan, and work beside its thread."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Generic, Mapping, Optional, TypeVar

import yaml

from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.faults import DISK_REFUSES
from gpr20_common.low.thread_fault import faults_logged
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.codec import plain, record_from
from gpr20_operator import faults
from gpr20_operator.errors import SettingsError
from gpr20_operator.plan.fields import PLAN
from gpr20_survey.files.durable_files import ensure_folders, replace_file
from gpr20_survey.plan.annotation import EMPTY, Annotation

Value = TypeVar("Value")


class Newest(Generic[Value]):
    """Calls a function with the newest value in a thread: a slow disk never delays the window."""

    def __init__(self, act: Callable[[Value], None]) -> None:
        self._act, self._worker = act, ThreadPoolExecutor(1)
        self._last: Future[None] = Future()
        self._last.set_result(None)

    def put(self, value: Value) -> None:
        """Call the function soon; a value that waits is dropped."""
        self._last.cancel()
        self._last = self._worker.submit(self._work, value)

    def wait(self, timeout_s: float) -> bool:
        """Return whether nothing is left to do within a time [s]."""
        return not wait([self._last], timeout_s).not_done

    def _work(self, value: Value) -> None:
        with faults_logged(self._act.__qualname__):
            self._act(value)


# Settings have some hundred bytes; a far larger file is something else.
MAX_BYTES = 65536
# Only the operator's own: a survey's place and people may be in it.
FOLDER_MODE = 0o700


class SettingsFile:
    """Reads and writes one group of plain values, in a YAML file that need not exist."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self) -> Dict[str, Any]:
        """Return the values; none if there is no file yet.

        Raises:
            SettingsError: The file cannot be read, or is damaged.
        """
        try:
            values = read_yaml(self._path, MAX_BYTES)
        except FileNotFoundError:
            return {}
        except YamlFileError as error:
            raise self._unreadable(error.message) from error
        except OSError as error:
            raise self._unreadable(os_reason(error)) from error
        if not isinstance(values, dict) or not all(isinstance(name, str) for name in values):
            raise self._unreadable(Message("it is not a group of named values"))
        return values

    def write(self, values: Mapping[str, Any]) -> None:
        """Replace the values and return when they are on the disk: whole, or as they were before.

        Raises:
            SettingsError: They cannot be written.
        """
        text = yaml.safe_dump(dict(values), sort_keys=False, allow_unicode=True)
        try:
            ensure_folders(self._path.parent, FOLDER_MODE)
            replace_file(self._path, text.encode("utf-8"))
        except OSError as error:
            reason = os_reason(error)
            raise SettingsError(
                Message("{path} cannot be written: {reason}", path=self._path, reason=reason),
                fault=DISK_REFUSES,
            ) from error

    def _unreadable(self, reason: Message) -> SettingsError:
        return SettingsError(
            Message(
                "{path} cannot be read: {reason}", path=self._path, reason=reason
            ).reporting_only(faults.SETTINGS_LOST.as_warning())
        )


def settings_writer(
    settings: SettingsFile, failed: Callable[[Message], None]
) -> Newest[Mapping[str, Any]]:
    """Return what writes the newest values in a thread of its own, which reports failures."""

    def write(values: Mapping[str, Any]) -> None:
        try:
            settings.write(values)
        except SettingsError as error:
            failed(error.message)

    return Newest(write)


@dataclass(frozen=True)
class RememberedPlan:
    """What the window starts with; texts that are missing have their defaults."""

    texts: Mapping[str, str] = field(default_factory=dict)
    annotation: Annotation = EMPTY


def plan_from(values: Mapping[str, Any]) -> RememberedPlan:
    """Return the plan of a settings file.

    Raises:
        SettingsError: A value is not one that this program writes.
    """
    try:
        plan = record_from(RememberedPlan, values, "plan")
        unknown = ", ".join(plan.texts.keys() - {one.name for one in PLAN})
        if unknown:
            raise InvalidValueError(verbatim(unknown))
    except InvalidValueError as error:
        raise SettingsError(
            Message(
                "the remembered plan is damaged ({reason}); the defaults are used",
                reason=error.message,
            ).reporting_only(SettingsError.fault)
        ) from error
    return plan


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
