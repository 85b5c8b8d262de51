"""A summary of a survey in a few lines."""

from __future__ import annotations

import json
from typing import Any, Dict, Iterator, List, Mapping, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import Quality, mapping_of, objects_of
from gpr20_analysis.read.survey_attributes import (
    ANTENNA_DELAY,
    ANTENNA_SEPARATION,
    AVERAGES,
    HEADING,
    IF_BANDWIDTH,
    NAME,
    NOTES,
    OPERATOR,
    OUTPUT_POWER,
    SITE,
    position_text,
)
from gpr20_common.message import Message, numeral, verbatim
from gpr20_common.sent_message import received_message
from gpr20_survey.folder.survey_metadata import REASON_MESSAGE
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.plan.recorded_plan import REFINES
from gpr20_survey.trace.sweep import CalibrationStatus
from gpr20_survey.trace.utc_time import moment_text

MM, NS, MHZ = 1e-3, 1e-9, 1e6
PLANNED = ("start_mm", "stop_mm", "points")
SAME_STEP = 0.02  # two motor steps [mm], or far less than a step of a sweep [MHz]
SIMULATED = Message("SIMULATED: the data show no real ground")
RECORDED = {
    NAME: Message("survey name"),
    "survey_id": Message("survey id"),
    "source": Message("source"),
    "started": Message("started"),
    "ended": Message("ended"),
    "outcome": Message("outcome"),
    "reason": Message("reason"),
    "software_revision": Message("software revision"),
    OPERATOR: Message("operator"),
    SITE: Message("site"),
    NOTES: Message("survey notes"),
    REFINES: Message("refines survey"),
    MARKERS: Message("markers"),
    IF_BANDWIDTH: Message("IF bandwidth"),
    AVERAGES: Message("averages"),
    OUTPUT_POWER: Message("output power"),
}
MOMENTS = ("started", "ended")
POSITION = Message("WGS 84 position")
HEADING_OF_Y = Message("heading of Y")
OUTCOMES = {
    "finished": Message("finished"),
    "stopped": Message("stopped"),
    "failed": Message("failed"),
    "interrupted": Message("interrupted"),
}
CALIBRATIONS = {str(one.meaning): one.meaning for one in CalibrationStatus}
INSTRUMENT = {
    "identity": Message("VNA"),
    "address": Message("VNA address"),
    "calibration": Message("VNA calibration"),
}

Row = Tuple[Message, Message]
"""Title and text."""


def summarize(survey: xr.Dataset) -> Dict[str, str]:
    """Return a summary of a survey or an image, in English.

    Args:
        survey: Dataset of a survey or of an image.

    Returns:
        Title and text of each line.
    """
    lines = {str(title): str(text) for title, text in summary_of(survey)}
    # Programs read them too.
    return {**lines, **{name: str(survey.attrs[name]) for name in MOMENTS if name in survey.attrs}}


def heading_text(heading_deg: float) -> Message:
    """Return a heading with its unit."""
    return Message("{angle_deg:g} deg", angle_deg=heading_deg)


def summary_of(survey: xr.Dataset) -> List[Row]:
    """Return the lines of a survey's summary."""
    return list(_lines(survey))


def _lines(survey: xr.Dataset) -> Iterator[Row]:
    known, described = survey.attrs, dataset.description_of(survey)
    for name, title in RECORDED.items():
        if name in known:
            yield title, _recorded(name, known[name], described)
    position = position_text(known)
    if position:
        yield POSITION, verbatim(position)
    if HEADING in known:
        yield HEADING_OF_Y, heading_text(float(known[HEADING]))
    if "simulated" in known:
        yield Message("ground"), SIMULATED if known["simulated"] else Message("measured")
    if dataset.QUALITY in survey:
        yield Message("samples"), _samples(survey[dataset.QUALITY].values)
    if dataset.IMAGE in survey:
        method = known.get("method", Message("unknown method"))
        yield Message("method"), Message("{value}", value=method)
        permittivity = known.get("permittivity", Message("unknown"))
        yield Message("permittivity"), Message("{value}", value=permittivity)
        yield Message("depth"), _axis(survey[dataset.DEPTH].values, MM, "mm")
    turns = (f"{one:g}°" for one in survey[dataset.POLARIZATION].values)
    yield Message("polarizations"), verbatim(", ".join(turns))
    for axis in (dataset.X, dataset.Y):
        yield verbatim(axis), _axis(survey[axis].values, MM, "mm")
        planned = [mapping_of(described, "parameters").get(f"{axis}_{end}") for end in PLANNED]
        if None not in planned:
            texts = dict(zip(PLANNED, planned))
            text = Message("{points} stops from {start_mm} to {stop_mm} mm", **texts)
            yield Message("planned {axis}", axis=axis), text
    if dataset.FREQUENCY in survey.coords:
        yield Message("frequency"), _axis(survey[dataset.FREQUENCY].values, MHZ, "MHz")
    instrument = mapping_of(described, "instrument")
    for name, title in INSTRUMENT.items():
        if name in instrument:
            own = Message("{value}", value=instrument[name])
            yield title, CALIBRATIONS.get(str(instrument[name]), own)
    if dataset.HEIGHT in survey:
        yield Message("height"), _spread(survey[dataset.HEIGHT].values / MM, "mm")
    for name in dataset.aux_names(survey):
        sensor = Message("sensor {name}", name=name[len(dataset.AUX_PREFIX) :])
        yield sensor, _spread(survey[name].values, str(survey[name].attrs.get("units", "")))
    if dataset.S21 in survey or dataset.A_SCAN in survey:
        yield Message("time zero"), _known(known, ANTENNA_DELAY, NS, "ns")
        yield Message("antenna distance"), _known(known, ANTENNA_SEPARATION, MM, "mm")
    yield Message("size"), Message("{size_mb:.1f} MB", size_mb=survey.nbytes / 1e6)


def _recorded(name: str, value: object, described: Mapping[str, Any]) -> Message:
    if name in MOMENTS:
        return moment_text(str(value))
    if name == "reason":
        return received_message(str(value), described.get(REASON_MESSAGE))
    if name == IF_BANDWIDTH:
        return Message("{bandwidth:.12g} Hz", bandwidth=float(str(value)))
    return OUTCOMES.get(str(value), verbatim(str(value)))


def _known(attributes: Mapping[str, Any], name: str, scale: float, unit: str) -> Message:
    """Return what is recorded of the antennas, or what is assumed."""
    if name not in attributes:
        return Message("not recorded; 0 is used")
    return Message("{value:.5g} {unit}", value=float(attributes[name]) / scale, unit=unit)


def _samples(quality: np.ndarray) -> Message:
    flags = {
        "missing": Quality.MISSING,
        "damaged": Quality.DAMAGED,
        "blind": Quality.NO_HEIGHT,
        "remarked": Quality.REMARKED,
        "unusable": dataset.UNUSABLE,
    }
    counts = {name: int(np.count_nonzero(quality & int(flag))) for name, flag in flags.items()}
    return Message(
        "{usable} of {total} of the grid ({missing} missing, {damaged} damaged, {blind} without "
        "height, {remarked} remarked)",
        usable=quality.size - counts["unusable"],
        total=quality.size,
        **counts,
    )


def _axis(values: np.ndarray, scale: float, unit: str) -> Message:
    known = values / scale
    ends = Message(
        "{count} from {first:g} to {last:g} {unit}",
        count=len(known),
        first=known[0],
        last=known[-1],
        unit=unit,
    )
    if len(known) < 2:
        return ends
    spacings = np.diff(known)
    step = numeral(spacings.mean(), ".5g")
    if np.ptp(spacings) >= SAME_STEP:
        low, high = spacings.min(), spacings.max()
        step = Message("{low:.5g} to {high:.5g}", low=low, high=high)
    return Message("{range}, every {step} {unit}", range=ends, step=step, unit=unit)


def _spread(values: np.ndarray, unit: str) -> Message:
    """Return lowest, highest and mean of what a sensor measured, and on how many samples."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Message("not measured")
    return Message(
        "{lowest:.4g} to {highest:.4g} {unit}, mean {mean:.4g} {unit} (samples: {count})",
        lowest=known.min(),
        highest=known.max(),
        mean=known.mean(),
        unit=unit,
        count=known.size,
    )


def warnings_of(survey: xr.Dataset) -> List[Message]:
    """Return what the operator was warned of during the survey; none without survey.json."""
    return [
        Message(
            "warning of the robot at {time}: {warning}",
            time=moment_text(str(one.get("time"))),
            warning=received_message(
                str(one.get("warning")), json.dumps(one.get("warning_message"))
            ),
        )
        for one in objects_of(mapping_of(dataset.description_of(survey), "report"), "warnings")
    ]
