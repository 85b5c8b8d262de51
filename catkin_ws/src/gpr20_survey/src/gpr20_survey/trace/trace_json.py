"""A trace as the text of its JSON file, and back."""

from __future__ import annotations

import hashlib
import json
import math
from typing import Any, Dict, NoReturn, Tuple

import numpy as np

from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.axes.zero_epoch import ZeroEpoch, Zeros
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.aux_value import AuxValue
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

TEXTS = ("format", "survey_id", "sample_id")
TIMES = ("timestamp", "sweep_started", "sweep_ended")
HEIGHT = "antennae_height_m"
NUMBERS = ("x_coord_mm", "y_coord_mm", "z_coord_deg")
ARRAYS = ("frequency_hz", "s21_real", "s21_imag")
KEYS = frozenset((*TEXTS, "index", *TIMES, *NUMBERS, HEIGHT, *ARRAYS, "quality"))
# Absent from a trace of which none is known, such as those of early versions.
ANALYZER_KEYS = frozenset(("if_bandwidth_hz", "averages", "output_power"))
# Absent from a trace that has no values of other sensors.
AUX = "aux"
AUX_KEYS = frozenset(("name", "value", "unit", "stamp"))
# Absent from a trace whose zeros are not known: that of an early version.
ZERO_EPOCHS, ZERO_TIMES = "zero_epochs", "zero_times"
ZERO_KEYS = frozenset((ZERO_EPOCHS, ZERO_TIMES))
# The last entry: SHA-256 of the bytes before it. Absent from a trace of an early version.
CHECKSUM = "sha256"
_CHECKSUM_START = f', "{CHECKSUM}": "'.encode()
_CHECKSUM_END = b'"}\n'
_CHECKSUM_BYTES = 64
_ENTRY_BYTES = len(_CHECKSUM_START) + _CHECKSUM_BYTES + len(_CHECKSUM_END)


def encode(trace: Trace) -> bytes:
    """Return the content of a trace's file.

    Numbers are written with as many digits as bring the same float64 back; equal traces
    give equal bytes. It ends with a checksum of what is before it.
    """
    height = trace.antennae_height_m
    values: Dict[str, Any] = {
        "format": trace.format,
        "survey_id": trace.survey_id,
        "sample_id": trace.sample_id,
        "index": trace.index,
        "timestamp": utc_time.iso_text(trace.timestamp_us),
        "x_coord_mm": trace.x_coord_mm,
        "y_coord_mm": trace.y_coord_mm,
        "z_coord_deg": trace.z_coord_deg,
        "antennae_height_m": None if math.isnan(height) else height,
        "frequency_hz": trace.frequency_hz.tolist(),
        "s21_real": trace.s21_real.tolist(),
        "s21_imag": trace.s21_imag.tolist(),
        "sweep_started": utc_time.iso_text(trace.sweep_started_us),
        "sweep_ended": utc_time.iso_text(trace.sweep_ended_us),
        "quality": list(trace.quality),
    }
    if trace.analyzer.is_known:
        values["if_bandwidth_hz"] = float(trace.analyzer.if_bandwidth_hz)
        values["averages"] = trace.analyzer.averages
        values["output_power"] = trace.analyzer.output_power
    if trace.aux:
        values[AUX] = [
            {
                "name": one.name,
                "value": float(one.value),
                "unit": one.unit,
                "stamp": utc_time.iso_text(one.stamp_us),
            }
            for one in trace.aux
        ]
    if trace.zeros:
        values[ZERO_EPOCHS] = [one.number for one in trace.zeros]
        values[ZERO_TIMES] = [utc_time.iso_text(one.time_us) for one in trace.zeros]
    covered = json.dumps(values, allow_nan=False).encode("ascii")[:-1]
    own_sum = hashlib.sha256(covered).hexdigest().encode("ascii")
    return covered + _CHECKSUM_START + own_sum + _CHECKSUM_END


def is_proven(content: bytes) -> bool:
    """Return whether the content of a trace's file has a checksum.

    Raises:
        TraceRefusedError: It has one, which is not that of the content.
    """
    entry = content[-_ENTRY_BYTES:]
    if not entry.startswith(_CHECKSUM_START) or not entry.endswith(_CHECKSUM_END):
        if CHECKSUM.encode() in entry:
            raise _changed()
        return False
    own_sum = entry[len(_CHECKSUM_START) : -len(_CHECKSUM_END)]
    covered = memoryview(content)[: -len(entry)]
    if hashlib.sha256(covered).hexdigest().encode("ascii") != own_sum:
        raise _changed()
    return True


def _changed() -> TraceRefusedError:
    return TraceRefusedError(
        Message("its content does not have the checksum that it names"), fault=faults.TRACE_DAMAGED
    )


def decode(content: bytes) -> Trace:
    """Return the trace of a file's content, checked.

    Raises:
        TraceRefusedError: It is not the whole content of a trace's file.
    """
    is_proven(content)
    try:
        values = json.loads(content.decode("ascii"), parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise TraceRefusedError(
            Message("the file is not strict JSON", details=error), fault=faults.TRACE_DAMAGED
        ) from error
    if content[-1:] != b"\n":
        raise TraceRefusedError(
            Message("the file is incomplete: its last line is cut off"), fault=faults.TRACE_DAMAGED
        )
    return from_values(values)


def from_values(values: Any) -> Trace:
    """Return the trace of a file's JSON value, checked.

    Raises:
        TraceRefusedError: It is not the value of a trace's file.
    """
    keys = values.keys() - {AUX, CHECKSUM} if isinstance(values, dict) else frozenset()
    if keys & ZERO_KEYS == ZERO_KEYS:
        keys = keys - ZERO_KEYS
    if keys not in (KEYS, KEYS | ANALYZER_KEYS):
        raise TraceRefusedError(
            Message("the file does not hold exactly the entries of a trace"),
            fault=faults.TRACE_DAMAGED,
        )
    try:
        return _trace(values)
    except TraceRefusedError as error:
        # It was right when it was stored.
        raise TraceRefusedError(error.message, fault=faults.TRACE_DAMAGED) from error
    except Gpr20Error as error:
        raise TraceRefusedError(
            Message("an entry of the trace is wrong: {reason}", reason=error.message),
            fault=faults.TRACE_DAMAGED,
        ) from error
    except (ValueError, TypeError, OverflowError) as error:
        raise TraceRefusedError(
            Message("an entry of the trace is wrong", details=error), fault=faults.TRACE_DAMAGED
        ) from error


def _trace(values: Dict[str, Any]) -> Trace:
    height = values[HEIGHT]
    if not all(isinstance(one, str) for one in _list(values, "quality")):
        raise InvalidValueError(
            Message("quality holds values that are not texts"), fault=faults.TRACE_NOT_ALLOWED
        )
    fields: Dict[str, Any] = {
        **{name: _of_type(values, name, str) for name in TEXTS},
        **{f"{name}_us": utc_time.parse_iso(_of_type(values, name, str)) for name in TIMES},
        **{name: _of_type(values, name, float) for name in NUMBERS},
        **{name: _array(values, name) for name in ARRAYS},
        "index": _of_type(values, "index", int),
        HEIGHT: math.nan if height is None else _of_type(values, HEIGHT, float),
        "quality": tuple(values["quality"]),
        "analyzer": _analyzer(values),
        "aux": _aux(values),
        "zeros": _zeros(values),
    }
    return Trace(**fields)


def _aux(values: Dict[str, Any]) -> Tuple[AuxValue, ...]:
    if AUX not in values:
        return ()
    found = _list(values, AUX)
    if not found or any(not isinstance(one, dict) or one.keys() != AUX_KEYS for one in found):
        # One trace has one form.
        raise InvalidValueError(
            Message("aux does not hold exactly the entries of its values"),
            fault=faults.TRACE_NOT_ALLOWED,
        )
    return tuple(
        AuxValue(
            _of_type(one, "name", str),
            _of_type(one, "value", float),
            _of_type(one, "unit", str),
            utc_time.parse_iso(_of_type(one, "stamp", str)),
        )
        for one in found
    )


def _zeros(values: Dict[str, Any]) -> Zeros:
    if ZERO_EPOCHS not in values:
        return ()
    numbers, times = _list(values, ZERO_EPOCHS), _list(values, ZERO_TIMES)
    # One trace has one form.
    if not numbers or len(numbers) != len(times) or {*map(type, numbers)} != {int}:
        raise InvalidValueError(
            Message("the trace does not hold one number and one time for each zero"),
            fault=faults.TRACE_NOT_ALLOWED,
        )
    return tuple(
        ZeroEpoch(number, utc_time.parse_iso(time)) for number, time in zip(numbers, times)
    )


def _analyzer(values: Dict[str, Any]) -> AnalyzerSettings:
    if not values.keys() >= ANALYZER_KEYS:
        return AnalyzerSettings()
    settings = AnalyzerSettings(
        _of_type(values, "if_bandwidth_hz", float),
        _of_type(values, "averages", int),
        _of_type(values, "output_power", str),
    )
    if not settings.is_known:
        # One trace has one form.
        raise InvalidValueError(
            Message("the settings of the analyzer have no value"), fault=faults.TRACE_NOT_ALLOWED
        )
    return settings


def _of_type(values: Dict[str, Any], name: str, kind: type) -> Any:
    value = values[name]
    # Exactly: true is an int to Python, and a float is always written with a point.
    if type(value) is not kind:
        raise InvalidValueError(
            Message(
                "{place} is {value}; it must be of type {type}",
                place=name,
                value=repr(str(value)[:64]),
                type=kind.__name__,
            )
        )
    return value


def _list(values: Dict[str, Any], name: str) -> Any:
    return _of_type(values, name, list)


def _array(values: Dict[str, Any], name: str) -> np.ndarray:
    numbers = _list(values, name)
    if set(map(type, numbers)) - {float}:
        raise InvalidValueError(
            Message("{name} holds values that are not numbers with a decimal point", name=name),
            fault=faults.TRACE_NOT_ALLOWED,
        )
    return np.array(numbers, np.float64)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not allowed in JSON")
