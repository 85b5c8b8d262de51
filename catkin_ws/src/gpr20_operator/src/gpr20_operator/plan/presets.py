"""Values to choose with one touch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Iterable, List, Mapping, Optional

from gpr20_common.message import Message, verbatim
from gpr20_operator.words import number_text
from gpr20_survey.plan.survey_parameters import RobotTravel, coordinate_limits_mm
from gpr20_survey.radar.soils import Soils

AREA_FIELDS = ("x_start_mm", "x_stop_mm", "y_start_mm", "y_stop_mm")
SMALL_AREA_MM = 300.0


@dataclass(frozen=True)
class Preset:
    """What a touch fills in: its title, and the new texts by the name of the field."""

    title: Message
    texts: Mapping[str, str]


# From the robot's axes, and a quarter wavelength in the soil [mm], None where it is not known.
Presets = Callable[[RobotTravel, Optional[float]], List[Preset]]


def areas(travel: RobotTravel, _quarter_mm: Optional[float]) -> List[Preset]:
    """Return the areas: all of the robot, and a small one in its middle."""
    whole_mm: List[float] = []
    middle_mm: List[float] = []
    for axis in (travel.x, travel.y):
        lower, upper = coordinate_limits_mm(axis)
        # Whole millimetres; a small axis has less than this area.
        start = max(lower, math.floor((lower + upper - SMALL_AREA_MM) / 2.0))
        whole_mm += [lower, upper]
        middle_mm += [start, min(upper, start + SMALL_AREA_MM)]
    size = {"width": f"{SMALL_AREA_MM:g}", "height": f"{SMALL_AREA_MM:g}"}
    areas = (
        (Message("Whole robot"), whole_mm),
        (Message("{width} x {height} centre", **size), middle_mm),
    )
    return [
        Preset(title, dict(zip(AREA_FIELDS, map(number_text, ends_mm)))) for title, ends_mm in areas
    ]


def spacings(_travel: RobotTravel, quarter_mm: Optional[float]) -> List[Preset]:
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


def one_of(name: str, texts: Iterable[str], unit: str, *first: Preset) -> Presets:
    """Return the presets of one field: each text with its unit."""
    return _fixed(*first, *(Preset(verbatim(f"{text}{unit}"), {name: text}) for text in texts))


def as_set(name: str, texts: Iterable[str], unit: str = "") -> Presets:
    """Return the presets of a setting of the VNA: as it is, or one of some texts."""
    return one_of(name, texts, unit, Preset(Message("AS SET"), {name: ""}))


def _band(start: str, stop: str) -> Preset:
    ends = {"start_frequency_hz": start, "stop_frequency_hz": stop}
    return Preset(verbatim(f"{start} - {stop}"), ends)


FREQUENCIES = _fixed(
    _band("600", "6000"),
    _band("600", "3000"),
    *(
        Preset(Message("{count} points", count=count), {"frequency_points": str(count)})
        for count in (201, 501, 1001)
    ),
)
SOILS = _fixed(
    *(Preset(one.value.name, {"permittivity": f"{one.value.permittivity:g}"}) for one in Soils)
)
ADDRESSES = _fixed(Preset(Message("Robot's own"), {"vna_address": ""}))
