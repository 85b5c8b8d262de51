"""What was planned last, on the disk."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.codec import plain, record_from
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import SettingsFile, settings_writer
from gpr20_operator.plan.fields import PLAN
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation


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
    except InvalidValueError as error:
        raise _damaged(error.message) from error
    known = plan.texts.keys() <= {one.name for one in PLAN}
    if not known or any(len(text) > MAX_NAME_CHARACTERS for text in plan.texts.values()):
        raise _damaged(verbatim("texts"))
    return plan


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
