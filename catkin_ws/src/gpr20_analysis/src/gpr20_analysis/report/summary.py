"""A summary of a survey in a few lines, and its settings."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.dataset import mapping_of, objects_of
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
from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import received_message
from gpr20_survey.folder.survey_metadata import REASON_MESSAGE
from gpr20_survey.plan.markers import MARKERS
from gpr20_survey.plan.recorded_plan import REFINES
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.utc_time import moment_text

MM, NS, GHZ, MHZ = 1e-3, 1e-9, 1e9, 1e6
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
}
MOMENTS = ("started", "ended")
POSITION = Message("WGS 84 position")
HEADING_OF_Y = Message("heading of Y")
CALIBRATIONS = {str(one.meaning): one.meaning for one in CalibrationStatus}
OUTCOMES = {
    "finished": Message("finished"),
    "stopped": Message("stopped"),
    "failed": Message("failed"),
    "interrupted": Message("interrupted"),
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
    described = dataset.description_of(survey)
    rows = [
        (title, _recorded(name, survey.attrs[name], described))
        for name, title in RECORDED.items()
        if name in survey.attrs
    ]
    position = position_text(survey.attrs)
    if position:
        rows.append((POSITION, verbatim(position)))
    if HEADING in survey.attrs:
        rows.append((HEADING_OF_Y, heading_text(float(survey.attrs[HEADING]))))
    if "simulated" in survey.attrs:
        ground = SIMULATED if survey.attrs["simulated"] else Message("measured")
        rows.append((Message("ground"), ground))
    if dataset.QUALITY in survey:
        rows.append((Message("samples"), _samples(survey)))
    if dataset.IMAGE in survey:
        rows.append((Message("image"), _image(survey)))
        rows.append((Message("depth"), _axis(survey[dataset.DEPTH].values)))
    turns_deg = survey[dataset.POLARIZATION].values
    turns = [Message("{rotation_deg:g} deg", rotation_deg=one) for one in turns_deg]
    rows.append((Message("polarizations"), _listed(turns)))
    rows.append((verbatim("x"), _axis(survey[dataset.X].values)))
    rows.append((verbatim("y"), _axis(survey[dataset.Y].values)))
    if dataset.FREQUENCY in survey.coords:
        rows.append((Message("frequency"), _frequency(survey[dataset.FREQUENCY].values)))
    rows += _rows(mapping_of(described, "instrument"), {"identity": Message("VNA")})
    rows += _analyzer_settings(survey.attrs)
    if dataset.HEIGHT in survey:
        rows.append((Message("height"), _height(survey[dataset.HEIGHT].values)))
    if dataset.S21 in survey or dataset.A_SCAN in survey:
        rows.append((Message("time zero"), _known(survey.attrs, ANTENNA_DELAY, NS, "ns")))
        apart = _known(survey.attrs, ANTENNA_SEPARATION, MM, "mm")
        rows.append((Message("antenna distance"), apart))
    rows.append((Message("size"), Message("{size_mb:.1f} MB", size_mb=survey.nbytes / 1e6)))
    return rows


def _known(attributes: Mapping[str, Any], name: str, scale: float, unit: str) -> Message:
    """Return what is recorded of the antennas, or what is assumed."""
    if name not in attributes:
        return Message("not recorded; 0 is used")
    return Message("{value:.5g} {unit}", value=float(attributes[name]) / scale, unit=unit)


def _recorded(name: str, value: object, described: Mapping[str, Any]) -> Message:
    text = moment_text(str(value)) if name in MOMENTS else verbatim(str(value))
    if name == "reason":
        return received_message(str(value), described.get(REASON_MESSAGE))
    return OUTCOMES.get(str(value), text) if name == "outcome" else text


def _verdict(described: Mapping[str, Any]) -> Optional[Message]:
    report = mapping_of(described, "report")
    if not report.get("verdict"):
        return None
    return received_message(str(report["verdict"]), report.get("verdict_message"))


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


def _samples(survey: xr.Dataset) -> Message:
    quality = survey[dataset.QUALITY].values
    usable = int(np.count_nonzero((quality & int(dataset.UNUSABLE)) == 0))
    text = Message("{usable} of {total} of the grid", usable=usable, total=quality.size)
    missing, damaged, no_height, remarked = (
        int(np.count_nonzero(quality & int(flag)))
        for flag in (
            dataset.Quality.MISSING,
            dataset.Quality.DAMAGED,
            dataset.Quality.NO_HEIGHT,
            dataset.Quality.REMARKED,
        )
    )
    counts = [
        (missing, Message("{count} missing", count=missing)),
        (damaged, Message("{count} damaged", count=damaged)),
        (no_height, Message("{count} no height", count=no_height)),
        (remarked, Message("{count} remarked", count=remarked)),
    ]
    return _listed([text, *(message for count, message in counts if count)])


def _listed(messages: Sequence[Message]) -> Message:
    text = messages[0]
    for one in messages[1:]:
        text = Message("{before}, {next}", before=text, next=one)
    return text


def _image(survey: xr.Dataset) -> Message:
    return Message(
        "{method}, relative permittivity {permittivity}",
        method=survey.attrs.get("method", Message("unknown method")),
        permittivity=survey.attrs.get("permittivity", Message("unknown")),
    )


def _axis(values_m: np.ndarray) -> Message:
    ends = Message(
        "{count} from {first_mm:g} to {last_mm:g} mm",
        count=len(values_m),
        first_mm=values_m[0] / MM,
        last_mm=values_m[-1] / MM,
    )
    if len(values_m) < 2:
        return ends
    spacings = np.diff(values_m) / MM
    if np.ptp(spacings) < 0.02:  # two motor steps [mm]
        return Message("{range}, every {step_mm:.4g} mm", range=ends, step_mm=spacings.mean())
    return Message(
        "{range}, every {smallest_mm:.4g} to {largest_mm:.4g} mm",
        range=ends,
        smallest_mm=spacings.min(),
        largest_mm=spacings.max(),
    )


def _frequency(values_hz: np.ndarray) -> Message:
    step = (values_hz[-1] - values_hz[0]) / max(len(values_hz) - 1, 1)
    return Message(
        "{count} from {first_ghz:g} to {last_ghz:g} GHz, every {step_mhz:.5g} MHz",
        count=len(values_hz),
        first_ghz=values_hz[0] / GHZ,
        last_ghz=values_hz[-1] / GHZ,
        step_mhz=step / MHZ,
    )


def _analyzer_settings(attributes: Mapping[str, Any]) -> List[Row]:
    rows: List[Row] = []
    if IF_BANDWIDTH in attributes:
        bandwidth = Message("{bandwidth:.12g} Hz", bandwidth=float(attributes[IF_BANDWIDTH]))
        rows.append((Message("IF bandwidth"), bandwidth))
    for name, title in ((AVERAGES, Message("averages")), (OUTPUT_POWER, Message("output power"))):
        if name in attributes:
            rows.append((title, verbatim(str(attributes[name]))))
    return rows


def _height(values_m: np.ndarray) -> Message:
    known = values_m[np.isfinite(values_m)]
    if not known.size:
        return Message("not measured")
    return Message(
        "{lowest_mm:.4g} to {highest_mm:.4g} mm, mean {mean_mm:.4g} mm",
        lowest_mm=known.min() / MM,
        highest_mm=known.max() / MM,
        mean_mm=known.mean() / MM,
    )


INSTRUMENT = {
    "address": Message("VNA address"),
    "calibration": Message("VNA calibration"),
}
PLAN, ENDS = ("x", "y"), ("start_mm", "stop_mm", "points")
HZ_PER_GHZ = 1e9
SETTINGS = {
    "settle_s": Message("settling time before a sweep [s]"),
    "height_s": Message("duration of a height measurement [s]"),
    "attempts": Message("attempts before a pause"),
    "on_height_failure": Message("if the height cannot be measured"),
    "reference_interval_s": Message("time between visits of the first stop [s]"),
    "drift_limit_db": Message("largest drift of the amplitude [dB]"),
    "drift_limit_deg": Message("largest drift of the phase [deg]"),
}


def settings_of(survey: xr.Dataset) -> List[Row]:
    """Return title and text of each recorded setting; none without survey.json."""
    described = dataset.description_of(survey)
    parameters = mapping_of(described, "parameters")
    rows: List[Row] = []
    for axis in PLAN:
        start, stop, points = (parameters.get(f"{axis}_{end}") for end in ENDS)
        if points is not None:
            text = Message(
                "{count} stops from {start} to {stop} mm", count=points, start=start, stop=stop
            )
            rows.append((Message("planned {axis}", axis=axis), text))
    sweep = mapping_of(mapping_of(described, "instrument"), "sweep")
    ends: List[Any] = [sweep.get(key) for key in ("start_frequency_hz", "stop_frequency_hz")]
    if all(isinstance(end, (int, float)) for end in ends):
        start_ghz, stop_ghz = (end / HZ_PER_GHZ for end in ends)
        text = Message(
            "{count} points, {start_ghz:g} to {stop_ghz:g} GHz",
            count=sweep.get("points"),
            start_ghz=start_ghz,
            stop_ghz=stop_ghz,
        )
        rows.append((Message("sweep accepted by the VNA"), text))
    rows += _rows(mapping_of(described, "instrument"), INSTRUMENT)
    rows += _rows(mapping_of(described, "settings"), SETTINGS)
    for axis, own in mapping_of(described, "axes").items():
        unit = Message("deg") if own.get("type") == "ROT" else verbatim("mm")
        text = Message(
            "{lower} to {upper} {unit}, in steps of {step} {unit}",
            lower=own.get("min_coord"),
            upper=own.get("max_coord"),
            step=own.get("step_size"),
            unit=unit,
        )
        rows.append((Message("axis {axis}", axis=axis), text))
    verdict = _verdict(described)
    if verdict is not None:
        rows.append((Message("verdict of the robot"), verdict))
    return rows


def _rows(values: Mapping[str, Any], titles: Mapping[str, Message]) -> List[Row]:
    return [
        (title, CALIBRATIONS.get(str(values[key]), Message("{value}", value=values[key])))
        for key, title in titles.items()
        if key in values
    ]
