"""A GeoPackage (OGC 12-128r19, version 1.4) with one layer of points, without a library.

A GeoPackage is an SQLite database with a few fixed tables. Only what a layer of points and a table
of text need is written.
"""

from __future__ import annotations

import contextlib
import sqlite3
import struct
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Dict, Optional, Sequence, Tuple

APPLICATION_ID, USER_VERSION = 0x47504B47, 10400
WGS84, UNKNOWN_CARTESIAN = 4326, -1
TEXTS = ("id", "flags", "rotations_deg")
LAYER, FACTS = "candidates", "candidate_list"
WGS84_DEFINITION = (
    'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,'
    'AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,'
    'AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],'
    'AUTHORITY["EPSG","4326"]]'
)
TABLES = """
CREATE TABLE gpkg_spatial_ref_sys (
    srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
    organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT
);
CREATE TABLE gpkg_contents (
    table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
    description TEXT DEFAULT '',
    last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
    min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
    CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id)
);
CREATE TABLE gpkg_geometry_columns (
    table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL,
    srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
    CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
    CONSTRAINT uk_gc_table_name UNIQUE (table_name),
    CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
    CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id)
);
CREATE TABLE candidate_list (
    fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL, value TEXT NOT NULL
);
"""


def write_geopackage(
    path: Path,
    columns: Sequence[str],
    rows: Sequence[Dict[str, Any]],
    facts: Sequence[Tuple[str, str]],
    description: str,
    on_earth: bool,
) -> None:
    """Write candidates as points, and a table of facts about all of them.

    Args:
        path: File to create.
        columns: Names of the values of a row; those of `TEXTS` are text, all others numbers.
        rows: Values by name; None is stored as NULL.
        facts: Names and texts of the table `candidate_list`.
        description: Description of the layer.
        on_earth: Points are `longitude_deg` and `latitude_deg`, in WGS 84; else `x_m` and `y_m`, in
            an undefined Cartesian system.

    Raises:
        OSError: It cannot be written.
    """
    srs = WGS84 if on_earth else UNKNOWN_CARTESIAN
    names = ("longitude_deg", "latitude_deg") if on_earth else ("x_m", "y_m")
    points = [(float(row[names[0]]), float(row[names[1]])) for row in rows]
    try:
        with contextlib.closing(sqlite3.connect(str(path))) as database, database:
            database.executescript(TABLES)
            database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            database.execute(f"PRAGMA user_version = {USER_VERSION}")
            _describe(database, srs, points, description)
            kinds = ", ".join(
                f'"{name}" {"TEXT" if name in TEXTS else "DOUBLE"}' for name in columns
            )
            database.execute(
                f"CREATE TABLE {LAYER} (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
                f"geom POINT, {kinds})"
            )
            marks = ", ".join("?" for _ in columns)
            listed = ", ".join(f'"{name}"' for name in columns)
            database.executemany(
                f"INSERT INTO {LAYER} (geom, {listed}) VALUES (?, {marks})",
                [
                    (_geometry(srs, point), *(row[name] for name in columns))
                    for point, row in zip(points, rows)
                ],
            )
            database.executemany(
                f"INSERT INTO {FACTS} (name, value) VALUES (?, ?)",
                facts,
            )
    except sqlite3.Error as error:
        raise OSError(str(error)) from error


def _describe(
    database: sqlite3.Connection,
    srs: int,
    points: Sequence[Tuple[float, float]],
    description: str,
) -> None:
    database.executemany(
        "INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)",
        [
            ("WGS 84 geodetic", WGS84, "EPSG", WGS84, WGS84_DEFINITION, "longitude, latitude"),
            ("Undefined Cartesian SRS", -1, "NONE", -1, "undefined", "metres in the survey's area"),
            ("Undefined geographic SRS", 0, "NONE", 0, "undefined", None),
        ],
    )
    bounds: Tuple[Optional[float], ...] = (None,) * 4
    if points:
        x, y = zip(*points)
        bounds = (min(x), min(y), max(x), max(y))
    now = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    now = now[:-4] + "Z"
    database.executemany(
        "INSERT INTO gpkg_contents VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        [
            (LAYER, "features", LAYER, description, now, *bounds, srs),
            (FACTS, "attributes", FACTS, description, now, None, None, None, None, None),
        ],
    )
    database.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', 'POINT', ?, 0, 0)", (LAYER, srs)
    )


def _geometry(srs: int, point: Tuple[float, float]) -> bytes:
    """Return a point as GeoPackage binary: header without envelope, then WKB, little-endian."""
    return struct.pack("<2sBBi", b"GP", 0, 1, srs) + struct.pack("<BIdd", 1, 1, *point)
