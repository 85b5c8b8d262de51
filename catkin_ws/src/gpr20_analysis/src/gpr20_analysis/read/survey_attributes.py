"""What a survey's description and its traces say, as attributes and variables of its Dataset."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_analysis.dataset import (
    AUX_PREFIX,
    DISPLAY_ONLY,
    MM_PER_M,
    POLARIZATION,
    PROCESSING,
    SAMPLE_DIMS,
)
from gpr20_analysis.sentences import DOUBTS, kept_doubts, sentences_of
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_survey.plan.annotation import annotation_of
from gpr20_survey.plan.markers import MARKERS, present_markers
from gpr20_survey.plan.recorded_plan import ANTENNA_DELAYS_NS
from gpr20_survey.results.candidates import AreaPosition
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import AuxValue

if TYPE_CHECKING:
    import xarray as xr

    from gpr20_analysis.read.traces import Sample

NAME, OPERATOR, SITE, NOTES = "survey_name", "operator", "site", "survey_notes"
LATITUDE, LONGITUDE, HEADING = "latitude_deg", "longitude_deg", "heading_deg"
OF_PEOPLE = (NAME, OPERATOR, SITE, NOTES, LATITUDE, LONGITUDE, HEADING)
"""What people add to a survey, also later."""
IF_BANDWIDTH, AVERAGES, OUTPUT_POWER = "if_bandwidth_hz", "averages", "output_power"
OF_ANALYZER = (IF_BANDWIDTH, AVERAGES, OUTPUT_POWER)
ANTENNA_DELAY = "antenna_delay_s"
"""Delay of cables and antennas that the spectra contain [s]; 0 if there is none."""
ANTENNA_SEPARATION = "antenna_separation_m"
"""Distance between the antennas [m]; images use it unless another one is given."""
WIDEST_SEPARATION_M = 2.0
# What the log of an imported survey keeps of its Dataset.
KEPT_TEXTS = ("survey_id", NAME, OPERATOR, SITE, NOTES, OUTPUT_POWER, PROCESSING, DISPLAY_ONLY)
KEPT_NUMBERS = (
    *(LATITUDE, LONGITUDE, IF_BANDWIDTH, AVERAGES),
    *(ANTENNA_DELAY, ANTENNA_SEPARATION),
)
GRID = ("polarization_deg", "y_mm", "x_mm")
S_PER_NS = 1e-9
DELAY_KEY = "antenna_delay_ns"


def survey_attributes(
    description: Mapping[str, Any], samples: Sequence[Sample], notes: List[Message]
) -> Dict[str, Any]:
    """Return the attributes; those of what is empty or not known are left out.

    Args:
        description: Content of survey.json.
        samples: Those of which the analyzer's settings are; what differs is no attribute, but a
            variable of the samples.
        notes: A remark on an entry that is not allowed is added here.
    """
    found: Dict[str, Any] = {}
    for read in (_of_people, _markers, _delay):
        try:
            found.update(read(description))
        except InvalidValueError as error:
            reason = error.message
            notes.append(Message("an entry of the log is left out: {reason}", reason=reason))
    settings = [asdict(one) for one, _count in known_settings(samples)]
    for name in OF_ANALYZER if settings else ():
        first, *others = {one[name] for one in settings}
        if first and not others:
            found[name] = first
    return found


def imported_entry(data: xr.Dataset) -> Dict[str, Any]:
    """Return what the log of an imported survey keeps, as values of JSON."""
    found: Dict[str, Any] = {one: str(data.attrs[one]) for one in KEPT_TEXTS if one in data.attrs}
    found.update({one: float(data.attrs[one]) for one in KEPT_NUMBERS if one in data.attrs})
    doubts = kept_doubts(sentences_of(data, DOUBTS))
    if doubts:
        found[DOUBTS] = "\n".join(doubts)
    for name, axis in zip(GRID, SAMPLE_DIMS):
        scale = 1.0 if axis == POLARIZATION else MM_PER_M
        found[name] = (data[axis].values.astype(float) * scale).tolist()
    return {**found, "notes": list(map(str, sentences_of(data, "notes")))}


def imported_attributes(entry: Mapping[str, Any]) -> Dict[str, Any]:
    """Return the attributes of an entry, except those of a wrong type."""
    found: Dict[str, Any] = {
        one: entry[one] for one in KEPT_TEXTS if isinstance(entry.get(one), str)
    }
    for one in KEPT_NUMBERS:
        value = entry.get(one)
        if isinstance(value, (int, float)) and np.isfinite(value):
            found[one] = float(value)
    return found


def known_settings(samples: Sequence[Sample]) -> List[Tuple[AnalyzerSettings, int]]:
    """Return the settings that are known, and of how many samples, those of most first."""
    known = (one["analyzer"] for one in samples if one["analyzer"] != AnalyzerSettings())
    return Counter(known).most_common()


def area_position(attributes: Mapping[str, Any]) -> Optional[AreaPosition]:
    """Return where the area of a survey is on the earth; None if that is not known."""
    names = (LATITUDE, LONGITUDE, HEADING)
    if not all(name in attributes for name in names):
        return None
    return AreaPosition(*(float(attributes[name]) for name in names))


def position_text(attributes: Mapping[str, Any]) -> str:
    """Return latitude and longitude [deg] as text; empty if they are not known."""
    if LATITUDE not in attributes or LONGITUDE not in attributes:
        return ""
    return f"{float(attributes[LATITUDE])!r}, {float(attributes[LONGITUDE])!r}"


def aux_variables(
    values: Sequence[Tuple[AuxValue, ...]], cells: Sequence[int], size: int, notes: List[Message]
) -> Dict[str, Tuple[np.ndarray, Dict[str, Any]]]:
    """Return the values and the attributes of each variable `aux_<name>`.

    Args:
        values: Those of each sample.
        cells: The place of each sample in the grid.
        size: Places of the grid; those without a value are NaN.
        notes: A remark on a sensor whose unit changed is added here; the values of its second
            unit are in the variable `aux_<name>_2`, and so on.
    """
    found: Dict[str, Tuple[np.ndarray, Dict[str, Any]]] = {}
    names: Dict[Tuple[str, str], str] = {}
    for cell, own in zip(cells, values):
        for one in own:
            key = one.name, one.unit
            if key not in names:
                free = (f"{AUX_PREFIX}{one.name}_{number}" for number in itertools.count(2))
                every = itertools.chain([f"{AUX_PREFIX}{one.name}"], free)
                names[key] = next(name for name in every if name not in found)
                found[names[key]] = np.full(size, np.nan), _attributes(one)
            found[names[key]][0][cell] = one.value
    for name, count in Counter(name for name, _unit in names).items():
        if count > 1:
            notes.append(
                Message(
                    "the sensor {sensor} was recorded with different units: {units}",
                    sensor=name,
                    units=", ".join(repr(unit) for own, unit in names if own == name),
                )
            )
    return found


def _attributes(one: AuxValue) -> Dict[str, Any]:
    attributes = {"long_name": f"sensor {one.name}"}
    # As a unit xarray would read it as that of moments.
    if " since " in one.unit:
        attributes["long_name"] += f" [{one.unit}]"
    elif one.unit:
        attributes["units"] = one.unit
    return attributes


def _of_people(description: Mapping[str, Any]) -> Dict[str, Any]:
    one = annotation_of(description)
    texts = {NAME: one.name, OPERATOR: one.operator, SITE: one.site, NOTES: one.notes}
    found: Dict[str, Any] = {name: text for name, text in texts.items() if text}
    if one.position is not None:
        found[LATITUDE] = one.position.latitude_deg
        found[LONGITUDE] = one.position.longitude_deg
    if one.heading_deg is not None:
        found[HEADING] = one.heading_deg
    return found


def _markers(description: Mapping[str, Any]) -> Dict[str, Any]:
    count = len(present_markers(description))
    return {MARKERS: count} if count else {}


@dataclass(frozen=True)
class _Analyzer:
    antenna_delay_ns: float = bounded(*ANTENNA_DELAYS_NS, 0.0)


def _delay(description: Mapping[str, Any]) -> Dict[str, Any]:
    section = description.get("analyzer", {})
    delay_ns = record_from(_Analyzer, section, "analyzer", others=True).antenna_delay_ns
    return {ANTENNA_DELAY: delay_ns * S_PER_NS} if delay_ns else {}
