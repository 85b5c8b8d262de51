"""What the operator planned last, for the next start of the window."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Collection, FrozenSet, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_common.mid.codec import plain, record_from
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import SettingsFile, settings_writer
from gpr20_operator.plan.fields import PLAN
from gpr20_operator.plan.presets import AREA_FIELDS
from gpr20_survey.plan.annotation import EMPTY, MAX_NAME_CHARACTERS, Annotation

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
