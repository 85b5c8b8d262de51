"""What is known of one value of a plan."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Callable, List, Optional, Tuple

from gpr20_common.message import Message
from gpr20_operator.plan.presets import Preset, PresetContext
from gpr20_operator.words import stepped
from gpr20_survey.plan.survey_parameters import RobotTravel

# The arrows stop here; the checks limit the size of the whole survey.
MAX_GRID_POINTS = 9999
Limits = Callable[[RobotTravel], Tuple[float, float]]


class Tile(enum.Enum):
    """The groups of values and their titles, in the order of the screen."""

    AREA = Message("Where")
    SPACING = Message("How close")
    SOIL = Message("Soil")
    FREQUENCIES = Message("Radar")
    ANTENNAS = Message("Antennas")
    VNA = Message("VNA")
    NAME = Message("Name")


class Keys(enum.Enum):
    """Which keys write a text."""

    NUMBER = enum.auto()
    WHOLE = enum.auto()
    CHOICE = enum.auto()
    ADDRESS = enum.auto()
    LIST = enum.auto()
    LETTERS = enum.auto()
    LINES = enum.auto()


@dataclass(frozen=True)
class Kind:
    """A kind of value: which keys write its text, and how the text is read and written.

    Attributes:
        read: Makes the value from a text, or raises InvalidValueError.
        metavar: What the command line calls it.
    """

    keys: Keys
    read: Callable[[str], Any]
    write: Callable[[Any], str] = str
    metavar: str = "N"

    def or_empty(self) -> Kind:
        """Return the kind of number whose empty text is 0."""
        return Kind(
            self.keys,
            lambda text: self.read(text) if text.strip() else self.read("0"),
            lambda value: self.write(value) if value else "",
            self.metavar,
        )


@dataclass(frozen=True)
class FieldSpec:
    """One value of a plan.

    Attributes:
        name: Field of SurveyParameters or of Annotation, or of the plan alone.
        title: What people call it, with its unit.
        tile: The group in which it is shown.
        kind: What its text is.
        default: The text with which a plan starts.
        limits: Smallest and largest number; the arrows stop there.
        allowed: What it allows, if that is not a number within these limits.
        choices: Texts among which an arrow chooses, instead of changing a number.
        presets: What a touch fills in.
        empty: What an empty text means; None: nothing.
        remembered: Whether the next plan starts with it.
    """

    name: str
    title: Message
    tile: Tile
    kind: Kind
    default: str = ""
    limits: Optional[Limits] = None
    allowed: Optional[Callable[[RobotTravel], Message]] = None
    choices: Tuple[str, ...] = ()
    presets: Callable[[PresetContext], List[Preset]] = lambda _context: []
    empty: Optional[Message] = None
    remembered: bool = True

    def allows(self, travel: RobotTravel) -> Message:
        """Return what the field allows."""
        if self.allowed is not None:
            return self.allowed(travel)
        lower, upper = (0.0, 0.0) if self.limits is None else self.limits(travel)
        if self.kind.keys is not Keys.WHOLE:
            return Message("from {lower:.12g} to {upper:.12g}", lower=lower, upper=upper)
        if upper == MAX_GRID_POINTS:
            return Message("a whole number, {lower:g} or more", lower=lower)
        return Message("a whole number from {lower:g} to {upper:g}", lower=lower, upper=upper)

    def hint(self, travel: RobotTravel) -> Message:
        """Return what the field allows, and what it means if it is empty."""
        allowed = self.allows(travel)
        if self.empty is None:
            return allowed
        return Message("empty: {meaning}; else {allowed}", meaning=self.empty, allowed=allowed)

    def after_arrow(self, text: str, change: int, travel: RobotTravel) -> str:
        """Return the text after an arrow; of a choice only the sign of the change counts."""
        if self.choices:
            return _next_choice(self.choices, text.strip(), change)
        if self.limits is None:
            return text
        lower, upper = self.limits(travel)
        if self.empty is None:
            return stepped(text, change, (lower, upper))
        changed = stepped(text or "0", change, (0.0, upper))
        return "" if float(changed) < lower else changed


def _next_choice(choices: Tuple[str, ...], text: str, change: int) -> str:
    if text not in choices:
        return choices[0]
    place = choices.index(text) + (1 if change > 0 else -1)
    return choices[min(max(place, 0), len(choices) - 1)]
