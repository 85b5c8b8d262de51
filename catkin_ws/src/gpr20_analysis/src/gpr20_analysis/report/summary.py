"""What is to be told of a survey in a few lines."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Mapping, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset

MM, GHZ, MHZ = 1e-3, 1e9, 1e6
SIMULATED = "SIMULATED: the data show no real ground"
WORDS = ("survey_id", "source", "started", "ended", "outcome", "reason", "software_revision")


def summarize(survey: xr.Dataset) -> Dict[str, str]:
    """Return title and text of what a survey holds, in the order of telling."""
    told = {
        word.replace("_", " "): str(survey.attrs[word]) for word in WORDS if word in survey.attrs
    }
    if "simulated" in survey.attrs:
        told["ground"] = SIMULATED if survey.attrs["simulated"] else "measured"
    if dataset.QUALITY in survey:
        told["samples"] = _samples(survey)
    if dataset.IMAGE in survey:
        told["image"] = (
            f"{survey.attrs.get('method', 'unknown method')}, relative permittivity "
            f"{survey.attrs.get('permittivity', 'unknown')}"
        )
        told["depth"] = _axis(survey[dataset.DEPTH].values)
    told["polarizations"] = ", ".join(f"{one:g} deg" for one in survey[dataset.POLARIZATION].values)
    told["x"] = _axis(survey[dataset.X].values)
    told["y"] = _axis(survey[dataset.Y].values)
    if dataset.FREQUENCY in survey.coords:
        told["frequency"] = _frequency(survey[dataset.FREQUENCY].values)
    if dataset.HEIGHT in survey:
        told["height"] = _height(survey[dataset.HEIGHT].values)
    told["size"] = f"{survey.nbytes / 1e6:.1f} MB"
    return told


def _samples(survey: xr.Dataset) -> str:
    quality = survey[dataset.QUALITY].values
    usable = int(np.count_nonzero((quality & int(dataset.UNUSABLE)) == 0))
    parts = [f"{usable} of {quality.size} of the grid"]
    for flag in (flag for flag in dataset.Quality if flag):
        count = int(np.count_nonzero(quality & int(flag)))
        if count:
            parts.append(f"{count} {str(flag.name).lower().replace('_', ' ')}")
    return ", ".join(parts)


def _axis(values_m: np.ndarray) -> str:
    text = f"{len(values_m)} from {values_m[0] / MM:g} to {values_m[-1] / MM:g} mm"
    if len(values_m) < 2:
        return text
    spacings = np.diff(values_m) / MM
    if np.ptp(spacings) < 0.02:  # two motor steps [mm]
        return f"{text}, every {spacings.mean():.4g} mm"
    return f"{text}, every {spacings.min():.4g} to {spacings.max():.4g} mm"


def _frequency(values_hz: np.ndarray) -> str:
    step = (values_hz[-1] - values_hz[0]) / max(len(values_hz) - 1, 1)
    return (
        f"{len(values_hz)} from {values_hz[0] / GHZ:g} to {values_hz[-1] / GHZ:g} GHz, every "
        f"{step / MHZ:.5g} MHz"
    )


def _height(values_m: np.ndarray) -> str:
    known = values_m[np.isfinite(values_m)]
    if not known.size:
        return "not measured"
    return f"{known.min() / MM:.4g} to {known.max() / MM:.4g} mm, mean {known.mean() / MM:.4g} mm"


INSTRUMENT = {"identity": "instrument", "address": "its address", "calibration": "its calibration"}
PLAN, ENDS = ("x", "y"), ("start_mm", "stop_mm", "points")
HZ_PER_GHZ = 1e9
SETTINGS = {
    "settle_s": "pause before a sweep [s]",
    "height_s": "time of a height measurement [s]",
    "attempts": "attempts before a pause",
    "on_height_failure": "if the height cannot be measured",
}


def settings_of(survey: xr.Dataset) -> List[Tuple[str, ...]]:
    """Return title and text of each setting that is recorded; none without survey.json."""
    described: Dict[str, Any] = json.loads(survey.attrs.get("survey_json", "{}"))
    parameters = _mapping(described, "parameters")
    rows: List[Tuple[str, ...]] = []
    for axis in PLAN:
        start, stop, points = (parameters.get(f"{axis}_{end}") for end in ENDS)
        if points is not None:
            rows.append((f"planned {axis}", f"{points} stops from {start} to {stop} mm"))
    sweep = _mapping(_mapping(described, "instrument"), "sweep")
    ends: List[Any] = [sweep.get(key) for key in ("start_frequency_hz", "stop_frequency_hz")]
    if all(isinstance(end, (int, float)) for end in ends):
        start_ghz, stop_ghz = (end / HZ_PER_GHZ for end in ends)
        text = f"{sweep.get('points')} points, {start_ghz:g} to {stop_ghz:g} GHz"
        rows.append(("sweep as accepted", text))
    rows += _rows(_mapping(described, "instrument"), INSTRUMENT)
    rows += _rows(_mapping(described, "settings"), SETTINGS)
    for axis, own in _mapping(described, "axes").items():
        unit = "deg" if own.get("type") == "ROT" else "mm"
        limits = [own.get(key) for key in ("min_coord", "max_coord", "step_size")]
        rows.append(
            (f"axis {axis}", "{} to {} {unit}, in steps of {} {unit}".format(*limits, unit=unit))
        )
    verdict = _mapping(described, "report").get("verdict")
    return rows + ([("the robot's own verdict", str(verdict))] if verdict else [])


def _mapping(described: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = described.get(key)
    return found if isinstance(found, dict) else {}


def _rows(values: Mapping[str, Any], titles: Mapping[str, str]) -> List[Tuple[str, ...]]:
    return [(title, str(values[key])) for key, title in titles.items() if key in values]
