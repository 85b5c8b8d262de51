"""A trace as the text of its JSON file, and back."""

from __future__ import annotations

import hashlib
import json
import re

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_of_json
from gpr20_survey import faults
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace.trace import TRACE_FIELDS, Trace, check_format
from gpr20_survey.trace.trace_form import as_json, json_record, of_json

# The last entry: SHA-256 of the bytes before the comma in front of it.
_SEAL = ', "sha256": "%s"}\n'
_SEAL_BYTES = len(_SEAL % "") + 64
_FORMAT = re.compile(rb'\{"format": "([ -~]*?)"')
_Record = json_record("Trace", TRACE_FIELDS)


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
