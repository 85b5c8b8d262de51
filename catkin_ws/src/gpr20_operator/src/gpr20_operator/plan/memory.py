"""What the operator planned last, for the next start of the window."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Dict, FrozenSet, List, Mapping, Optional

from gpr20_common.message import Message
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import SettingsFile, settings_writer
from gpr20_operator.plan.fields import PEOPLE, PLAN
from gpr20_operator.plan.presets import AREA_FIELDS
from gpr20_survey.plan.annotation import MAX_NAME_CHARACTERS, Annotation

ARROW_STEPS = (1, 10, 100)
FIELDS, FOLLOWING, STEP, SURVEY = "fields", "points_follow_spacing", "arrow_step", "survey"
LAST_AREA, PROPOSED_ADDRESS = "last_area", "configured_address"
REMEMBERED_PEOPLE = tuple(one.name for one in PEOPLE if one.remembered)
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
    annotation: Annotation = field(default_factory=Annotation)
    last_area: Mapping[str, str] = field(default_factory=dict)
    configured_address: str = ""


def plan_from(values: Mapping[str, Any]) -> RememberedPlan:
    """Return the plan of a settings file.

    Raises:
        SettingsError: A value is not one that this program writes.
    """
    if not values:
        return RememberedPlan()
    found: List[Any] = [values.get(key) for key in (FOLLOWING, STEP, PROPOSED_ADDRESS)]
    following, step, address = found
    for key, right in (
        (FOLLOWING, following in ("", "x", "y", "xy")),
        (STEP, step in ARROW_STEPS and not isinstance(step, bool)),
        (PROPOSED_ADDRESS, isinstance(address, str)),
    ):
        if not right:
            raise _damaged(key)
    people: Mapping[str, Any] = _texts(values, SURVEY, REMEMBERED_PEOPLE)
    try:
        annotation = Annotation(**people)
    except ValueError as error:
        raise _damaged(SURVEY) from error
    texts = _texts(values, FIELDS, REMEMBERED)
    last_area = _texts(values, LAST_AREA, AREA_FIELDS)
    return RememberedPlan(texts, frozenset(following), step, annotation, last_area, address)


def values_of(plan: RememberedPlan) -> Dict[str, Any]:
    """Return the content of the settings file."""
    return {
        FIELDS: dict(plan.texts),
        FOLLOWING: "".join(sorted(plan.following)),
        STEP: plan.arrow_step,
        SURVEY: {name: getattr(plan.annotation, name) for name in REMEMBERED_PEOPLE},
        LAST_AREA: dict(plan.last_area),
        PROPOSED_ADDRESS: plan.configured_address,
    }


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
            self._writer.put(values_of(plan))

    def wait(self, timeout_s: float) -> bool:
        """Return whether everything is written within a time [s]."""
        return self._writer.wait(timeout_s)


def _texts(values: Mapping[str, Any], key: str, names: Any) -> Dict[str, str]:
    found = values.get(key)
    if not isinstance(found, dict):
        raise _damaged(key)
    for name, text in found.items():
        if name not in names or not isinstance(text, str) or len(text) > MAX_NAME_CHARACTERS:
            raise _damaged(f"{key}.{name}")
    return found


def _damaged(key: str) -> SettingsError:
    return SettingsError(
        Message("the remembered plan is damaged at {key}; the defaults are used", key=key)
    )
