"""Fingerprints of the traces of a recording."""

from __future__ import annotations

from typing import Any, Dict, Iterable, List

import numpy as np

from gpr20_analysis.errors import UnreadableFileError
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.trace import Trace

TIMES = ("timestamp", "sweep_started", "sweep_ended")
ARRAYS = ("frequency_hz", "s21_real", "s21_imag")


def trace_of(fields: Dict[str, Any]) -> Trace:
    """Return the trace of a decoded message, checked.

    Raises:
        TraceRefusedError: A value is not allowed.
        UnreadableFileError: A field is missing.
    """
    values = {name: value for name, value in fields.items() if not name.startswith("_")}
    try:
        for name in TIMES:
            moment = values.pop(name)
            rest_us = moment.nanosec // utc_time.NS_PER_US
            values[f"{name}_us"] = moment.sec * utc_time.US_PER_S + rest_us
        for name in ARRAYS:
            values[name] = np.array(values[name], np.float64)
        values["quality"] = tuple(values["quality"])
        return Trace(**values)
    except (KeyError, AttributeError, TypeError) as error:
        raise UnreadableFileError(f"a recorded trace lacks a field: {error}") from error


def fingerprints(
    name: str, messages: Iterable[Dict[str, Any]], survey_id: str, faults: List[str]
) -> Dict[int, bytes]:
    """Return the fingerprint of each trace of a recording.

    Args:
        name: The recording, for the faults.
        messages: Its decoded traces.
        survey_id: UUID of the survey.
        faults: Takes what is wrong.
    """
    prints: Dict[int, bytes] = {}
    try:
        for fields in messages:
            trace = trace_of(fields)
            if trace.survey_id != survey_id:
                faults.append(f"{name}: {trace.label} belongs to survey {trace.survey_id}")
            elif trace.index in prints:
                faults.append(f"{name} holds trace {trace.index} more than once")
            else:
                prints[trace.index] = trace.fingerprint()
    except (UnreadableFileError, TraceRefusedError) as error:
        faults.append(f"{name} cannot be read to its end: {error}")
    return prints


def contradictions(name: str, recorded: Dict[int, bytes], stored: Dict[int, bytes]) -> List[str]:
    """Return how a recording contradicts the JSON files in what both or it alone holds.

    Args:
        name: The recording.
        recorded: Fingerprints of its traces.
        stored: Fingerprints of the JSON files.
    """
    found = [
        f"trace {index} has other numbers in {name} than in its JSON file"
        for index in sorted(recorded.keys() & stored.keys())
        if recorded[index] != stored[index]
    ]
    found += [
        f"trace {index} is in {name} but has no readable JSON file"
        for index in sorted(recorded.keys() - stored.keys())
    ]
    return found
