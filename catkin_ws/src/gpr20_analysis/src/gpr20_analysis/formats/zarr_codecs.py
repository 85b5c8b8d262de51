"""Refuses Zarr folders whose compression would run code of the file's author.

The codec `pickle` of numcodecs, which zarr offers to every array, unpickles what it reads
(https://docs.python.org/3/library/pickle.html: "The pickle module is not secure").
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Iterator

from gpr20_analysis import faults
from gpr20_analysis.errors import UnreadableFileError
from gpr20_common.message import Message

# Of formats 2 and 3; they only compress or rearrange bytes.
ALLOWED = frozenset(
    ("blosc", "bz2", "gzip", "lz4", "lzma", "zlib", "zstd")
    + ("adler32", "crc32", "crc32c", "delta", "fixedscaleoffset", "shuffle")
    + ("bytes", "endian", "sharding_indexed", "transpose", "vlen-bytes", "vlen-utf8")
)
METADATA_FILES = (".zarray", ".zmetadata", "zarr.json")
CODEC_KEYS = ("codecs", "compressor", "filters", "index_codecs")


def refuse_unsafe_codecs(folder: Path) -> None:
    """Check the metadata of every array of a Zarr folder.

    Raises:
        UnreadableFileError: An array needs a codec that is not known to be safe.
        OSError: The metadata cannot be read.
        ValueError: They are not JSON.
    """
    # zarr follows links as well.
    for place, _folders, files in os.walk(folder, followlinks=True):
        for name in set(files).intersection(METADATA_FILES):
            metadata = json.loads((Path(place) / name).read_text(encoding="utf-8"))
            for codec in _codecs(metadata):
                if codec not in ALLOWED:
                    raise UnreadableFileError(
                        Message(
                            "{path} needs the codec {codec}, which is not known to be safe; "
                            "create the folder again with one of {allowed}",
                            path=folder,
                            codec=repr(codec),
                            allowed="blosc, gzip, zlib, zstd",
                        ),
                        fault=faults.INPUT,
                    )


def _codecs(metadata: Any) -> Iterator[Any]:
    if isinstance(metadata, list):
        for one in metadata:
            yield from _codecs(one)
    elif isinstance(metadata, dict):
        for key, value in metadata.items():
            if key in CODEC_KEYS:
                for one in value if isinstance(value, list) else [value]:
                    if one is not None:
                        yield one.get("id", one.get("name")) if isinstance(one, dict) else one
            yield from _codecs(value)
