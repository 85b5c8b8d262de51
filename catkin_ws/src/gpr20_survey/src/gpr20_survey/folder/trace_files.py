"""The JSON files of a survey's traces: their content, and all of a folder, read and checked."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_of_json
from gpr20_survey import faults
from gpr20_survey.errors import ForeignTraceError, TraceRefusedError
from gpr20_survey.files.regular_files import FileSum, open_regular, sum_of
from gpr20_survey.folder import survey_folder
from gpr20_survey.trace.trace import TRACE_FIELDS, Trace, check_format
from gpr20_survey.trace.trace_form import as_json, json_record, of_json

# The last entry: SHA-256 of the bytes before the comma in front of it.
_SEAL = ', "sha256": "%s"}\n'
_SEAL_BYTES = len(_SEAL % "") + 64
_FORMAT = re.compile(rb'\{"format": "([ -~]*?)"')
_Record = json_record("Trace", TRACE_FIELDS)
MAX_FILE_BYTES = 1 << 20  # 4001 points need a third of it
Shown = Callable[[List[Path]], Iterator[Path]]
OnTrace = Callable[[Trace], None]


def encode(trace: Trace) -> bytes:
    """Return the content of a trace's file.

    Numbers are written with as many digits as bring the same float64 back; equal traces
    give equal bytes. It ends with a checksum of what is before it.
    """
    values = as_json(TRACE_FIELDS, trace.values())
    return sealed(json.dumps(values, allow_nan=False).encode("ascii"))


def sealed(text: bytes) -> bytes:
    """Return the text of a JSON object with its checksum as the last entry."""
    covered = text[:-1]
    return covered + _seal(covered)


def decode(content: bytes) -> Trace:
    """Return the trace of a file's content, checked.

    Raises:
        TraceRefusedError: It is not the whole content of a trace's file.
    """
    covered = content[:-_SEAL_BYTES]
    if content[len(covered) :] != _seal(covered):
        raise TraceRefusedError(
            Message("the file does not end with the checksum of its content"),
            fault=faults.DAMAGED,
        )
    # Before all else: another version may have other entries.
    found = _FORMAT.match(covered)
    check_format(found[1].decode("ascii") if found else "")
    try:
        return Trace.of_values(of_json(TRACE_FIELDS, record_of_json(_Record, covered + b"}", "")))
    except Gpr20Error as error:
        # It was right when it was stored.
        raise TraceRefusedError(error.message, fault=faults.DAMAGED) from error


def _seal(covered: bytes) -> bytes:
    return (_SEAL % hashlib.sha256(covered).hexdigest()).encode("ascii")


class TraceFile(NamedTuple):
    """One file of a whole trace."""

    name: str
    fingerprint: bytes
    sample_id: str
    sum: FileSum
    """Of the file's content."""

    @classmethod
    def of(cls, trace: Trace, content: bytes) -> TraceFile:
        name = survey_folder.trace_file_name(trace)
        return cls(name, trace.fingerprint(), trace.sample_id, sum_of(content))


@dataclass
class TraceFiles:
    """What was found in the folder of the traces."""

    files: Dict[int, TraceFile] = field(default_factory=dict)
    """The file of each index."""
    damaged: List[Tuple[Path, Message]] = field(default_factory=list)
    """Files that are no whole trace of this survey, and why."""
    foreign: int = 0
    """How many of those are whole traces of another survey."""

    @property
    def prints(self) -> Dict[int, bytes]:
        """Fingerprint of the trace of each index."""
        return {index: one.fingerprint for index, one in self.files.items()}


def read_trace(path: Path, survey_id: Optional[str] = None) -> Trace:
    """Return the trace of a file of a survey, or of any, if all is as the storage wrote it.

    Raises:
        TraceRefusedError: It is not.
        OSError: The file cannot be read.
    """
    return _checked(decode(_content(path)), path, survey_id)


def _checked(trace: Trace, path: Path, survey_id: Optional[str]) -> Trace:
    if survey_id is not None and trace.survey_id != survey_id:
        raise ForeignTraceError(
            Message("the trace belongs to survey {survey}", survey=trace.survey_id)
        )
    name = survey_folder.trace_file_name(trace)
    if name != path.name:
        raise _damaged(Message("the file should be named {name} by its content", name=name))
    return trace


def read_all(
    folder: Path, survey_id: str, shown: Shown = iter, on_trace: Optional[OnTrace] = None
) -> TraceFiles:
    """Read every trace of a survey in the folder of its traces; `on_trace` gets each whole one.

    `shown` returns the files one by one, and may show the progress.

    Raises:
        OSError: The folder cannot be read.
    """
    found = TraceFiles()
    samples: Dict[str, int] = {}
    for path in shown(sorted(folder.glob("*.json"))):
        try:
            content = _content(path)
            trace = _checked(decode(content), path, survey_id)
            index, sample = trace.index, trace.sample_id
            if index in found.files:
                other = found.files[index].name
                raise _damaged(
                    Message("index {index} is already in {file}", index=index, file=other)
                )
            first = samples.setdefault(sample, index)
            if first != index:
                raise _damaged(
                    Message("sample {sample} already has index {index}", sample=sample, index=first)
                )
        except OSError as error:
            found.damaged.append((path, os_reason(error)))
        except TraceRefusedError as error:
            found.foreign += isinstance(error, ForeignTraceError)
            found.damaged.append((path, error.message))
        else:
            found.files[index] = TraceFile.of(trace, content)
            if on_trace is not None:
                on_trace(trace)
    return found


def _content(path: Path) -> bytes:
    with open(open_regular(path), "rb") as stream:
        content = stream.read(MAX_FILE_BYTES + 1)
    if len(content) > MAX_FILE_BYTES:
        raise _damaged(Message("the file has more than {most} bytes", most=MAX_FILE_BYTES))
    return content


def _damaged(reason: Message) -> TraceRefusedError:
    return TraceRefusedError(reason, fault=faults.DAMAGED)
