"""The JSON files of a survey's traces, read and checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Optional, Tuple

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.trace import trace_json
from gpr20_survey.trace.trace import Trace

MAX_FILE_BYTES = 1 << 20  # 4001 points need a third of it
Shown = Callable[[List[Path]], Iterator[Path]]


@dataclass
class TraceFiles:
    """What was found in the folder of the traces."""

    prints: Dict[int, bytes] = field(default_factory=dict)
    """Fingerprint of the trace of each index."""
    names: Dict[int, str] = field(default_factory=dict)
    """File of each index."""
    damaged: List[Tuple[Path, str]] = field(default_factory=list)
    """Files that are no whole trace of this survey, and why."""


def read_trace(
    path: Path,
    survey_id: Optional[str] = None,
    decode: Callable[[bytes], Trace] = trace_json.decode,
) -> Trace:
    """Return the trace of a file, if all of it is as the storage wrote it.

    Args:
        path: The file.
        survey_id: Whose trace it must be; None: of any survey.
        decode: Makes a trace of the content.

    Raises:
        TraceRefusedError: It is not.
        OSError: The file cannot be read.
    """
    with open(open_regular(path), "rb") as stream:
        content = stream.read(MAX_FILE_BYTES + 1)
    if len(content) > MAX_FILE_BYTES:
        raise TraceRefusedError(f"the file has more than {MAX_FILE_BYTES} bytes")
    trace = decode(content)
    if survey_id is not None and trace.survey_id != survey_id:
        raise TraceRefusedError(f"the trace belongs to survey {trace.survey_id}")
    if survey_folder.trace_file_name(trace) != path.name:
        raise TraceRefusedError(
            f"the file should be named {survey_folder.trace_file_name(trace)} by its content"
        )
    return trace


def read_all(folder: Path, survey_id: str, shown: Shown = iter) -> TraceFiles:
    """Read every trace of a survey.

    Args:
        folder: The folder of the traces.
        survey_id: Whose they must be.
        shown: Hands on the files one by one, and may show how far that has come.

    Raises:
        OSError: The folder cannot be read.
    """
    found = TraceFiles()
    samples: Dict[str, int] = {}
    for path in shown(sorted(folder.glob("*.json"))):
        try:
            trace = read_trace(path, survey_id)
            _check_unique(trace, found.names.get(trace.index), samples.get(trace.sample_id))
        except OSError as error:
            found.damaged.append((path, error.strerror or str(error)))
            continue
        except TraceRefusedError as error:
            found.damaged.append((path, str(error)))
            continue
        found.prints[trace.index] = trace.fingerprint()
        found.names[trace.index] = path.name
        samples[trace.sample_id] = trace.index
    return found


def _check_unique(trace: Trace, name: Optional[str], index: Optional[int]) -> None:
    if name is not None:
        raise TraceRefusedError(f"index {trace.index} is in {name} already")
    if index is not None:
        raise TraceRefusedError(f"sample {trace.sample_id} has index {index} already")
