"""A map of where a target could hide as JSON and GeoJSON.

Each has the warning that it holds for its target only; beside it a file .sha256 is for
`sha256sum -c`. JSON is what reports and windows read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from gpr20_analysis.candidates.files import (
    GEOJSON,
    JSON,
    check_ending,
    json_content,
    require_place,
    write_with_checksum,
)
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidates import SIMULATED
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap, hiding_from, hiding_json

ENDINGS = (JSON, GEOJSON)
# A map has one place for about this many characters.
LARGEST_BYTES = 50_000_000
Ring = List[Tuple[float, float]]


def write_hiding(found: HidingMap, path: Union[str, Path]) -> None:
    """Write a map in the format of the path's ending, and its checksum.

    Args:
        found: The map.
        path: The file; its ending is .json or .geojson.

    Raises:
        ExportError: The ending is unknown, or the format needs a place on the earth that the survey
            does not have.
    """
    path = Path(path)
    check_ending(path, ENDINGS)
    require_place(path, found.position)
    write_with_checksum(path, _geojson(found) if path.suffix == GEOJSON else hiding_json(found))


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


def _rings(found: HidingMap, position: AreaPosition) -> List[Ring]:
    """Return the corners of the cell of each place [deg]."""
    half_x_m, half_y_m = (size_m / 2.0 for size_m in found.cell_m)
    rings = []
    for y_m, x_m in ((y, x) for y in found.y_m for x in found.x_m):
        corners = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
        ring = [(float(x_m + a * half_x_m), float(y_m + b * half_y_m)) for a, b in corners]
        rings.append([position.on_earth(*one) for one in ring])
    return rings


def _geojson(found: HidingMap) -> str:
    assert found.position is not None
    features = [
        {
            "type": "Feature",
            "geometry": {"type": "Polygon", "coordinates": [[[*one] for one in ring]]},
            "properties": row,
        }
        for ring, row in zip(_rings(found, found.position), _rows(found))
    ]
    warnings = [str(ONLY_THIS), *([str(SIMULATED)] if found.simulated else [])]
    facts = {
        "warning": " ".join(warnings),
        "survey_id": found.survey_id,
        "says": [str(one) for one in found.details],
    }
    return json_content({"type": "FeatureCollection", "features": features, "gpr20": facts})


def _or_none(value: float) -> Optional[float]:
    return None if np.isnan(value) else round(float(value), 6)
