"""What the tiles of the plan show: today's values, and what is wrong with them."""

from __future__ import annotations

import enum
from typing import Dict, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.form import (
    PERMITTIVITY,
    X_SPACING,
    Y_SPACING,
    PlanCheck,
    plan_field_title,
)
from gpr20_operator.plan.parameter_form import (
    ADDRESS,
    AVERAGES,
    IF_BANDWIDTH,
    OUTPUT_POWER,
    ROTATIONS,
)
from gpr20_operator.words import decimal_from_text, number_from_text, plain_text
from gpr20_survey.plan.annotation import Annotation
from gpr20_survey.radar.soils import soil_of

ENDS = ("start", "stop")
AS_SET = Message("as set")
Lines = Tuple[Message, ...]


class Tile(enum.Enum):
    """The groups of values, in the order of the screen."""

    AREA = "area"
    SPACING = "spacing"
    FREQUENCIES = "frequencies"
    VNA = "vna"
    SOIL = "soil"
    ANTENNAS = "antennas"
    NAME = "name"


TILE_TITLES: Mapping[Tile, Message] = {
    Tile.AREA: Message("Area (mm)"),
    Tile.SPACING: Message("Spacing"),
    Tile.FREQUENCIES: Message("Frequencies"),
    Tile.VNA: Message("VNA"),
    Tile.SOIL: Message("Soil"),
    Tile.ANTENNAS: Message("Antennas"),
    Tile.NAME: Message("Name"),
}
# The fields of the sheet of a tile. Name, operator and site have a sheet of their own.
TILE_FIELDS: Mapping[Tile, Tuple[str, ...]] = {
    Tile.AREA: ("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm"),
    Tile.SPACING: (X_SPACING, Y_SPACING, "x_points", "y_points"),
    Tile.FREQUENCIES: ("start_frequency_hz", "stop_frequency_hz", "frequency_points"),
    Tile.VNA: (ADDRESS, IF_BANDWIDTH, AVERAGES, OUTPUT_POWER),
    Tile.SOIL: (PERMITTIVITY,),
    Tile.ANTENNAS: (ROTATIONS,),
    Tile.NAME: (),
}
VALUE_TILES = tuple(tile for tile in Tile if TILE_FIELDS[tile])


def tile_lines(tile: Tile, texts: Mapping[str, str]) -> Lines:
    """Return the lines of a tile.

    Args:
        tile: Any but that of the name.
        texts: Of all fields.
    """
    return {
        Tile.AREA: _area,
        Tile.SPACING: _spacing,
        Tile.FREQUENCIES: _frequencies,
        Tile.VNA: _analyzer,
        Tile.SOIL: _soil,
        Tile.ANTENNAS: _antennas,
    }[tile](texts)


def name_lines(annotation: Annotation) -> Lines:
    """Return the lines of the tile of the name."""
    people = " · ".join(one for one in (annotation.operator, annotation.site) if one)
    name = verbatim(annotation.name) if annotation.name else Message("no name")
    return name, verbatim(people)


def tile_problem(tile: Tile, check: PlanCheck) -> Optional[Message]:
    """Return what is wrong in a tile, first field first; None if it is right."""
    wrong = [name for name in TILE_FIELDS[tile] if name in check.problems]
    return field_sentence(wrong[0], check) if wrong else None


def first_problem(check: PlanCheck) -> Optional[Message]:
    """Return what is wrong in the first tile that is wrong; None if none is."""
    problems = (tile_problem(tile, check) for tile in Tile)
    return next((one for one in problems if one is not None), None)


def field_sentence(name: str, check: PlanCheck) -> Message:
    """Return which field is wrong, and what it allows."""
    return Message("{field}: {allowed}", field=plan_field_title(name), allowed=check.problems[name])


def _area(texts: Mapping[str, str]) -> Lines:
    ends = {axis: [_rounded(texts[f"{axis}_{end}_mm"]) for end in ENDS] for axis in "xy"}
    return verbatim("X " + " - ".join(ends["x"])), verbatim("Y " + " - ".join(ends["y"]))


def _spacing(texts: Mapping[str, str]) -> Lines:
    both: Dict[str, str] = {axis: _short(texts[f"{axis}_spacing_mm"]) for axis in "xy"}
    one = both["x"] if both["x"] == both["y"] else f"{both['x']} x {both['y']}"
    points = Message("{x} x {y} points", x=texts["x_points"], y=texts["y_points"])
    return verbatim(f"{one} mm"), points


def _frequencies(texts: Mapping[str, str]) -> Lines:
    ends = (texts["start_frequency_hz"], texts["stop_frequency_hz"])
    return (
        Message("{start} to {stop} MHz", start=ends[0], stop=ends[1]),
        Message("{count} points", count=texts["frequency_points"]),
    )


def _analyzer(texts: Mapping[str, str]) -> Lines:
    address = verbatim(texts[ADDRESS]) if texts[ADDRESS] else Message("no address")
    bandwidth = verbatim(f"{texts[IF_BANDWIDTH]} Hz") if texts[IF_BANDWIDTH] else AS_SET
    others: List[str] = [f"{texts[AVERAGES]} x"] if texts[AVERAGES] else []
    if texts[OUTPUT_POWER]:
        others.append(texts[OUTPUT_POWER])
    return address, bandwidth, verbatim(" · ".join(others))


def _soil(texts: Mapping[str, str]) -> Lines:
    text = texts[PERMITTIVITY]
    try:
        soil = soil_of(number_from_text(text))
    except InvalidValueError:
        soil = None
    name = Message("Own value") if soil is None else soil.value.name
    return name, Message("permittivity {value}", value=text)


def _antennas(texts: Mapping[str, str]) -> Lines:
    rotations = [one for one in texts[ROTATIONS].replace(";", ",").split(",") if one.strip()]
    if len(rotations) == 1:
        return verbatim(f"{texts[ROTATIONS]}°"), Message("1 trace per stop")
    return (
        verbatim(f"{texts[ROTATIONS]}°"),
        Message("{count} traces per stop", count=len(rotations)),
    )


def _rounded(text: str) -> str:
    """Return a coordinate [mm] to a motor step: a longer number would be cut off."""
    try:
        return plain_text(round(decimal_from_text(text), 2))
    except (InvalidValueError, ArithmeticError):
        return text


def _short(text: str) -> str:
    """Return a number with at most four digits."""
    try:
        return f"{number_from_text(text):.4g}"
    except InvalidValueError:
        return text
