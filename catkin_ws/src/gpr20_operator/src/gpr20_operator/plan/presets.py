"""Values to choose with one touch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Mapping, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.form import PERMITTIVITY, X_SPACING, Y_SPACING
from gpr20_operator.plan.parameter_form import (
    ADDRESS,
    AVERAGES,
    HERTZ_PER_MEGAHERTZ,
    IF_BANDWIDTH,
    OUTPUT_POWER,
    ROTATIONS,
)
from gpr20_operator.plan.tiles import Tile
from gpr20_survey.plan.survey_parameters import RobotTravel, coordinate_limits_mm
from gpr20_survey.radar.soils import Soils
from gpr20_survey.trace.ms2026c import (
    IF_BANDWIDTHS_HZ,
    MAX_FREQUENCY_HZ,
    MIN_FREQUENCY_HZ,
    OUTPUT_POWERS,
)

SMALL_AREA_MM = 300.0
SPACINGS_MM = (5, 10, 15, 20, 25)
FREQUENCY_BANDS_MHZ = ((600, 6000), (600, 3000))
FREQUENCY_POINTS = (201, 501, 1001)
ROTATIONS_DEG = ("0", "90", "0, 90", "-45, 45")
AVERAGES_SHOWN = ("1", "4", "16")
AS_SET = Message("AS SET")
AREA_FIELDS = ("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm")


@dataclass(frozen=True)
class Preset:
    """What a touch fills in.

    Attributes:
        title: What it is called.
        texts: The new texts, by the name of the field.
    """

    title: Message
    texts: Mapping[str, str]


@dataclass(frozen=True)
class PresetContext:
    """What presets depend on.

    Attributes:
        travel: What the axes allow.
        last_area: Texts of the area of the survey before; empty if there is none.
        address: Of the VNA in the robot's configuration; empty if it is not known.
        quarter_wavelength_mm: In the soil [mm]; None if frequencies or permittivity are wrong.
    """

    travel: RobotTravel
    last_area: Mapping[str, str]
    address: str
    quarter_wavelength_mm: Optional[float]


def presets_for(tile: Tile, field: str, context: PresetContext) -> List[Preset]:
    """Return what a touch can fill in.

    Args:
        tile: The group of values.
        field: Name of the field that is being entered.
        context: What presets depend on.
    """
    if tile is Tile.AREA:
        return _areas(context)
    if tile is Tile.SPACING:
        return _spacings(context)
    if tile is Tile.FREQUENCIES:
        return _frequencies()
    if tile is Tile.SOIL:
        return [
            Preset(soil.value.name, {PERMITTIVITY: f"{soil.value.permittivity:g}"})
            for soil in Soils
        ]
    if tile is Tile.ANTENNAS:
        return [Preset(verbatim(f"{text}°"), {ROTATIONS: text}) for text in ROTATIONS_DEG]
    return _analyzer(field, context) if tile is Tile.VNA else []


def _areas(context: PresetContext) -> List[Preset]:
    x_mm = coordinate_limits_mm(context.travel.x)
    y_mm = coordinate_limits_mm(context.travel.y)
    size = {"width": f"{SMALL_AREA_MM:g}", "height": f"{SMALL_AREA_MM:g}"}
    found = [
        Preset(Message("Whole robot"), _area(x_mm, y_mm)),
        Preset(Message("{width} x {height} centre", **size), _area(_middle(x_mm), _middle(y_mm))),
        Preset(Message("{width} x {height} origin", **size), _area(_first(x_mm), _first(y_mm))),
    ]
    if context.last_area:
        found.append(Preset(Message("Last survey"), dict(context.last_area)))
    return found


def _area(x_mm: Tuple[float, float], y_mm: Tuple[float, float]) -> Mapping[str, str]:
    return dict(zip(AREA_FIELDS, (f"{value:.12g}" for value in (*x_mm, *y_mm))))


def _middle(limits_mm: Tuple[float, float]) -> Tuple[float, float]:
    lower, upper = limits_mm
    # Whole millimetres; a small axis has less than this area.
    start = max(lower, math.floor((lower + upper - SMALL_AREA_MM) / 2.0))
    return start, min(upper, start + SMALL_AREA_MM)


def _first(limits_mm: Tuple[float, float]) -> Tuple[float, float]:
    lower, upper = limits_mm
    return lower, min(upper, lower + SMALL_AREA_MM)


def _spacings(context: PresetContext) -> List[Preset]:
    found = [_spacing(verbatim(f"{mm} mm"), mm) for mm in SPACINGS_MM]
    if context.quarter_wavelength_mm is not None:
        # Rounded down to a tenth: rounded up it would be too coarse.
        mm = math.floor(context.quarter_wavelength_mm * 10.0) / 10.0
        found.append(_spacing(Message("λ/4: {spacing:g} mm", spacing=mm), mm))
    return found


def _spacing(title: Message, spacing_mm: float) -> Preset:
    text = f"{spacing_mm:g}"
    return Preset(title, {X_SPACING: text, Y_SPACING: text})


def _frequencies() -> List[Preset]:
    bands = [
        Preset(
            verbatim(f"{start} - {stop}"),
            {"start_frequency_hz": str(start), "stop_frequency_hz": str(stop)},
        )
        for start, stop in FREQUENCY_BANDS_MHZ
        if start * HERTZ_PER_MEGAHERTZ >= MIN_FREQUENCY_HZ
        and stop * HERTZ_PER_MEGAHERTZ <= MAX_FREQUENCY_HZ
    ]
    counts = [
        Preset(Message("{count} points", count=count), {"frequency_points": str(count)})
        for count in FREQUENCY_POINTS
    ]
    return bands + counts


def _analyzer(field: str, context: PresetContext) -> List[Preset]:
    if field == ADDRESS:
        if not context.address:
            return []
        return [Preset(Message("As configured"), {ADDRESS: context.address})]
    if field == IF_BANDWIDTH:
        shown = [f"{one:.12g}" for one in IF_BANDWIDTHS_HZ if 100 <= one <= 100_000]
        shown = [text for text in shown if text.startswith("1")]
        return _choices(field, [(f"{text} Hz", text) for text in shown])
    if field == AVERAGES:
        return _choices(field, [(f"{text} x", text) for text in AVERAGES_SHOWN])
    return _choices(OUTPUT_POWER, [(text, text) for text in OUTPUT_POWERS])


def _choices(field: str, values: List[Tuple[str, str]]) -> List[Preset]:
    chosen = [Preset(verbatim(title), {field: text}) for title, text in values]
    return [Preset(AS_SET, {field: ""}), *chosen]
