"""The parameters of a survey as texts in fields, and their checks."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Callable, Dict, FrozenSet, Iterable, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.words import (
    decimal_from_text,
    number_from_text,
    plain_text,
)
from gpr20_survey.plan.survey_parameters import (
    MIN_GRID_POINTS,
    RobotTravel,
    Rule,
    SurveyParameters,
    coordinate_limits_mm,
    find_problems,
)
from gpr20_survey.trace.ms2026c import (
    IF_BANDWIDTHS_HZ,
    MAX_AVERAGES,
    MAX_FREQUENCY_HZ,
    MAX_FREQUENCY_POINTS,
    MIN_FREQUENCY_HZ,
    MIN_FREQUENCY_POINTS,
    OUTPUT_POWERS,
)

ADDRESS = "vna_address"
ROTATIONS = "polarizations_deg"
IF_BANDWIDTH, AVERAGES, OUTPUT_POWER = "if_bandwidth_hz", "averages", "output_power"
# Their fields may be empty: the VNA keeps the value that it has.
ANALYZER_FIELDS = (IF_BANDWIDTH, AVERAGES, OUTPUT_POWER)
# The arrows stop here; the checks limit the size of the whole survey.
MAX_GRID_POINTS = 9999
HERTZ_PER_MEGAHERTZ = 1.0e6
MEGAHERTZ_EXPONENT = 6
# Of a whole number; far more than any parameter needs.
MAX_DIGITS = 18


def hertz_from_megahertz(text: str) -> float:
    """Return the frequency [Hz] nearest to a decimal number of megahertz.

    A product of floats would be off by a fraction of a hertz for many inputs.

    Raises:
        InvalidValueError: The text is not a number.
    """
    try:
        return float(decimal_from_text(text).scaleb(MEGAHERTZ_EXPONENT))
    except InvalidValueError:
        raise InvalidValueError(
            Message("'{text}' is not a number of MHz, such as 600 or 5999.5", text=text)
        ) from None


def rotations_from_text(text: str) -> Tuple[float, ...]:
    """Return the rotations [deg] of a list, such as "0, 90".

    With semicolons between the rotations, as in "1,8; 90", a comma is a decimal comma.

    Raises:
        InvalidValueError: A part of the list is not a number.
    """
    separator = ";" if ";" in text else ","
    try:
        return tuple(number_from_text(part) for part in text.split(separator))
    except InvalidValueError:
        raise InvalidValueError(
            Message("'{text}' is not a list of rotations in degrees, such as 0,90", text=text)
        ) from None


def megahertz_text(frequency_hz: float) -> str:
    """Return a frequency [Hz] as a decimal number of megahertz, exactly."""
    return plain_text(Decimal(repr(frequency_hz)).scaleb(-MEGAHERTZ_EXPONENT))


def rotations_text(rotations_deg: Iterable[float]) -> str:
    """Return rotations [deg] as a list with commas."""
    return ", ".join(f"{rotation_deg:.12g}" for rotation_deg in rotations_deg)


def _whole_number(text: str) -> int:
    digits = text.strip()
    # Not int() alone: it accepts digits of other scripts, underscores and signs, and refuses
    # thousands of digits and some of the blanks that strip() removes.
    if not (digits.isascii() and digits.isdigit() and len(digits) <= MAX_DIGITS):
        raise InvalidValueError(
            Message("'{text}' is not a whole number of 0 or more", text=text[:64])
        )
    return int(digits)


def _number(text: str) -> float:
    value = number_from_text(text)
    if not math.isfinite(value):  # an exponent beyond all floats
        raise InvalidValueError(Message("'{text}' is not a number", text=text))
    return value


def _number_text(value: float) -> str:
    return f"{value:.12g}"


def _optional(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return a function that reads a number, and an empty text as 0."""
    return lambda text: read(text) if text.strip() else read("0")


def _optional_text(value: float) -> str:
    return _number_text(value) if value else ""


@dataclass(frozen=True)
class Field:
    """One field of the form.

    Attributes:
        name: Field of SurveyParameters.
        default: Text that the field starts with.
        read: Makes the parameter's value from the text, or raises InvalidValueError.
        write: Makes the text from a value.
        rules: Rules that are about this field.
        choices: Texts among which the arrows choose; empty: they change a number.
    """

    name: str
    default: str
    read: Callable[[str], Any]
    write: Callable[[Any], str]
    rules: FrozenSet[Rule]
    choices: Tuple[str, ...] = ()


def _field(
    name: str,
    default: str,
    read: Callable[[str], Any],
    write: Callable[[Any], str],
    *rules: Rule,
    choices: Tuple[str, ...] = (),
) -> Field:
    return Field(name, default, read, write, frozenset(rules), choices)


FIELDS: Tuple[Field, ...] = (
    # Empty: that of the robot's configuration.
    _field(ADDRESS, "", str.strip, str, Rule.ADDRESS),
    _field(
        "start_frequency_hz",
        "600",
        hertz_from_megahertz,
        megahertz_text,
        Rule.START_FREQUENCY,
        Rule.FREQUENCY_ORDER,
    ),
    _field("stop_frequency_hz", "6000", hertz_from_megahertz, megahertz_text, Rule.STOP_FREQUENCY),
    _field(
        "frequency_points",
        "501",
        _whole_number,
        str,
        Rule.FREQUENCY_POINTS,
        Rule.FREQUENCY_SPACING,
    ),
    _field("x_start_mm", "50", _number, _number_text, Rule.X_START),
    _field("x_stop_mm", "150", _number, _number_text, Rule.X_STOP),
    _field("x_points", "5", _whole_number, str, Rule.X_POINTS, Rule.X_SPACING, Rule.SIZE),
    _field("y_start_mm", "50", _number, _number_text, Rule.Y_START),
    _field("y_stop_mm", "150", _number, _number_text, Rule.Y_STOP),
    _field("y_points", "5", _whole_number, str, Rule.Y_POINTS, Rule.Y_SPACING, Rule.SIZE),
    _field(ROTATIONS, "0, 90", rotations_from_text, rotations_text, Rule.POLARIZATIONS),
    _field(
        IF_BANDWIDTH,
        "",
        _optional(_number),
        _optional_text,
        Rule.IF_BANDWIDTH,
        choices=("", *map(_number_text, IF_BANDWIDTHS_HZ)),
    ),
    _field(AVERAGES, "", _optional(_whole_number), _optional_text, Rule.AVERAGES),
    _field(OUTPUT_POWER, "", str.strip, str, Rule.OUTPUT_POWER, choices=("", *OUTPUT_POWERS)),
)
FIELDS_BY_NAME: Dict[str, Field] = {field.name: field for field in FIELDS}


@dataclass(frozen=True)
class FormCheck:
    """The result of the checks of the form.

    Attributes:
        parameters: None if a text cannot be read or a value is not allowed.
        unreadable: Fields whose text is no value of their kind.
        broken: Rules that the readable values break.
    """

    parameters: Optional[SurveyParameters]
    unreadable: Tuple[str, ...] = ()
    broken: Tuple[Rule, ...] = ()

    @property
    def wrong_fields(self) -> Tuple[str, ...]:
        """Names of the fields that are wrong, in their order."""
        broken = set(self.broken)
        return tuple(
            field.name for field in FIELDS if field.name in self.unreadable or field.rules & broken
        )


def check_form(texts: Mapping[str, str], travel: RobotTravel) -> FormCheck:
    """Read and check the texts of all fields."""
    values: Dict[str, Any] = {}
    unreadable = []
    for field in FIELDS:
        try:
            values[field.name] = field.read(texts[field.name])
        except InvalidValueError:
            unreadable.append(field.name)
    candidate = dataclasses.replace(default_parameters(), **values)
    # A field that cannot be read is replaced by its default, which must not be judged, nor
    # what follows from it.
    if unreadable:
        unjudged = frozenset().union(*(FIELDS_BY_NAME[name].rules for name in unreadable))
        unjudged |= _RELATIONS
    else:
        unjudged = frozenset()
    found = [one.rule for one in find_problems(candidate, travel) if one.rule not in unjudged]
    return FormCheck(
        candidate if not unreadable and not found else None, tuple(unreadable), tuple(found)
    )


_RELATIONS = frozenset(
    [Rule.FREQUENCY_ORDER, Rule.FREQUENCY_SPACING, Rule.X_SPACING, Rule.Y_SPACING, Rule.SIZE]
)


def default_parameters() -> SurveyParameters:
    """Return the parameters with which the form starts."""
    return SurveyParameters(**{field.name: field.read(field.default) for field in FIELDS})


def texts_of(parameters: SurveyParameters) -> Dict[str, str]:
    """Return the texts of all fields for given parameters."""
    return {field.name: field.write(getattr(parameters, field.name)) for field in FIELDS}


def limits(name: str, travel: RobotTravel) -> Tuple[float, float]:
    """Return the smallest and largest number of a field that the arrows change by a step.

    They are in the unit in which the field is shown.
    """
    if name in ("x_start_mm", "x_stop_mm"):
        return coordinate_limits_mm(travel.x)
    if name in ("y_start_mm", "y_stop_mm"):
        return coordinate_limits_mm(travel.y)
    if name == "frequency_points":
        return MIN_FREQUENCY_POINTS, MAX_FREQUENCY_POINTS
    if name == AVERAGES:
        return 0, MAX_AVERAGES
    if name in ("x_points", "y_points"):
        return MIN_GRID_POINTS, MAX_GRID_POINTS
    return MIN_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ, MAX_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ


def after_arrow(name: str, text: str, change: int, travel: RobotTravel) -> str:
    """Return the text of a field after an arrow.

    Args:
        name: Of the field.
        text: Its text now.
        change: By how much a number changes; of a choice only the sign counts.
        travel: Limits of the axes.
    """
    field = FIELDS_BY_NAME[name]
    if field.choices:
        return _next_choice(field.choices, text.strip(), change)
    if name in ANALYZER_FIELDS:
        changed = stepped(text or "0", change, limits(name, travel))
        return "" if changed == "0" else changed
    return stepped(text, change, limits(name, travel))


def _next_choice(choices: Tuple[str, ...], text: str, change: int) -> str:
    if text not in choices:
        return choices[0]
    place = choices.index(text) + (1 if change > 0 else -1)
    return choices[min(max(place, 0), len(choices) - 1)]


def stepped(text: str, change: int, bounds: Tuple[float, float]) -> str:
    """Return the text of a number after an arrow, changed within its bounds.

    A text that is no finite number is replaced by the lower bound.
    """
    lower, upper = (Decimal(repr(bound)) for bound in bounds)
    try:
        changed = decimal_from_text(text) + change
    except (InvalidValueError, ArithmeticError):  # no number, or one beyond all numbers
        return plain_text(lower)
    return plain_text(min(max(changed, lower), upper))
