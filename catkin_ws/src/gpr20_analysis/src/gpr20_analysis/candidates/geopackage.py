"""A GeoPackage (OGC 12-128r19, version 1.4) with one layer, without a library.

A GeoPackage is an SQLite database with a few fixed tables. Only what a layer of points or polygons
and a table of text need is written.
"""

from __future__ import annotations

import contextlib
import sqlite3
import struct
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Dict, Optional, Sequence, Tuple

APPLICATION_ID, USER_VERSION = 0x47504B47, 10400
WGS84, UNKNOWN_CARTESIAN = 4326, -1
TEXTS = ("id", "flags", "rotations_deg")
POINT, POLYGON = 1, 3
"""Kinds of geometries, as well-known binary numbers them."""
Places = Sequence[Tuple[float, float]]
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
CREATE TABLE {facts} (
    fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL, value TEXT NOT NULL
);
"""


@dataclass(frozen=True)
class Layer:
    """A layer.

    Attributes:
        name: Its name.
        facts: Name of the table of facts about all of it.
        columns: Names of the values of a row; those of `TEXTS` are text, all others numbers.
        description: What it is.
        on_earth: Places are longitude and latitude, in WGS 84 [deg]; else X and Y in an undefined
            Cartesian system [m].
        kind: `POINT` or `POLYGON`.
    """

    name: str
    facts: str
    columns: Sequence[str]
    description: str
    on_earth: bool
    kind: int = POINT

    @property
    def srs(self) -> int:
        """Its system of coordinates."""
        return WGS84 if self.on_earth else UNKNOWN_CARTESIAN

    @property
    def kind_name(self) -> str:
        """The name of its geometries."""
        return "POINT" if self.kind == POINT else "POLYGON"


def write_geopackage(
    path: Path,
    layer: Layer,
    shapes: Sequence[Places],
    rows: Sequence[Dict[str, Any]],
    facts: Sequence[Tuple[str, str]],
) -> None:
    """Write a layer, and a table of facts about all of it.

    Args:
        path: File to create.
        layer: The layer.
        shapes: Of each row its place, or the corners of its polygon, the first one again last.
        rows: Values by name; None is stored as NULL.
        facts: Names and texts of the table of facts.

    Raises:
        OSError: It cannot be written.
    """
    try:
        with contextlib.closing(sqlite3.connect(str(path))) as database, database:
            database.executescript(TABLES.format(facts=layer.facts))
            database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            database.execute(f"PRAGMA user_version = {USER_VERSION}")
            _describe(database, layer, [place for shape in shapes for place in shape])
            kinds = ", ".join(
                f'"{name}" {"TEXT" if name in TEXTS else "DOUBLE"}' for name in layer.columns
            )
            database.execute(
                f"CREATE TABLE {layer.name} (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
                f"geom {layer.kind_name}, {kinds})"
            )
            marks = ", ".join("?" for _ in layer.columns)
            listed = ", ".join(f'"{name}"' for name in layer.columns)
            database.executemany(
                f"INSERT INTO {layer.name} (geom, {listed}) VALUES (?, {marks})",
                [
                    (_geometry(layer, shape), *(row[name] for name in layer.columns))
                    for shape, row in zip(shapes, rows)
                ],
            )
            database.executemany(
                f"INSERT INTO {layer.facts} (name, value) VALUES (?, ?)",
                facts,
            )
    except sqlite3.Error as error:
        raise OSError(str(error)) from error


def _describe(database: sqlite3.Connection, layer: Layer, places: Places) -> None:
    database.executemany(
        "INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)",
        [
            ("WGS 84 geodetic", WGS84, "EPSG", WGS84, WGS84_DEFINITION, "longitude, latitude"),
            ("Undefined Cartesian SRS", -1, "NONE", -1, "undefined", "metres in the survey's area"),
            ("Undefined geographic SRS", 0, "NONE", 0, "undefined", None),
        ],
    )
    bounds: Tuple[Optional[float], ...] = (None,) * 4
    if places:
        x, y = zip(*places)
        bounds = (min(x), min(y), max(x), max(y))
    now = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    now = now[:-4] + "Z"
    database.executemany(
        "INSERT INTO gpkg_contents VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
        [
            (layer.name, "features", layer.name, layer.description, now, *bounds, layer.srs),
            (layer.facts, "attributes", layer.facts, layer.description, now, *(None,) * 5),
        ],
    )
    database.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, 0, 0)",
        (layer.name, layer.kind_name, layer.srs),
    )


def _geometry(layer: Layer, shape: Places) -> bytes:
    """Return a shape as GeoPackage binary: header without envelope, then WKB, little-endian."""
    counts = [1, len(shape)] if layer.kind == POLYGON else []
    head = struct.pack("<2sBBiBI", b"GP", 0, 1, layer.srs, 1, layer.kind)
    return head + struct.pack(
        f"<{len(counts)}I{2 * len(shape)}d", *counts, *(one for place in shape for one in place)
    )
