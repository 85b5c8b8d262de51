"""One description of each value of a plan, for the window, its memory and the command line."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_operator.plan import presets
from gpr20_operator.plan.presets import Preset, PresetContext
from gpr20_operator.words import (
    HERTZ_PER_MEGAHERTZ,
    hertz_from_megahertz,
    megahertz_text,
    number_from_text,
    number_text,
    rotations_from_text,
    rotations_text,
    stepped,
    whole_from_text,
)
from gpr20_survey.plan.annotation import (
    MAX_NAME_CHARACTERS,
    MAX_NOTES_CHARACTERS,
    Annotation,
    position_from_text,
)
from gpr20_survey.plan.survey_parameters import (
    MAX_IF_BANDWIDTH_HZ,
    MIN_GRID_POINTS,
    MIN_IF_BANDWIDTH_HZ,
    RobotTravel,
    SurveyParameters,
    coordinate_limits_mm,
)
from gpr20_survey.radar.soils import MAX_PERMITTIVITY, MIN_PERMITTIVITY
from gpr20_survey.trace.ms2026c import (
    IF_BANDWIDTHS_HZ,
    MAX_AVERAGES,
    MAX_FREQUENCY_HZ,
    MAX_FREQUENCY_POINTS,
    MIN_FREQUENCY_HZ,
    MIN_FREQUENCY_POINTS,
    OUTPUT_POWERS,
)

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


SPACING_BOUNDS_MM = (1.0, 800.0)
Specs = Tuple[FieldSpec, ...]
_ABOVE_0 = Message("above 0")


def _spacing(text: str) -> float:
    value = number_from_text(text)
    if value <= 0.0:
        raise InvalidValueError(_ABOVE_0)
    return value


def _permittivity(text: str) -> float:
    value = number_from_text(text)
    if not MIN_PERMITTIVITY <= value <= MAX_PERMITTIVITY:
        raise InvalidValueError(Message("'{text}' is no permittivity of a soil", text=text))
    return value


MILLIMETRES = Kind(Keys.NUMBER, number_from_text, number_text, "MM")
SPACING = Kind(Keys.NUMBER, _spacing, number_text)
WHOLE = Kind(Keys.WHOLE, whole_from_text)
MEGAHERTZ = Kind(Keys.NUMBER, hertz_from_megahertz, megahertz_text, "MHZ")
ROTATIONS = Kind(Keys.LIST, rotations_from_text, rotations_text, "DEG,DEG")
ADDRESS = Kind(Keys.ADDRESS, str.strip, metavar="A.B.C.D")
HERTZ = Kind(Keys.CHOICE, number_from_text, number_text, "HZ").or_empty()
WORD = Kind(Keys.CHOICE, str.strip, metavar="POWER")
POSITION = Kind(
    Keys.LIST,
    lambda text: position_from_text(text) if text.strip() else None,
    lambda position: "" if position is None else str(position),
    "LAT,LON",
)


def _always(message: Message) -> Callable[[RobotTravel], Message]:
    return lambda _travel: message


def _within(lower: float, upper: float) -> Limits:
    return lambda _travel: (lower, upper)


def _axis(axis: str, start: Message, stop: Message, spacing: Message, points: Message) -> Specs:
    """Return the fields of a linear axis by their titles, with the defaults of both axes."""

    def end(which: str, title: Message, default: str) -> FieldSpec:
        return FieldSpec(
            *(f"{axis}_{which}_mm", title, Tile.AREA, MILLIMETRES, default),
            limits=lambda travel: coordinate_limits_mm(getattr(travel, axis)),
            presets=presets.areas,
        )

    return (
        end("start", start, "50"),
        end("stop", stop, "150"),
        FieldSpec(
            *(f"{axis}_spacing_mm", spacing, Tile.SPACING, SPACING, "10"),
            limits=_within(*SPACING_BOUNDS_MM),
            allowed=_always(_ABOVE_0),
            presets=presets.spacings,
        ),
        FieldSpec(
            *(f"{axis}_points", points, Tile.SPACING, WHOLE, "11"),
            limits=_within(MIN_GRID_POINTS, MAX_GRID_POINTS),
            presets=presets.spacings,
        ),
    )


def _rotations_allowed(travel: RobotTravel) -> Message:
    return Message(
        "different, from {lower:g} to {upper:g} in steps of {step:g}",
        lower=travel.z.lower,
        upper=travel.z.upper,
        step=travel.z.step,
    )


_MEGAHERTZ = MIN_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ, MAX_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ
_AS_ON_VNA = Message("as set on the VNA")
# With a new robot: 100 x 100 mm in 12 min, with stops as close as dry sand asks for.
PLAN: Specs = (
    FieldSpec(
        *("vna_address", Message("VNA address"), Tile.VNA, ADDRESS),
        allowed=_always(Message("four whole numbers from 0 to 255")),
        presets=presets.addresses,
        empty=Message("as configured"),
    ),
    FieldSpec(
        *("start_frequency_hz", Message("Start frequency (MHz)"), Tile.FREQUENCIES, MEGAHERTZ),
        *("600", _within(*_MEGAHERTZ)),
        allowed=_always(
            Message(
                "from {lower:g} to {upper:g}, below the stop frequency",
                **dict(zip(("lower", "upper"), _MEGAHERTZ)),
            )
        ),
        presets=presets.frequencies,
    ),
    FieldSpec(
        *("stop_frequency_hz", Message("Stop frequency (MHz)"), Tile.FREQUENCIES, MEGAHERTZ),
        *("6000", _within(*_MEGAHERTZ)),
        presets=presets.frequencies,
    ),
    FieldSpec(
        *("frequency_points", Message("Frequency points"), Tile.FREQUENCIES, WHOLE, "501"),
        limits=_within(MIN_FREQUENCY_POINTS, MAX_FREQUENCY_POINTS),
        presets=presets.frequencies,
    ),
    *_axis(
        "x",
        Message("X start (mm)"),
        Message("X stop (mm)"),
        Message("X spacing (mm)"),
        Message("X points"),
    ),
    *_axis(
        "y",
        Message("Y start (mm)"),
        Message("Y stop (mm)"),
        Message("Y spacing (mm)"),
        Message("Y points"),
    ),
    FieldSpec(
        *("polarizations_deg", Message("Antenna rotations (°)"), Tile.ANTENNAS, ROTATIONS),
        "0, 90",
        allowed=_rotations_allowed,
        presets=presets.rotations,
    ),
    FieldSpec(
        *("if_bandwidth_hz", Message("IF bandwidth (Hz)"), Tile.VNA, HERTZ),
        limits=_within(MIN_IF_BANDWIDTH_HZ, MAX_IF_BANDWIDTH_HZ),
        choices=("", *map(number_text, IF_BANDWIDTHS_HZ)),
        presets=presets.settings("if_bandwidth_hz", presets.IF_BANDWIDTHS, "Hz"),
        empty=_AS_ON_VNA,
    ),
    FieldSpec(
        *("averages", Message("Averages"), Tile.VNA, WHOLE.or_empty()),
        limits=_within(1, MAX_AVERAGES),
        presets=presets.settings("averages", presets.AVERAGES, "x"),
        empty=_AS_ON_VNA,
    ),
    FieldSpec(
        *("output_power", Message("Output power"), Tile.VNA, WORD),
        allowed=_always(Message("LOW or HIGH for the MS2026C")),
        choices=("", *OUTPUT_POWERS),
        presets=presets.settings("output_power", OUTPUT_POWERS),
        empty=_AS_ON_VNA,
    ),
    FieldSpec(
        *("permittivity", Message("Relative permittivity"), Tile.SOIL),
        *(Kind(Keys.NUMBER, _permittivity, number_text), "4"),
        limits=_within(MIN_PERMITTIVITY, MAX_PERMITTIVITY),
        presets=presets.soils,
    ),
)


def _people(name: str, title: Message, most: int = MAX_NAME_CHARACTERS, **more: Any) -> FieldSpec:
    """Return a text that people add to a survey."""

    def read(text: str) -> Any:
        values: Dict[str, Any] = {name: text}
        return getattr(Annotation(**values), name)

    keys = Keys.LETTERS if most == MAX_NAME_CHARACTERS else Keys.LINES
    return FieldSpec(
        *(name, title, Tile.NAME, Kind(keys, read, metavar="TEXT")),
        allowed=_always(Message("at most {most} characters", most=most)),
        **more,
    )


_OF_THE_ROBOT = Message("that of the robot")
PEOPLE: Specs = (
    _people("name", Message("Name of the survey")),
    _people("operator", Message("Operator"), empty=_OF_THE_ROBOT),
    _people("site", Message("Site"), empty=_OF_THE_ROBOT),
    FieldSpec(
        *("position", Message("Position"), Tile.NAME, POSITION),
        allowed=_always(Message("WGS 84, such as {example}", example="4.603, -74.065")),
        empty=_OF_THE_ROBOT,
        remembered=False,
    ),
    _people("notes", Message("Notes"), MAX_NOTES_CHARACTERS, remembered=False),
)
SPECS: Dict[str, FieldSpec] = {spec.name: spec for spec in (*PLAN, *PEOPLE)}
# What main_control measures; the others are of the plan alone.
PARAMETERS = tuple(one for one in PLAN if one.name in SurveyParameters.__dataclass_fields__)
TILE_FIELDS: Mapping[Tile, Tuple[str, ...]] = {
    tile: tuple(one.name for one in SPECS.values() if one.tile is tile) for tile in Tile
}
# Those whose sheet has keys for all fields at once.
VALUE_TILES = tuple(tile for tile in Tile if tile is not Tile.NAME)


def default_parameters() -> SurveyParameters:
    """Return the parameters with which a plan starts."""
    return SurveyParameters(**{one.name: one.kind.read(one.default) for one in PARAMETERS})


def texts_of(parameters: SurveyParameters) -> Dict[str, str]:
    """Return the texts of parameters, by the name of the field."""
    return {one.name: one.kind.write(getattr(parameters, one.name)) for one in PARAMETERS}
