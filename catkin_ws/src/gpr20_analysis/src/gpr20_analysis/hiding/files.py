"""A map of where a target could hide as JSON, GeoJSON and GeoPackage.

Each has the warning that it holds for its target only; beside it a file .sha256 is for
`sha256sum -c`. JSON is what reports and windows read.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np

from gpr20_analysis.candidates.files import (
    GEOJSON,
    GPKG,
    JSON,
    require_place,
    write_with_checksum,
)
from gpr20_analysis.candidates.geopackage import POLYGON, Layer, write_geopackage
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import ExportError, UnreadableFileError, wrong_ending
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.results.candidates import SIMULATED
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap, hiding_from, hiding_json

# A map has one place for about this many characters.
LARGEST_BYTES = 50_000_000
Ring = List[Tuple[float, float]]


def write_hiding(found: HidingMap, path: Path) -> None:
    """Write a map in the format of the path's ending, and its checksum.

    Args:
        found: The map.
        path: The file; its ending is .json, .geojson or .gpkg.

    Raises:
        ExportError: The ending is unknown, or the format needs a place on the earth that the survey
            does not have.
    """
    check_hiding_path(path)
    require_place(path, found.position, WRITERS)
    write_with_checksum(path, lambda place: WRITERS[path.suffix](found, place))


def check_hiding_path(path: Path) -> None:
    """Check the ending of a path.

    Raises:
        ExportError: It is unknown.
    """
    if path.suffix not in WRITERS:
        raise ExportError(wrong_ending(path, tuple(WRITERS)))


def read_hiding(path: Path) -> HidingMap:
    """Return the map in a JSON file that `gpr20 hiding` wrote.

    Raises:
        UnreadableFileError: It is no such file.
        OSError: It cannot be read.
    """
    try:
        if path.stat().st_size > LARGEST_BYTES:
            raise InvalidValueError(Message("it is too large"))
        return hiding_from(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise UnreadableFileError(
            Message(
                "{path} is no map of gpr20 hiding: {reason}; make it again with gpr20 hiding -o "
                "FILE.json",
                path=path,
                reason=str(error),
            )
        ) from error


def _facts(found: HidingMap) -> List[Tuple[str, str]]:
    warnings = [str(ONLY_THIS), *([str(SIMULATED)] if found.simulated else [])]
    facts = [("warning", " ".join(warnings)), ("survey_id", found.survey_id)]
    return [*facts, *(("says", str(one)) for one in found.details)]


def _rows(found: HidingMap) -> List[Dict[str, Any]]:
    share, missed_m = found.share, found.missed_m
    rows = []
    for row, column in np.ndindex(*missed_m.shape):
        values = {
            "x_m": round(float(found.x_m[column]), 6),
            "y_m": round(float(found.y_m[row]), 6),
            "missed_from_m": _or_none(missed_m[row, column]),
        }
        for layer, depth_m in enumerate(found.depth_m):
            at, name = (layer, row, column), f"{MM_PER_M * depth_m:.0f}mm"
            values[f"found_{name}"] = _or_none(share[at])
            values[f"lowest_{name}"] = _or_none(found.lowest[at])
            values[f"highest_{name}"] = _or_none(found.highest[at])
        rows.append(values)
    return rows


def _rings(found: HidingMap) -> List[Ring]:
    """Return the corners of the cell of each place, in degrees if the area is on the earth."""
    half_x_m, half_y_m = (size_m / 2.0 for size_m in found.cell_m)
    rings = []
    for y_m, x_m in ((y, x) for y in found.y_m for x in found.x_m):
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
        ring = [(float(x_m + a * half_x_m), float(y_m + b * half_y_m)) for a, b in corners]
        rings.append([found.position.on_earth(*one) for one in ring] if found.position else ring)
    return rings


def _write_json(found: HidingMap, path: Path) -> None:
    path.write_text(hiding_json(found) + "\n", encoding="utf-8")


def _write_geojson(found: HidingMap, path: Path) -> None:
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "Polygon", "coordinates": [[[*one] for one in ring]]},
            "properties": row,
        }
        for ring, row in zip(_rings(found), _rows(found))
    ]
    says = [list(one) for one in _facts(found)]
    collection = {"type": "FeatureCollection", "features": features, "gpr20": says}
    text = json.dumps(collection, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _write_gpkg(found: HidingMap, path: Path) -> None:
    rows, facts = _rows(found), _facts(found)
    on_earth = found.position is not None
    layer = Layer("hiding", "hiding_facts", list(rows[0]), facts[0][1], on_earth, POLYGON)
    write_geopackage(path, layer, _rings(found), rows, facts)


def _or_none(value: float) -> Optional[float]:
    return None if np.isnan(value) else round(float(value), 6)


WRITERS: Dict[str, Callable[[HidingMap, Path], None]] = {
    JSON: _write_json,
    GEOJSON: _write_geojson,
    GPKG: _write_gpkg,
}
