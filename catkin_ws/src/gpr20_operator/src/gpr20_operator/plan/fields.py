"""One description of each value of a plan, for the window, its memory and the command line."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, Union

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.words import (
    HERTZ_PER_MEGAHERTZ,
    hertz_from_megahertz,
    megahertz_text,
    number_from_text,
    number_text,
    rotations_from_text,
    rotations_text,
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
from gpr20_survey.radar import MAX_PERMITTIVITY, MIN_PERMITTIVITY, Soils
from gpr20_survey.trace.sweep import (
    MAX_AVERAGES,
    MAX_FREQUENCY_HZ,
    MAX_FREQUENCY_POINTS,
    MIN_FREQUENCY_HZ,
    MIN_FREQUENCY_POINTS,
    OUTPUT_POWERS,
)


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
class Preset:
    """What a touch fills in: its title, and the new texts by the name of the field."""

    title: Message
    texts: Mapping[str, str]


# What a field allows: always the same, or what the axes of the robot allow.
Allowed = Union[Message, Callable[[RobotTravel], Message]]
# From the robot's axes, and a quarter wavelength in the soil [mm], None where it is not known.
Presets = Callable[[RobotTravel, Optional[float]], List[Preset]]


@dataclass(frozen=True)
class FieldSpec:
    """One value of a plan.

    Attributes:
        name: Field of SurveyParameters or of Annotation, or of the plan alone.
        title: What people call it, with its unit.
        tile: The group in which it is shown; None: it follows from others.
        kind: What its text is.
        default: The text with which a plan starts.
        limits: What it allows.
        presets: What a touch fills in.
        empty: What an empty text means; None: nothing.
    """

    name: str
    title: Message
    tile: Optional[Tile]
    kind: Kind
    default: str
    limits: Allowed
    presets: Presets = lambda _travel, _quarter_mm: []
    empty: Optional[Message] = None

    def allowed(self, travel: RobotTravel) -> Message:
        """Return what the field allows on a robot."""
        return self.limits if isinstance(self.limits, Message) else self.limits(travel)

    def hint(self, travel: RobotTravel) -> Message:
        """Return what the field allows, and what it means if it is empty."""
        allowed = self.allowed(travel)
        if self.empty is None:
            return allowed
        return Message("empty: {meaning}; else {allowed}", meaning=self.empty, allowed=allowed)


def _spacing(text: str) -> float:
    value = number_from_text(text)
    if value <= 0.0:
        raise InvalidValueError(ABOVE_0)
    return value


def _permittivity(text: str) -> float:
    value = number_from_text(text)
    if not MIN_PERMITTIVITY <= value <= MAX_PERMITTIVITY:
        raise InvalidValueError(Message("'{text}' is no permittivity of a soil", text=text))
    return value


ABOVE_0 = Message("above 0")
MILLIMETRES = Kind(Keys.NUMBER, number_from_text, number_text, "MM")
SPACING = Kind(Keys.NUMBER, _spacing, number_text)
WHOLE = Kind(Keys.WHOLE, whole_from_text)
MEGAHERTZ = Kind(Keys.NUMBER, hertz_from_megahertz, megahertz_text, "MHZ")
ROTATIONS = Kind(Keys.LIST, rotations_from_text, rotations_text, "DEG,DEG")
ADDRESS = Kind(Keys.ADDRESS, str.strip, metavar="A.B.C.D")
HERTZ = Kind(Keys.NUMBER, number_from_text, number_text, "HZ").or_empty()
WORD = Kind(Keys.NUMBER, str.strip, metavar="POWER")
PERMITTIVITY = Kind(Keys.NUMBER, _permittivity, number_text)
POSITION = Kind(
    Keys.LIST,
    lambda text: position_from_text(text) if text.strip() else None,
    lambda position: "" if position is None else str(position),
    "LAT,LON",
)


def _range(limits: Tuple[float, float]) -> Message:
    return Message("from {lower:.12g} to {upper:.12g}", lower=limits[0], upper=limits[1])


def _whole(lower: int, upper: int) -> Message:
    return Message("a whole number from {lower:g} to {upper:g}", lower=lower, upper=upper)


def _rotations_allowed(travel: RobotTravel) -> Message:
    return Message(
        "different, from {lower:g} to {upper:g} in steps of {step:g}",
        lower=travel.z.lower,
        upper=travel.z.upper,
        step=travel.z.step,
    )


def _areas(travel: RobotTravel, _quarter_mm: Optional[float]) -> List[Preset]:
    """Return the areas: all of the robot, and a small one in its middle."""
    whole: Dict[str, str] = {}
    middle: Dict[str, str] = {}
    for name, axis in (("x", travel.x), ("y", travel.y)):
        lower, upper = coordinate_limits_mm(axis)
        # Whole millimetres; a small axis has less than this area.
        start = max(lower, math.floor((lower + upper - SMALL_AREA_MM) / 2.0))
        stop = min(upper, start + SMALL_AREA_MM)
        for texts, ends_mm in ((whole, (lower, upper)), (middle, (start, stop))):
            texts[f"{name}_start_mm"], texts[f"{name}_stop_mm"] = map(number_text, ends_mm)
    size = {"width": f"{SMALL_AREA_MM:g}", "height": f"{SMALL_AREA_MM:g}"}
    centre = Message("{width} x {height} centre", **size)
    return [Preset(Message("Whole robot"), whole), Preset(centre, middle)]


def _spacings(_travel: RobotTravel, quarter_mm: Optional[float]) -> List[Preset]:
    """Return some distances of stops, and the coarsest one that suits the soil."""
    titles = {float(mm): verbatim(f"{mm} mm") for mm in (5, 10, 15, 20, 25)}
    if quarter_mm is not None:
        # Rounded down to a tenth: rounded up it would be too coarse.
        mm = math.floor(quarter_mm * 10.0) / 10.0
        titles[mm] = Message("Soil: {spacing:g} mm", spacing=mm)
    return [
        Preset(title, {f"{axis}_spacing_mm": f"{mm:g}" for axis in "xy"})
        for mm, title in titles.items()
    ]


def _fixed(*found: Preset) -> Presets:
    return lambda _travel, _quarter_mm: list(found)


def _one_of(name: str, texts: Iterable[str], unit: str, *first: Preset) -> Presets:
    """Return the presets of one field: each text with its unit."""
    return _fixed(*first, *(Preset(verbatim(f"{text}{unit}"), {name: text}) for text in texts))


def _as_set(name: str, texts: Iterable[str], unit: str = "") -> Presets:
    """Return the presets of a setting of the VNA: as it is, or one of some texts."""
    return _one_of(name, texts, unit, Preset(Message("AS SET"), {name: ""}))


SMALL_AREA_MM = 300.0
BANDS = _fixed(
    *(
        Preset(verbatim(f"600 - {stop}"), {"start_frequency_hz": "600", "stop_frequency_hz": stop})
        for stop in ("6000", "3000")
    ),
    *(
        Preset(Message("{count} points", count=count), {"frequency_points": str(count)})
        for count in (201, 501, 1001)
    ),
)
SOILS = _fixed(
    *(Preset(one.value.name, {"permittivity": f"{one.value.permittivity:g}"}) for one in Soils)
)
ADDRESSES = _fixed(Preset(Message("Robot's own"), {"vna_address": ""}))
Specs = Tuple[FieldSpec, ...]


def _axis(axis: str, start: Message, stop: Message, spacing: Message, points: Message) -> Specs:
    """Return the fields of a linear axis; its number of points follows from the spacing."""

    def limits(travel: RobotTravel) -> Message:
        return _range(coordinate_limits_mm(getattr(travel, axis)))

    def end(which: str, title: Message, default: str) -> FieldSpec:
        name = f"{axis}_{which}_mm"
        return FieldSpec(name, title, Tile.AREA, MILLIMETRES, default, limits, _areas)

    fewest = Message("a whole number, {lower:g} or more", lower=MIN_GRID_POINTS)
    above_0, name = ABOVE_0, f"{axis}_spacing_mm"
    return (
        end("start", start, "50"),
        end("stop", stop, "200"),
        FieldSpec(name, spacing, Tile.SPACING, SPACING, "10", above_0, _spacings),
        FieldSpec(f"{axis}_points", points, None, WHOLE, "16", fewest),
    )


_MEGAHERTZ = MIN_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ, MAX_FREQUENCY_HZ / HERTZ_PER_MEGAHERTZ
_AS_ON_VNA = Message("as set on the VNA")
_BELOW_STOP = Message(
    "from {lower:g} to {upper:g}, below the stop frequency",
    lower=_MEGAHERTZ[0],
    upper=_MEGAHERTZ[1],
)
# With a new robot: 150 x 150 mm in 25 min, with stops as close as dry sand asks for.
PLAN: Specs = (
    FieldSpec(
        *("vna_address", Message("VNA address"), Tile.VNA, ADDRESS, ""),
        Message("four whole numbers from 0 to 255"),
        ADDRESSES,
        Message("usual address"),
    ),
    FieldSpec(
        *("start_frequency_hz", Message("Start frequency (MHz)"), Tile.FREQUENCIES, MEGAHERTZ),
        *("600", _BELOW_STOP, BANDS),
    ),
    FieldSpec(
        *("stop_frequency_hz", Message("Stop frequency (MHz)"), Tile.FREQUENCIES, MEGAHERTZ),
        *("6000", _range(_MEGAHERTZ), BANDS),
    ),
    FieldSpec(
        *("frequency_points", Message("Frequency points"), Tile.FREQUENCIES, WHOLE, "501"),
        *(_whole(MIN_FREQUENCY_POINTS, MAX_FREQUENCY_POINTS), BANDS),
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
        *("polarizations_deg", Message("Antenna rotations (°)"), Tile.ANTENNAS, ROTATIONS, "0, 90"),
        _rotations_allowed,
        _one_of("polarizations_deg", ("0", "90", "0, 90", "-45, 45"), "°"),
    ),
    FieldSpec(
        *("if_bandwidth_hz", Message("IF bandwidth (Hz)"), Tile.VNA, HERTZ, ""),
        _range((MIN_IF_BANDWIDTH_HZ, MAX_IF_BANDWIDTH_HZ)),
        _as_set("if_bandwidth_hz", ("100", "1000", "10000", "100000"), " Hz"),
        _AS_ON_VNA,
    ),
    FieldSpec(
        *("averages", Message("Averages"), Tile.VNA, WHOLE.or_empty(), ""),
        _whole(1, MAX_AVERAGES),
        _as_set("averages", ("1", "4", "16"), " x"),
        _AS_ON_VNA,
    ),
    FieldSpec(
        *("output_power", Message("Output power"), Tile.VNA, WORD, ""),
        Message("LOW or HIGH for the MS2026C"),
        _as_set("output_power", OUTPUT_POWERS),
        _AS_ON_VNA,
    ),
    FieldSpec(
        *("permittivity", Message("Relative permittivity"), Tile.SOIL, PERMITTIVITY, "4"),
        *(_range((MIN_PERMITTIVITY, MAX_PERMITTIVITY)), SOILS),
    ),
)


def _people(
    name: str,
    title: Message,
    most: int = MAX_NAME_CHARACTERS,
    keys: Keys = Keys.LETTERS,
    empty: Optional[Message] = None,
) -> FieldSpec:
    """Return a text that people add to a survey."""

    def read(text: str) -> Any:
        values: Dict[str, Any] = {name: text}
        return getattr(Annotation(**values), name)

    allowed = Message("at most {most} characters", most=most)
    kind = Kind(keys, read, metavar="TEXT")
    return FieldSpec(name, title, Tile.NAME, kind, "", allowed, empty=empty)


_OF_THE_ROBOT = Message("that of the robot")
PEOPLE: Specs = (
    _people("name", Message("Name of the survey")),
    _people("operator", Message("Operator"), empty=_OF_THE_ROBOT),
    _people("site", Message("Site"), empty=_OF_THE_ROBOT),
    FieldSpec(
        *("position", Message("Position"), Tile.NAME, POSITION, ""),
        Message("WGS 84, such as {example}", example="4.603, -74.065"),
        empty=_OF_THE_ROBOT,
    ),
    _people("notes", Message("Notes"), MAX_NOTES_CHARACTERS, Keys.LINES),
)
SPECS: Dict[str, FieldSpec] = {spec.name: spec for spec in (*PLAN, *PEOPLE)}
# What main_control measures; the others are of the plan alone.
PARAMETERS = tuple(one for one in PLAN if one.name in SurveyParameters.__dataclass_fields__)
TILE_FIELDS: Mapping[Tile, Tuple[str, ...]] = {
    tile: tuple(one.name for one in SPECS.values() if one.tile is tile) for tile in Tile
}


def default_parameters() -> SurveyParameters:
    """Return the parameters with which a plan starts."""
    return SurveyParameters(**{one.name: one.kind.read(one.default) for one in PARAMETERS})


def texts_of(parameters: SurveyParameters) -> Dict[str, str]:
    """Return the texts of parameters, by the name of the field."""
    return {one.name: one.kind.write(getattr(parameters, one.name)) for one in PARAMETERS}
