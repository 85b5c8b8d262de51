"""Lists of places as CSV, JSON and GeoJSON, and maps of hidden targets as JSON.

A list holds the sentence that it is no clearance, whether the survey was simulated, and how the
places were found; a map, that it holds for its target only. Beside each file one that ends in
.sha256 is for `sha256sum -c`.
"""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any, Dict, Sequence, Tuple, Union

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, UnreadableFileError, check_ending
from gpr20_analysis.formats.dataset_files import csv_cell
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.files.regular_files import sum_of_file
from gpr20_survey.results.candidates import CandidateList, candidate_record, list_record
from gpr20_survey.results.hiding_map import HidingMap, hiding_from, hiding_json

CSV, JSON, GEOJSON = ".csv", ".json", ".geojson"
ENDINGS = (CSV, JSON, GEOJSON)
SUM = ".sha256"
COLUMNS = (
    *("id", "x_m", "y_m", "depth_m"),
    *("x_uncertainty_m", "y_uncertainty_m", "depth_uncertainty_m", "above_clutter_db"),
    *("rotations_deg", "polarization_ratio_db", "flags", "doubtful"),
    *("longitude_deg", "latitude_deg"),
)
Record = Dict[str, Any]
# A map has one place for about this many characters.
LARGEST_BYTES = 50_000_000


def write_candidates(found: CandidateList, path: Union[str, Path]) -> None:
    """Write a list of candidates in the format of the path's ending, and its checksum.

    Args:
        found: The list.
        path: The file; its ending is .csv, .json or .geojson.

    Raises:
        AnalysisError: The ending is unknown, the format needs a place on the earth that the survey
            does not have, or the output cannot be written.
    """
    path = Path(path)
    if path.suffix == GEOJSON and found.position is None:
        raise ExportError(
            Message(
                "{file} needs the survey's place on the earth, because GeoJSON has WGS 84 "
                "coordinates only; set it with {command}, or write another format",
                file=path.name,
                command="gpr20 annotate --position --heading",
            ),
            fault=NOT_ALLOWED,
        )
    records = [candidate_record(one, found) for one in found.candidates]
    write_list(path, list_record(found), "candidates", records, COLUMNS)


def write_list(
    path: Path, head: Record, name: str, records: Sequence[Record], columns: Sequence[str]
) -> None:
    """Write a list in the format of the path's ending, and its checksum.

    Args:
        path: The file; its ending is .csv, .json or .geojson.
        head: What holds for all of it.
        name: Key of the records in JSON.
        records: The places; each has an id, and a longitude and latitude, which may be None.
        columns: What CSV has of them.

    Raises:
        AnalysisError: The ending is unknown, or the output cannot be written.
    """
    check_ending(path, ENDINGS)
    if path.suffix == CSV:
        write_with_checksum(path, _csv(head, records, columns))
    elif path.suffix == GEOJSON:
        features = [_feature(one) for one in records]
        write_with_checksum(
            path, json_content({"type": "FeatureCollection", "features": features, "gpr20": head})
        )
    else:
        write_with_checksum(path, json_content({**head, name: records}))


def write_with_checksum(path: Path, text: str) -> None:
    """Write a file, and beside it its checksum for `sha256sum -c`.

    Raises:
        ExportError: The output cannot be written.
    """
    checksum_path = output_paths(path)[1]
    if checksum_path.exists():
        checksum_path.unlink()  # that of the former content must not stay if this is interrupted
    with atomic_output(path) as place:
        place.write_bytes(text.encode("utf-8"))
        checksum = sum_of_file(place).sha256
    with atomic_output(checksum_path) as place:
        place.write_text(f"{checksum}  {path.name}\n", encoding="utf-8")


def output_paths(path: Path) -> Tuple[Path, Path]:
    """Return the files that are written: the list and its checksum."""
    return path, path.with_name(path.name + SUM)


def json_content(values: Dict[str, Any]) -> str:
    """Return the content of a JSON file."""
    return json.dumps(values, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _feature(record: Record) -> Record:
    degrees = [record[name] for name in ("longitude_deg", "latitude_deg")]
    place = None
    # Without a place on the earth the geometry is null: x_m and y_m are in the properties.
    if None not in degrees:
        place = {"type": "Point", "coordinates": [round(one, 9) for one in degrees]}
    return {"type": "Feature", "id": record["id"], "geometry": place, "properties": record}


def _csv(head: Record, records: Sequence[Record], columns: Sequence[str]) -> str:
    lines = io.StringIO()
    for name, value in head.items():
        for one in value if isinstance(value, list) else [value]:
            text = one if isinstance(one, str) else json.dumps(one)
            lines.write(f"# {name}: {csv_cell(' '.join(text.split()))}\n")
    writer = csv.writer(lines)
    writer.writerow(columns)
    for record in records:
        writer.writerow([csv_cell(_flat(record[name])) for name in columns])
    return lines.getvalue()


def _flat(value: Any) -> Any:
    """Return a value as a cell holds it: flags and rotations are separated by spaces."""
    if isinstance(value, list):
        return " ".join(f"{one:g}" if isinstance(one, float) else one for one in value)
    return int(value) if isinstance(value, bool) else value


def write_hiding(found: HidingMap, path: Union[str, Path]) -> None:
    """Write a map, and its checksum.

    Args:
        found: The map.
        path: The file; its ending is .json.

    Raises:
        AnalysisError: It has another ending, or cannot be written.
    """
    check_ending(Path(path), (JSON,))
    write_with_checksum(Path(path), hiding_json(found))


def read_hiding(path: Union[str, Path]) -> HidingMap:
    """Return the map in a JSON file that `gpr20 hiding` wrote.

    Raises:
        UnreadableFileError: It is no such file.
        OSError: It cannot be read.
    """
    path = Path(path)
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
