"""A list of candidates as CSV, JSON, GeoJSON and GeoPackage.

Each file holds the sentence that the list is no clearance, whether the survey was simulated, and
how the candidates were found; beside it a file .sha256 is for `sha256sum -c`.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Optional, Tuple

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.candidates.geopackage import Layer, write_geopackage
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_analysis.formats.plain_csv import csv_cell
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.files.file_sums import sum_of_file
from gpr20_survey.results.area_position import AreaPosition
from gpr20_survey.results.candidates import (
    NO_CLEARANCE,
    SIMULATED,
    CandidateList,
    candidate_record,
    json_text,
    list_record,
)

CSV, JSON, GEOJSON, GPKG = ".csv", ".json", ".geojson", ".gpkg"
SUM = ".sha256"


def write_candidates(found: CandidateList, path: Path) -> None:
    """Write a list of candidates in the format of the path's ending, and its checksum.

    Args:
        found: The list.
        path: The file; its ending is .csv, .json, .geojson or .gpkg.

    Raises:
        ExportError: The ending is unknown, the format needs a place on the earth that the survey
            does not have, or the output cannot be written.
    """
    check_candidates_path(path)
    require_place(path, found.position, WRITERS)
    write_with_checksum(path, lambda place: WRITERS[path.suffix](found, place))


def require_place(path: Path, position: Optional[AreaPosition], endings: Iterable[str]) -> None:
    """Check that a survey that is written as GeoJSON has a place on the earth.

    Raises:
        ExportError: It has none.
    """
    if path.suffix == GEOJSON and position is None:
        raise ExportError(
            Message(
                "{file} needs the survey's place on the earth, because GeoJSON has WGS 84 "
                "coordinates only; set it with {command}, or write {others}",
                file=path.name,
                command="gpr20 annotate --position --heading",
                others=", ".join(one for one in endings if one != GEOJSON),
            ),
            fault=NOT_ALLOWED,
        )


def write_with_checksum(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file, and beside it its checksum for `sha256sum -c`.

    Raises:
        ExportError: The output cannot be written.
    """
    checksum_path = output_paths(path)[1]
    if checksum_path.exists():
        checksum_path.unlink()  # that of the former content must not stay if this is interrupted
    with atomic_output(path) as place:
        write(place)
        checksum = sum_of_file(place).sha256
    with atomic_output(checksum_path) as place:
        place.write_text(f"{checksum}  {path.name}\n", encoding="utf-8")


def output_paths(path: Path) -> Tuple[Path, Path]:
    """Return the files that are written: the list and its checksum."""
    return path, path.with_name(path.name + SUM)


def check_candidates_path(path: Path) -> None:
    """Check the ending of a path.

    Raises:
        ExportError: It is unknown.
    """
    if path.suffix not in WRITERS:
        raise ExportError(wrong_ending(path, tuple(WRITERS)))


def _write_json(found: CandidateList, path: Path) -> None:
    path.write_text(json_text(found) + "\n", encoding="utf-8")


def _write_geojson(found: CandidateList, path: Path) -> None:
    features = []
    for one in found.candidates:
        record = candidate_record(one, found)
        place = [round(record[name], 9) for name in ("longitude_deg", "latitude_deg")]
        features.append(
            {
                "type": "Feature",
                "id": one.id,
                "geometry": {"type": "Point", "coordinates": place},
                "properties": record,
            }
        )
    collection = {"type": "FeatureCollection", "features": features, "gpr20": list_record(found)}
    text = json.dumps(collection, indent=2, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _write_csv(found: CandidateList, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        for name, value in list_record(found).items():
            for one in value if isinstance(value, list) else [value]:
                text = one if isinstance(one, str) else json.dumps(one)
                stream.write(f"# {name}: {csv_cell(' '.join(text.split()))}\n")
        writer = csv.writer(stream)
        writer.writerow(COLUMNS)
        for one in found.candidates:
            record = _flat(candidate_record(one, found))
            writer.writerow([csv_cell(record[name]) for name in COLUMNS])


def _write_gpkg(found: CandidateList, path: Path) -> None:
    rows = [_flat(candidate_record(one, found)) for one in found.candidates]
    facts: List[Tuple[str, str]] = []
    for name, value in list_record(found).items():
        several = value if isinstance(value, list) else [value]
        facts += [(name, one if isinstance(one, str) else json.dumps(one)) for one in several]
    warnings = [str(NO_CLEARANCE), *([str(SIMULATED)] if found.simulated else [])]
    on_earth = found.position is not None
    layer = Layer("candidates", "candidate_list", COLUMNS, " ".join(warnings), on_earth)
    names = ("longitude_deg", "latitude_deg") if on_earth else ("x_m", "y_m")
    places = [[(float(row[names[0]]), float(row[names[1]]))] for row in rows]
    write_geopackage(path, layer, places, rows, facts)


def _flat(record: Dict[str, Any]) -> Dict[str, Any]:
    turns = ["combined" if one is None else f"{one:g}" for one in record["rotations_deg"]]
    texts = {"flags": " ".join(record["flags"]), "rotations_deg": " ".join(turns)}
    return {**record, **texts, "doubtful": int(record["doubtful"])}


COLUMNS = (
    *("id", "x_m", "y_m", "depth_m"),
    *("x_uncertainty_m", "y_uncertainty_m", "depth_uncertainty_m"),
    *("above_clutter_db", "false_alarms_per_m2"),
    *(
        "rotations_deg",
        "polarization_ratio_db",
        "flags",
        "doubtful",
        "longitude_deg",
        "latitude_deg",
    ),
)
WRITERS: Dict[str, Callable[[CandidateList, Path], None]] = {
    CSV: _write_csv,
    JSON: _write_json,
    GEOJSON: _write_geojson,
    GPKG: _write_gpkg,
}
