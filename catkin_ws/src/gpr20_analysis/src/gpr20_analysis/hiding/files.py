"""A map of where a target could hide as a JSON file, which reports and windows read.

It has the warning that it holds for its target only; beside it a file .sha256 is for
`sha256sum -c`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Union

from gpr20_analysis.candidates.files import JSON, write_with_checksum
from gpr20_analysis.errors import UnreadableFileError, check_ending
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_survey.results.hiding_map import HidingMap, hiding_from, hiding_json

# A map has one place for about this many characters.
LARGEST_BYTES = 50_000_000


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
