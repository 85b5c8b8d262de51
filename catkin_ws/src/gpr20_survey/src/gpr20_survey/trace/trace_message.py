"""A trace as a serialized ROS 1 message of the type gpr20_msgs/Trace, and back.

ROS 1 serialization: http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes;
little endian, the fields one after the other, strings and arrays behind their length as uint32.
"""

from __future__ import annotations

import struct
from typing import Any, Callable, List, Tuple, TypeVar

import numpy as np

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.axes.zero_epoch import AXES, UNKNOWN_ZERO, ZeroEpoch, Zeros
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.frames import ANTENNA_LINK
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.aux_value import AuxValue
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

Item = TypeVar("Item")

DATATYPE = "gpr20_msgs/Trace"
# Of the fields that are written and read below, as ROS computes it.
MD5SUM = "ec373fee7fec8ef74bb147d7899ddcba"
# Of recordings of earlier versions: without the zeros of the axes.
WITHOUT_ZEROS_MD5SUM = "1009378aeaf096e9d9aa3e0c04f18aad"
# And without the header and aux.
WITHOUT_HEADER_MD5SUM = "2878bcdbff04f10f82e1d7bfa25b0325"
# And without the settings of the analyzer.
WITHOUT_SETTINGS_MD5SUM = "2960f4daab5f0e952630a63f0c2bce22"
FORMER_MD5SUMS = (WITHOUT_ZEROS_MD5SUM, WITHOUT_HEADER_MD5SUM, WITHOUT_SETTINGS_MD5SUM)
WITH_HEADER = (MD5SUM, WITHOUT_ZEROS_MD5SUM)

_LENGTH = struct.Struct("<I")
_TIME = struct.Struct("<II")
_POSITION = struct.Struct("<4d")
_BANDWIDTH_AND_AVERAGES = struct.Struct("<di")
_NUMBER = struct.Struct("<d")
_ZERO_EPOCHS = struct.Struct(f"<{AXES}I")
_ZERO_TIMES = struct.Struct(f"<{2 * AXES}I")


def encode(trace: Trace, md5sum: str = MD5SUM) -> bytes:
    """Return the serialized message of a trace.

    Args:
        trace: A trace that the version of the type can hold.
        md5sum: Checksum of the version of the type.
    """
    parts = [_measured(trace)]
    if md5sum != WITHOUT_SETTINGS_MD5SUM:
        settings = trace.analyzer
        parts.append(_BANDWIDTH_AND_AVERAGES.pack(settings.if_bandwidth_hz, settings.averages))
        parts.append(_text(settings.output_power))
    if md5sum in WITH_HEADER:
        parts.insert(0, _header(trace.index, trace.timestamp_us))
        parts.append(_LENGTH.pack(len(trace.aux)))
        for one in trace.aux:
            parts += (_text(one.name), _NUMBER.pack(one.value), _text(one.unit))
            parts.append(_time(one.stamp_us))
    if md5sum == MD5SUM:
        zeros = trace.zeros or AXES * (UNKNOWN_ZERO,)
        parts.append(_ZERO_EPOCHS.pack(*(one.number for one in zeros)))
        parts += [_time(one.time_us) for one in zeros]
    return b"".join(parts)


def decode(data: bytes, md5sum: str = MD5SUM) -> Trace:
    """Return the trace of a serialized message, checked.

    Args:
        data: The message.
        md5sum: Checksum of its type, where it is known.

    Raises:
        TraceRefusedError: It is of another version of the type, is not whole, or a value is not
            allowed.
    """
    if md5sum not in (MD5SUM, *FORMER_MD5SUMS):
        raise TraceRefusedError(
            Message(
                "a trace was recorded with another version of {datatype}",
                datatype=DATATYPE,
                details=f"{md5sum[:64]}, not {MD5SUM}",
            ),
            fault=faults.TRACE_OTHER_VERSION,
        )
    try:
        return _Reader(data).trace(md5sum)
    except (struct.error, UnicodeDecodeError) as error:
        raise TraceRefusedError(
            Message("a recorded trace is incomplete", details=error), fault=faults.TRACE_DAMAGED
        ) from error


def completed(data: bytes, md5sum: str) -> bytes:
    """Return a message of a former version of the type as one of the present version.

    The values are not checked, only moved.

    Raises:
        TraceRefusedError: It is not whole.
    """
    zeros = bytes(_ZERO_EPOCHS.size + _ZERO_TIMES.size)
    if md5sum in WITH_HEADER:
        return data + zeros
    try:
        header = _Reader(data).header()
    except (struct.error, UnicodeDecodeError) as error:
        raise TraceRefusedError(
            Message("a recorded trace is incomplete", details=error), fault=faults.TRACE_DAMAGED
        ) from error
    settings = b""
    if md5sum == WITHOUT_SETTINGS_MD5SUM:
        settings = bytes(_BANDWIDTH_AND_AVERAGES.size + _LENGTH.size)
    return header + data + settings + _LENGTH.pack(0) + zeros


def _measured(trace: Trace) -> bytes:
    """Return the fields that all versions have."""
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


def _header(index: int, timestamp_us: int) -> bytes:
    """Return a std_msgs/Header; the same in every form of the message."""
    return _LENGTH.pack(index) + _time(timestamp_us) + _text(ANTENNA_LINK)


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

    def header(self) -> bytes:
        """Return the header that belongs to a message without one."""
        for _name in range(3):
            self._text()
        (index,) = self._unpack(_LENGTH)
        return _header(index, self._time())

    def trace(self, md5sum: str) -> Trace:
        """Return the trace of a message, checked."""
        header = self._read_header() if md5sum in WITH_HEADER else None
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
            analyzer=(
                AnalyzerSettings() if md5sum == WITHOUT_SETTINGS_MD5SUM else self._settings()
            ),
            aux=tuple(self._list(self._aux)) if md5sum in WITH_HEADER else (),
            zeros=self._zeros() if md5sum == MD5SUM else (),
        )
        if header not in (None, (timestamp_us, ANTENNA_LINK)):
            raise TraceRefusedError(
                Message(
                    "the header of a trace is wrong: its stamp must be the timestamp and its "
                    "frame_id {frame}",
                    frame=repr(ANTENNA_LINK),
                )
            )
        if self._place != len(self._data):
            raise TraceRefusedError(
                Message("a recorded trace is longer than its fields"), fault=faults.TRACE_DAMAGED
            )
        return trace

    def _read_header(self) -> Tuple[int, str]:
        """Return stamp [us] and frame; every ROS publisher gives `seq` a number of its own."""
        self._unpack(_LENGTH)
        return self._time(), self._text()

    def _aux(self) -> AuxValue:
        name = self._text()
        (value,) = self._unpack(_NUMBER)
        return AuxValue(name, value, self._text(), self._time())

    def _zeros(self) -> Zeros:
        numbers = self._unpack(_ZERO_EPOCHS)
        zeros = tuple(ZeroEpoch(number, self._time()) for number in numbers)
        return zeros if any(one != UNKNOWN_ZERO for one in zeros) else ()

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

    def _list(self, item: Callable[[], Item]) -> List[Item]:
        size = self._size()
        # Each item has at least its length; a damaged size must not fill the memory.
        if _LENGTH.size * size > len(self._data) - self._place:
            raise struct.error(f"a list of {size} items is longer than the message")
        return [item() for _ in range(size)]
