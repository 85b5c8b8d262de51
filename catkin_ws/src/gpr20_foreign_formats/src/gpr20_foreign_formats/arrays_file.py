"""The arrays in .npz, .npy, .mat and HDF5 files; none is read before it is known to fit."""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path
from typing import Any, Callable, Dict, Tuple

import h5py
import numpy as np

from gpr20_analysis import work
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_common.message import Message
from gpr20_foreign_formats.header import other_kind
from gpr20_survey.files.regular_file import open_regular

ONLY = "array"
"""Name of the array in a .npy file, which has none."""
NONE_YET = np.empty(0)
COPIES = 3.0  # of an array: as stored, in double precision, and in another order
PAIRS = [np.dtype([("real", one), ("imag", one)]) for one in ("f4", "f8")]
# The format of MATLAB 5 to 7.2, as MathWorks' "MAT-File Format" describes it.
MATLAB_HEADER, MATRIX, COMPRESSED = 128, 14, 15
MAGIC = {".npy": [b"\x93NUMPY"], ".npz": [b"PK\x03\x04"], ".mat": [b"IM", b"MI"]}
MATLAB_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
MATLAB_TYPES.update({12: "i8", 13: "u8"})
NUMERIC_CLASSES = range(6, 16)
COMPLEX_FLAG = 0x800
Arrays = Dict[str, np.ndarray]


def arrays_in(path: Path, wanted: str = "") -> Arrays:
    """Return the arrays of a file by name; only the wanted one is read, the others are empty.

    Objects, which Python would make by running code of the file, are refused.

    Raises:
        UnreadableFileError: The file is damaged, or the array holds no plain values.
        TooLargeError: The array does not fit into the memory.
        OSError: The file cannot be opened.
    """
    with open(open_regular(path, follow_link=True), "rb") as stream:
        start = stream.read(MATLAB_HEADER)
    is_hdf5 = h5py.is_hdf5(str(path))
    if not is_hdf5 and not any(one in start for one in MAGIC.get(path.suffix, ())):
        raise other_kind(path.name, path.suffix)
    try:
        # From version 7.3 on, MATLAB writes HDF5.
        return (_hdf5 if is_hdf5 else READERS[path.suffix])(path, wanted)
    except AnalysisError:
        raise
    # On damaged files zipfile, struct, numpy and HDF5 raise exceptions of many kinds.
    except Exception as error:
        raise UnreadableFileError(
            Message(
                "{file} is damaged, or is not a {ending} file of plain numbers; store its numbers "
                "as plain arrays, not as objects",
                file=path.name,
                ending=path.suffix,
                details=error,
            )
        ) from error


def _require_room(path: Path, *sizes: int) -> None:
    # With Python's integers, which do not overflow.
    work.require_bytes(
        COPIES * math.prod(map(int, sizes)), Message("reading {file}", file=path.name)
    )


def _npy(path: Path, wanted: str) -> Arrays:
    _require_room(path, path.stat().st_size)
    return {ONLY: np.load(str(path), allow_pickle=False) if wanted else NONE_YET}


def _npz(path: Path, wanted: str) -> Arrays:
    with np.load(str(path), allow_pickle=False) as stored:
        found = dict.fromkeys(stored.files, NONE_YET)
        if wanted in found:
            _require_room(path, stored.zip.getinfo(f"{wanted}.npy").file_size)
            found[wanted] = stored[wanted]
    return found


def _matlab(path: Path, wanted: str) -> Arrays:
    # Not by scipy.io.loadmat: one changed byte can make it end the whole program.
    _require_room(path, path.stat().st_size)
    data, place = memoryview(path.read_bytes()), MATLAB_HEADER
    order, found = {b"IM": "<", b"MI": ">"}[bytes(data[place - 2 : place])], {}
    while place < len(data):
        kind, content, place = _element(data, place, order)
        if kind == COMPRESSED:
            size = struct.unpack(f"{order}II", zlib.decompressobj().decompress(content, 8))[1]
            _require_room(path, size)
            # One byte more than there are, so that their checksum is read and checked too.
            unpacked = memoryview(zlib.decompressobj().decompress(content, size + 9))
            kind, content, _ = _element(unpacked, 0, order)
        if kind == MATRIX:
            name, values = _matrix(content, order, wanted)
            found[name] = values
    return found


def _element(data: memoryview, place: int, order: str) -> Tuple[int, memoryview, int]:
    """Return type, content and end of an element; a small one has its content in its tag."""
    kind, size = struct.unpack_from(f"{order}II", data, place)
    if kind >> 16:
        return kind & 0xFFFF, data[place + 4 : place + 4 + (kind >> 16)], place + 8
    end = place + 8 + size
    if end > len(data):
        raise ValueError(f"element of {size} bytes at {place}")
    return kind, data[place + 8 : end], end if kind == COMPRESSED else end + -size % 8


def _matrix(data: memoryview, order: str, wanted: str) -> Tuple[str, np.ndarray]:
    _, flags, place = _element(data, 0, order)
    _, shape, place = _element(data, place, order)
    _, text, place = _element(data, place, order)
    name = bytes(text).decode("latin-1")
    (flag,) = struct.unpack_from(f"{order}I", flags)
    if name != wanted or flag & 0xFF not in NUMERIC_CLASSES:
        return name, NONE_YET if name != wanted else np.empty(0, object)
    parts = []
    for _ in range(2 if flag & COMPLEX_FLAG else 1):
        kind, values, place = _element(data, place, order)
        parts.append(np.frombuffer(values, order + MATLAB_TYPES[kind]))
    found = parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]
    return name, found.reshape(np.frombuffer(shape, f"{order}i4"), order="F")


def _hdf5(path: Path, wanted: str) -> Arrays:
    with h5py.File(str(path), "r") as file:
        members: Dict[Any, Any] = {}
        file.visititems(lambda name, one: members.update({name: one}))
        # A damaged name that is no text is one of bytes.
        names = [one for one in members if isinstance(one, str) and hasattr(members[one], "shape")]
        found = dict.fromkeys(names, NONE_YET)
        if wanted in found:
            stored = members[wanted]
            _require_room(path, stored.dtype.itemsize, *stored.shape)
            # Others are not read: a damaged type can make HDF5 write beyond its memory.
            if stored.dtype.kind not in "fciu" and stored.dtype not in PAIRS:
                return {**found, wanted: np.empty(0, object)}
            values = np.asarray(stored[()])
            # MATLAB stores complex numbers as pairs, and dimensions backwards.
            if stored.dtype in PAIRS:
                values = values["real"] + 1j * values["imag"]
            found[wanted] = values.T if "MATLAB_class" in stored.attrs else values
    return found


Reader = Callable[[Path, str], Arrays]
READERS: Dict[str, Reader] = {".npy": _npy, ".npz": _npz, ".mat": _matlab, ".h5": _hdf5}
READERS[".hdf5"] = _hdf5
