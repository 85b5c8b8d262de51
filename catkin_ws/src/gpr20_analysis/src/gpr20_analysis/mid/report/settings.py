"""How a survey was measured, as its survey.json tells it."""

from __future__ import annotations

import json
from typing import Any, Dict, List, Mapping, Tuple

import xarray as xr

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
