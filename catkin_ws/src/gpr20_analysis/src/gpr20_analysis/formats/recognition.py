"""Recognizes files of other formats, to name the command that imports them."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Optional

import h5py

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats import group_csv, original_json
from gpr20_common.message import Message

GPRMAX_FILES = ("*.out", "*.h5")
OUTPUT = "survey.nc"


def refuse_importable(path: Path) -> None:
    """Refuse files of other formats with the command that imports them.

    Raises:
        AnalysisError: It is such a file or folder.
    """
    form = _form(path)
    if form is None:
        return
    # One file of a format with a file per sample is no survey; its folder is.
    whole = path.parent if path.is_file() and form in ("group-csv", "original-json") else path
    command = f"gpr20 import {shlex.quote(str(whole))} {OUTPUT} --format {form}"
    raise AnalysisError(
        Message(
            "{path} has the format {format}; import it first: {command}",
            path=path,
            format=form,
            command=command,
        ),
        fault=faults.IMPORT_FIRST,
    )


def _form(path: Path) -> Optional[str]:
    if path.is_dir():
        if group_csv.holds_group_csv(path):
            return "group-csv"
        if original_json.holds_original(path):
            return "original-json"
        files = (one for pattern in GPRMAX_FILES for one in path.glob(pattern))
        first = next(files, None)
        return "gprmax" if first is not None and _hdf5_form(first) == "gprmax" else None
    if not path.is_file():
        return None
    if path.suffix == ".csv":
        kinds = tuple(f"{kind}_" for kind in group_csv.HEADERS)
        return "group-csv" if path.name.startswith(kinds) else None
    if original_json.NAME.fullmatch(path.name):
        return "original-json"
    return _hdf5_form(path) if path.suffix in (".h5", ".hdf5", ".out") else None


def _hdf5_form(path: Path) -> Optional[str]:
    try:
        with h5py.File(str(path), "r") as file:
            if "A-Scan" in file and "Position" in file:
                return "merged-hdf5"
            return "gprmax" if "rxs" in file else None
    # On damaged files HDF5 raises exceptions of many kinds; it is then none of these.
    except Exception:
        return None
