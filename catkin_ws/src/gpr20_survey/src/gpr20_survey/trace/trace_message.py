"""A trace as a serialized ROS 1 message of the type gpr20_msgs/Trace, and back.

ROS 1 serialization: http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes;
little endian, the fields one after the other, strings and arrays behind their length as uint32.
"""

from __future__ import annotations

import struct
from typing import Any, Callable, List, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

DATATYPE = "gpr20_msgs/Trace"
# Of the fields that are written and read below, as ROS computes it.
MD5SUM = "2878bcdbff04f10f82e1d7bfa25b0325"
# Of the same fields without the last three, in recordings of earlier versions.
FORMER_MD5SUM = "2960f4daab5f0e952630a63f0c2bce22"

_LENGTH = struct.Struct("<I")
_TIME = struct.Struct("<II")
_POSITION = struct.Struct("<4d")
_BANDWIDTH_AND_AVERAGES = struct.Struct("<di")


def encode(trace: Trace) -> bytes:
    """Return the serialized message of a trace."""
    settings = trace.analyzer
    return b"".join(
        (
            encode_former(trace),
            _BANDWIDTH_AND_AVERAGES.pack(settings.if_bandwidth_hz, settings.averages),
            _text(settings.output_power),
        )
    )


def encode_former(trace: Trace) -> bytes:
    """Return the serialized message of the former type, without the settings of the analyzer."""
    return b"".join(
        (
            *(_text(one) for one in (trace.format, trace.survey_id, trace.sample_id)),
            _LENGTH.pack(trace.index),
            _time(trace.timestamp_us),
            _POSITION.pack(
                trace.x_coord_mm, trace.y_coord_mm, trace.z_coord_deg, trace.antennae_height_m
            ),
            *(_numbers(one) for one in (trace.frequency_hz, trace.s21_real, trace.s21_imag)),
            _time(trace.sweep_started_us),
            _time(trace.sweep_ended_us),
            _LENGTH.pack(len(trace.quality)),
            *(_text(remark) for remark in trace.quality),
        )
    )


def decode(data: bytes, md5sum: str = MD5SUM) -> Trace:
    """Return the trace of a serialized message, checked.

    Args:
        data: The message.
        md5sum: Checksum of its type, where it is known.

    Raises:
        TraceRefusedError: It is of another version of the type, is not whole, or a value is not
            allowed.
    """
    if md5sum not in (MD5SUM, FORMER_MD5SUM):
        raise TraceRefusedError(
            Message(
                "a trace was recorded with another version of {datatype}",
                datatype=DATATYPE,
                details=f"{md5sum[:64]}, not {MD5SUM}",
            )
        )
    try:
        return _Reader(data).trace(has_settings=md5sum == MD5SUM)
    except (struct.error, UnicodeDecodeError) as error:
        raise TraceRefusedError(Message("a recorded trace is incomplete", details=error)) from error


def _text(text: str) -> bytes:
    data = text.encode()
    return _LENGTH.pack(len(data)) + data


def _numbers(values: np.ndarray) -> bytes:
    return _LENGTH.pack(len(values)) + values.astype("<f8").tobytes()


def _time(time_us: int) -> bytes:
    seconds, rest_us = divmod(time_us, utc_time.US_PER_S)
    return _TIME.pack(seconds, rest_us * utc_time.NS_PER_US)


class _Reader:
    """Takes the fields of a message one after the other."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._place = 0

    def trace(self, has_settings: bool) -> Trace:
        names = {name: self._text() for name in ("format", "survey_id", "sample_id")}
        (index,) = self._unpack(_LENGTH)
        timestamp_us = self._time()
        x_mm, y_mm, z_deg, height_m = self._unpack(_POSITION)
        frequency_hz, s21_real, s21_imag = (self._numbers() for _ in range(3))
        trace = Trace(
            **names,
            index=index,
            timestamp_us=timestamp_us,
            x_coord_mm=x_mm,
            y_coord_mm=y_mm,
            z_coord_deg=z_deg,
            antennae_height_m=height_m,
            frequency_hz=frequency_hz,
            s21_real=s21_real,
            s21_imag=s21_imag,
            sweep_started_us=self._time(),
            sweep_ended_us=self._time(),
            quality=tuple(self._list(self._text)),
            analyzer=self._settings() if has_settings else AnalyzerSettings(),
        )
        if self._place != len(self._data):
            raise TraceRefusedError(Message("a recorded trace is longer than its fields"))
        return trace

    def _settings(self) -> AnalyzerSettings:
        if_bandwidth_hz, averages = self._unpack(_BANDWIDTH_AND_AVERAGES)
        return AnalyzerSettings(if_bandwidth_hz, averages, self._text())

    def _bytes(self, size: int) -> bytes:
        data = self._data[self._place : self._place + size]
        if len(data) != size:
            raise struct.error(f"{size} bytes are due at byte {self._place}")
        self._place += size
        return data

    def _unpack(self, form: struct.Struct) -> Tuple[Any, ...]:
        return form.unpack(self._bytes(form.size))

    def _size(self) -> int:
        return int(self._unpack(_LENGTH)[0])

    def _text(self) -> str:
        return self._bytes(self._size()).decode()

    def _numbers(self) -> np.ndarray:
        # A copy: a view would keep the whole message, or a mapped file, in memory.
        return np.frombuffer(self._bytes(8 * self._size()), "<f8").astype(np.float64)

    def _time(self) -> int:
        seconds, rest_ns = self._unpack(_TIME)
        return int(seconds * utc_time.US_PER_S + rest_ns // utc_time.NS_PER_US)

    def _list(self, item: Callable[[], str]) -> List[str]:
        size = self._size()
        # Each item has at least its length; a damaged size must not fill the memory.
        if _LENGTH.size * size > len(self._data) - self._place:
            raise struct.error(f"a list of {size} items is longer than the message")
        return [item() for _ in range(size)]
