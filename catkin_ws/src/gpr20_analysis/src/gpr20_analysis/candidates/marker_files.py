"""The markers of a survey as CSV, JSON and GeoJSON; beside each a file for `sha256sum -c`."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable, Dict, List

from gpr20_analysis.candidates.files import write_with_checksum
from gpr20_analysis.candidates.marker_list import MarkerList
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_analysis.formats.plain_csv import csv_cell
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED

FORMAT = "gpr20-markers/1"
COLUMNS = (
    *("id", "x_m", "y_m", "depth_m", "text", "author", "time"),
    *("removed", "removed_by", "longitude_deg", "latitude_deg"),
)


def write_markers(found: MarkerList, path: Path) -> None:
    """Write markers in the format of the path's ending, and its checksum.

    Args:
        found: The markers.
        path: The file; its ending is .csv, .json or .geojson.

    Raises:
        ExportError: The ending is unknown, or the output cannot be written.
    """
    check_markers_path(path)
    text = WRITERS[path.suffix](found)
    write_with_checksum(path, lambda place: _write_text(place, text))


def check_markers_path(path: Path) -> None:
    """Check the ending of a path.

    Raises:
        ExportError: It is unknown.
    """
    if path.suffix not in WRITERS:
        raise ExportError(wrong_ending(path, tuple(WRITERS)))


def json_text(found: MarkerList) -> str:
    """Return the content of a JSON file."""
    markers = [_record(one, found) for one in found.markers]
    return _json({**_list_record(found), "markers": markers})


def _list_record(found: MarkerList) -> Dict[str, Any]:
    return {
        "format": FORMAT,
        "warning": str(NO_CLEARANCE),
        "simulated": found.simulated,
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        "survey_id": found.survey_id,
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "position": asdict(found.position) if found.position else None,
    }


def _record(marker: Marker, found: MarkerList) -> Dict[str, Any]:
    x_m, y_m = marker.x_mm / MM_PER_M, marker.y_mm / MM_PER_M
    longitude_deg, latitude_deg = (
        found.position.on_earth(x_m, y_m) if found.position else (None, None)
    )
    depth_mm = marker.depth_mm
    return {
        "id": marker.marker_id,
        "x_m": round(x_m, 6),
        "y_m": round(y_m, 6),
        "depth_m": None if depth_mm is None else round(depth_mm / MM_PER_M, 6),
        "text": marker.text,
        "author": marker.author,
        "time": marker.time,
        "removed": marker.removed,
        "removed_by": marker.removed_by,
        "longitude_deg": longitude_deg,
        "latitude_deg": latitude_deg,
    }


def _geojson(found: MarkerList) -> str:
    features: List[Dict[str, Any]] = []
    for one in found.markers:
        record = _record(one, found)
        place = None
        if found.position is not None:
            degrees = [round(record[name], 9) for name in ("longitude_deg", "latitude_deg")]
            place = {"type": "Point", "coordinates": degrees}
        # Without a place on the earth the geometry is null: x_m and y_m are in the properties.
        features.append(
            {"type": "Feature", "id": one.marker_id, "geometry": place, "properties": record}
        )
    return _json({"type": "FeatureCollection", "features": features, "gpr20": _list_record(found)})


def _csv(found: MarkerList) -> str:
    lines = io.StringIO()
    for name, value in _list_record(found).items():
        text = value if isinstance(value, str) else json.dumps(value)
        lines.write(f"# {name}: {csv_cell(' '.join(text.split()))}\n")
    writer = csv.writer(lines)
    writer.writerow(COLUMNS)
    for one in found.markers:
        record = _record(one, found)
        writer.writerow([csv_cell(record[name]) for name in COLUMNS])
    return lines.getvalue()


def _json(values: Dict[str, Any]) -> str:
    return json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _write_text(path: Path, text: str) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        stream.write(text)


WRITERS: Dict[str, Callable[[MarkerList], str]] = {
    ".csv": _csv,
    ".json": json_text,
    ".geojson": _geojson,
}
