"""Values to choose with one touch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Iterable, List, Mapping, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_survey.plan.survey_parameters import RobotTravel, coordinate_limits_mm
from gpr20_survey.radar.soils import Soils

SMALL_AREA_MM = 300.0
SPACINGS_MM = (5, 10, 15, 20, 25)
FREQUENCY_BANDS_MHZ = ((600, 6000), (600, 3000))
FREQUENCY_POINTS = (201, 501, 1001)
ROTATIONS_DEG = ("0", "90", "0, 90", "-45, 45")
AVERAGES = ("1", "4", "16")
AREA_FIELDS = ("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm")


@dataclass(frozen=True)
class Preset:
    """What a touch fills in: its title, and the new texts by the name of the field."""

    title: Message
    texts: Mapping[str, str]


@dataclass(frozen=True)
class PresetContext:
    """What presets depend on.

    Attributes:
        last_area: Texts of the area of the survey before; empty if there is none.
        address: Of the VNA in the robot's configuration; empty if it is not known.
        quarter_wavelength_mm: In the soil [mm]; None if frequencies or permittivity are wrong.
    """

    travel: RobotTravel
    last_area: Mapping[str, str]
    address: str
    quarter_wavelength_mm: Optional[float]


Presets = Callable[[PresetContext], List[Preset]]


def areas(context: PresetContext) -> List[Preset]:
    """Return the areas: all of the robot, two small ones, that of the survey before."""
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


def spacings(context: PresetContext) -> List[Preset]:
    """Return some distances of stops, and the coarsest one that suits the soil."""
    found = [_spacing(verbatim(f"{mm} mm"), mm) for mm in SPACINGS_MM]
    if context.quarter_wavelength_mm is not None:
        # Rounded down to a tenth: rounded up it would be too coarse.
        mm = math.floor(context.quarter_wavelength_mm * 10.0) / 10.0
        found.append(_spacing(Message("Soil: {spacing:g} mm", spacing=mm), mm))
    return found


def _spacing(title: Message, spacing_mm: float) -> Preset:
    return Preset(title, {f"{axis}_spacing_mm": f"{spacing_mm:g}" for axis in "xy"})


def frequencies(_context: PresetContext) -> List[Preset]:
    """Return bands and numbers of frequencies."""
    ends = ("start_frequency_hz", "stop_frequency_hz")
    bands = [
        Preset(verbatim(f"{start} - {stop}"), dict(zip(ends, (str(start), str(stop)))))
        for start, stop in FREQUENCY_BANDS_MHZ
    ]
    counts = [
        Preset(Message("{count} points", count=count), {"frequency_points": str(count)})
        for count in FREQUENCY_POINTS
    ]
    return bands + counts


def soils(_context: PresetContext) -> List[Preset]:
    """Return the soils."""
    return [
        Preset(soil.value.name, {"permittivity": f"{soil.value.permittivity:g}"}) for soil in Soils
    ]


def rotations(_context: PresetContext) -> List[Preset]:
    """Return usual rotations of the antennas."""
    return [Preset(verbatim(f"{text}°"), {"polarizations_deg": text}) for text in ROTATIONS_DEG]


def addresses(context: PresetContext) -> List[Preset]:
    """Return the address of the robot's configuration."""
    own = {"vna_address": context.address}
    return [Preset(Message("Robot's own"), own)] if context.address else []


def settings(field: str, texts: Iterable[str], unit: str = "") -> Presets:
    """Return the presets of a setting of the VNA: as it is, or one of some texts."""
    as_set = Preset(Message("AS SET"), {field: ""})
    chosen = [Preset(verbatim(f"{text} {unit}".strip()), {field: text}) for text in texts]
    return lambda _context: [as_set, *chosen]


# The decades.
IF_BANDWIDTHS = ("100", "1000", "10000", "100000")
