"""Stored traces by their places in the plan, read fast while others may be stored."""

from __future__ import annotations

import contextlib
import os
import re
import threading
import time
from functools import lru_cache
from pathlib import Path
from typing import Collection, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import ProcessingError, TraceRefusedError
from gpr20_survey.folder import survey_folder, trace_files
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.trace import trace_message
from gpr20_survey.trace.trace import Trace
from gpr20_survey.trace.trace_block import TraceBlock

# What is read at once may take 12 MB: 1000 traces of 501 points.
MAX_POINTS = 501_000
# Another client waits meanwhile.
MAX_READING_S = 2.0
# The system marks changes only every few milliseconds, some file systems every two seconds: of
# files that changed less than this ago another change may not show.
SETTLED_NS = 3 * 10**9

TRACE_FILE = re.compile(r"([0-9]{6})_X[-0-9.]+_Y[-0-9.]+_Z[-+0-9.]+\.json")


class ReadTraces(NamedTuple):
    """Traces that were read, and why others are unreadable, by their places in the plan."""

    block: TraceBlock
    unreadable: Mapping[int, Message]


Version = Tuple[Tuple[int, ...], ...]


class TraceReader:
    """Reads a trace from its JSON file, or from the MCAP if the file is not whole.

    Any thread may call it. It remembers the names of the last survey's files, and holds no file
    open between two calls: the disk can be removed.
    """

    def __init__(self) -> None:
        self._one_at_a_time = threading.Lock()
        self._kept = lru_cache(1)(lambda folder, _version: trace_names(folder))

    def read(self, folder: Path, survey_id: str, indices: Sequence[int]) -> ReadTraces:
        """Return traces that have the frequencies of the first of them.

        Args:
            folder: The survey's folder.
            survey_id: Whose traces there must be.
            indices: Their places in the plan. The first one is in the result; others may be
                absent from it, to be requested again.

        Raises:
            ProcessingError: The folder cannot be read.
        """
        found: Dict[int, Trace] = {}
        unreadable: Dict[int, Message] = {}
        points = 0
        with self._one_at_a_time:
            version = settled_version(folder, [survey_folder.TRACES_FOLDER], time.time_ns())
            names = trace_names(folder) if version is None else self._kept(folder, version)
            end_s = time.monotonic() + MAX_READING_S
            for index in indices:
                try:
                    found[index] = _from_file(folder, survey_id, names.get(index))
                    points += len(found[index].frequency_hz)
                except TraceRefusedError as error:
                    unreadable[index] = error.message
                except OSError as error:
                    unreadable[index] = os_reason(error)
                if points >= MAX_POINTS or time.monotonic() > end_s:
                    break
            if unreadable:
                found.update(_recorded(folder, survey_id, unreadable.keys()))
        traces = [found[index] for index in indices if index in found]
        same = [one for one in traces if np.array_equal(one.frequency_hz, traces[0].frequency_hz)]
        reasons = {index: one for index, one in unreadable.items() if index not in found}
        return ReadTraces(TraceBlock.of(survey_id, same), reasons)


def _recorded(folder: Path, survey_id: str, indices: Collection[int]) -> Dict[int, Trace]:
    """Return the traces of these places that the MCAP holds."""
    found = {}
    with contextlib.suppress(OSError):
        for message in StoredMcap(folder / survey_folder.MCAP_FILE).messages(
            trace_message.DATATYPE
        ):
            with contextlib.suppress(TraceRefusedError):  # its file says what is wrong
                trace = trace_message.decode(message.data, message.md5sum)
                if trace.survey_id == survey_id and trace.index in indices:
                    found[trace.index] = trace
    return found


def trace_names(folder: Path) -> Dict[int, str]:
    """Return the name of the JSON file of each stored trace by its index, ascending.

    Raises:
        ProcessingError: The survey's folder cannot be read.
    """
    found: Dict[int, str] = {}
    try:
        with os.scandir(str(folder / survey_folder.TRACES_FOLDER)) as entries:
            for entry in entries:
                match = TRACE_FILE.fullmatch(entry.name)
                if match and entry.is_file(follow_symlinks=False):
                    found[int(match.group(1))] = entry.name
    except OSError as error:
        raise ProcessingError(
            Message(
                "the traces in {folder} cannot be read: {reason}",
                folder=printable(folder),
                reason=os_reason(error),
            )
        ) from error
    return dict(sorted(found.items()))


def _from_file(folder: Path, survey_id: str, name: Optional[str]) -> Trace:
    if name is None:
        raise TraceRefusedError(Message("the storage has no file of this trace"))
    return trace_files.read_trace(folder / survey_folder.TRACES_FOLDER / name, survey_id)


def settled_version(folder: Path, names: Sequence[str], now_ns: int) -> Optional[Version]:
    """Return what differs if a folder of a survey, or something in it, was changed.

    Args:
        folder: The folder.
        names: Of files and folders in it; they may be missing.
        now_ns: Time of day [ns].

    Returns:
        None: it changed so shortly ago that another change may not show.
    """
    version: List[Tuple[int, ...]] = []
    for path in (folder, *(folder / name for name in names)):
        try:
            found = os.lstat(str(path))
        except OSError:
            version.append(())
            continue
        version.append((found.st_mtime_ns, found.st_size, found.st_ino))
        if now_ns - found.st_mtime_ns <= SETTLED_NS:
            return None
    return tuple(version)
