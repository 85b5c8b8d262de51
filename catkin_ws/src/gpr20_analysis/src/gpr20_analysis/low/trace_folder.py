"""The JSON files of the traces in a folder, checked as strictly as the storage does."""

from __future__ import annotations

import os
from pathlib import Path
from typing import List

import orjson

from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.trace_files import MAX_FILE_BYTES
from gpr20_survey.trace import trace_json
from gpr20_survey.trace.trace import Trace


def trace_files(folder: Path) -> List[Path]:
    """Return the files of a folder that should be traces, in the order of their names."""
    with os.scandir(str(folder)) as entries:
        names = [entry.name for entry in entries if entry.name.endswith(".json")]
    return [folder / name for name in sorted(names) if name != survey_folder.SURVEY_FILE]


def read_trace(path: Path) -> Trace:
    """Return the trace of a file.

    Raises:
        TraceRefusedError: The file is not a whole trace, or is named as another one.
        OSError: The file cannot be read.
    """
    with open(open_regular(path), "rb") as stream:
        content = stream.read(MAX_FILE_BYTES + 1)
    if len(content) > MAX_FILE_BYTES:
        raise TraceRefusedError(f"the file has more than {MAX_FILE_BYTES} bytes")
    try:
        values = orjson.loads(content)
    except orjson.JSONDecodeError as error:
        raise TraceRefusedError(f"the file is no strict JSON: {error}") from error
    trace = trace_json.from_values(values)
    if survey_folder.trace_file_name(trace) != path.name:
        raise TraceRefusedError(
            f"the file should be named {survey_folder.trace_file_name(trace)} by its content"
        )
    return trace
