"""One trace, checked: a sweep and where it was measured."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import dataclass
from typing import Any, Dict, Mapping, Sequence, Tuple

import numpy as np

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message
from gpr20_common.mid.codec import shortened
from gpr20_survey import faults
from gpr20_survey.axes import AXES, UNKNOWN_ZERO, ZeroEpoch, Zeros, are_zeros
from gpr20_survey.trace import trace_form as forms
from gpr20_survey.trace.sweep import SETTINGS, SWEEP_FIELDS, AnalyzerSettings, Sweep

MAX_AUX_VALUES = 32
MAX_UNIT_CHARACTERS = 32
# Of the analyzer itself; no other sensor has this name.
VNA_TEMPERATURE = "vna_temperature"
AUX_NAME = re.compile(r"[a-z][a-z0-9_]{0,63}")
_SENSOR_NAMED = Message("1 to 64 of a-z, 0-9 and _, the first a letter")
_SENSOR_NAME = forms.Rule(AUX_NAME.fullmatch, _SENSOR_NAMED, CONFIGURATION)
AUX_UNIT = forms.printable(MAX_UNIT_CHARACTERS, CONFIGURATION)
SAMPLE = np.dtype("<c8")
POSITION = ("x_coord_mm", "y_coord_mm", "z_coord_deg")


@dataclass(frozen=True)
class AuxValue:
    """One value of one sensor."""

    name: str = forms.of(forms.TEXT, "such as `soil_moisture`", rule=_SENSOR_NAME)
    value: float = forms.of(forms.FLOAT64, "a finite number")
    unit: str = forms.of(forms.TEXT, "its unit; may be empty", rule=AUX_UNIT)
    stamp_us: int = forms.of(forms.TIME, "when the robot received it")


AUX_RULE = forms.Rule(
    lambda values: len({one.name for one in values}) == len(values) <= MAX_AUX_VALUES,
    Message("at most {most} values, none of them twice", most=MAX_AUX_VALUES),
    CONFIGURATION,
)


FORMAT = "gpr20-trace/1"
MAX_INDEX = 999_999  # six digits in the file name
MAX_COORDINATE = 10_000.0  # [mm or deg], more than any axis of this robot

SURVEY_ID = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}")
SAMPLE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._:-]{0,127}")
_UUID = forms.Rule(SURVEY_ID.fullmatch, Message("a UUID in lower case with hyphens"))
_NAME = forms.Rule(
    SAMPLE_ID.fullmatch,
    Message(
        "1 to 128 letters, digits, dots, colons, hyphens or underscores, the first a letter or "
        "digit"
    ),
)
_COORDINATE = forms.between(-MAX_COORDINATE, MAX_COORDINATE)


@dataclass(frozen=True, eq=False)
class Trace(Sweep):  # type: ignore[misc]  # `of` is no default
    """One S21 sweep at one antenna position; making one checks every value.

    The same record is measured, stored, published and read back. What is declared here with `of`
    is a line of the table TRACE_FIELDS, from which its JSON file, its message, the columns of a
    Dataset and the page of the formats come.

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """

    survey_id: str = forms.of(forms.TEXT, "UUID of the survey", rule=_UUID)
    sample_id: str = forms.of(forms.TEXT, "unique name within all surveys", rule=_NAME)
    index: int = forms.of(
        forms.UINT32, "place in the survey's plan, from 0", rule=forms.between(0, MAX_INDEX)
    )
    timestamp_us: int = forms.of(forms.TIME, "when the sample was complete")
    x_coord_mm: float = forms.of(forms.FLOAT64, "read from the axis", "mm", rule=_COORDINATE)
    y_coord_mm: float = forms.of(forms.FLOAT64, "read from the axis", "mm", rule=_COORDINATE)
    z_coord_deg: float = forms.of(
        forms.FLOAT64, "rotation of the antennas", "degree", rule=_COORDINATE
    )
    antennae_height_m: float = forms.of(forms.FLOAT64, "above the ground", "m", math.nan)
    aux: Tuple[AuxValue, ...] = forms.of(
        forms.list_of(forms.record_of(AuxValue)),
        "what other sensors measured",
        rule=AUX_RULE,
        default=(),
    )
    # Empty if they are not known.
    zeros: Zeros = ()

    def __post_init__(self) -> None:
        forms.check(_OWN, vars(self))
        super().__post_init__()
        if not are_zeros(self.zeros):
            forms.refuse(
                Message(
                    "the zeros of the axes are {zeros}; each of x, y and z must have one, with a "
                    "number above 0 and a time, or none",
                    zeros=shortened(self.zeros),
                )
            )

    @property
    def label(self) -> Message:
        return Message("trace {index} (sample {sample})", index=self.index, sample=self.sample_id)

    def values(self) -> Dict[str, Any]:
        """Return the value of each of TRACE_FIELDS by its attribute."""
        zeros = self.zeros or AXES * (UNKNOWN_ZERO,)
        return {
            **vars(self),
            **vars(self.analyzer),
            "format": FORMAT,
            "zero_epochs": tuple([one.number for one in zeros]),
            "zero_times_us": tuple([one.time_us for one in zeros]),
        }

    @classmethod
    def of_values(cls, values: Mapping[str, Any]) -> Trace:
        """Return the trace of the values of TRACE_FIELDS, by their attributes.

        Raises:
            TraceRefusedError: A value is not allowed; the message names it.
        """
        held = {**values}
        check_format(held.pop("format"))
        analyzer = AnalyzerSettings(*[held.pop(one.attribute) for one in SETTINGS])
        numbers, times_us = held.pop("zero_epochs"), held.pop("zero_times_us")
        is_known = any(numbers) or any(times_us)
        zeros = tuple(map(ZeroEpoch, numbers, times_us)) if is_known else ()
        return cls(**held, analyzer=analyzer, zeros=zeros)

    def packed(self, header: bytes = b"") -> bytes:
        """Return all TRACE_FIELDS as a ROS message holds them, behind its header."""
        values = self.values()
        packed = [pack(values[attribute]) for attribute, pack in _PACKED]
        return b"".join([header, *packed])

    def fingerprint(self) -> bytes:
        """Return 16 bytes that are the same only for traces equal to the last bit."""
        return hashlib.blake2b(self.packed(), digest_size=16).digest()


def check_format(found: str) -> None:
    """Refuse a version of the record that is not FORMAT.

    Raises:
        TraceRefusedError: It is another one.
    """
    if found != FORMAT:
        reason = Message(
            "its format is {format}; this software reads {expected}",
            format=shortened(found),
            expected=repr(FORMAT),
        )
        forms.refuse(reason, faults.OTHER_VERSION)


_OWN = [one for one in forms.fields_of(Trace) if one not in SWEEP_FIELDS]
TRACE_FIELDS = (
    forms.TraceField("format", forms.TEXT, f"`{FORMAT}`"),
    *(one for one in _OWN if not hasattr(Trace, one.attribute)),
    *SWEEP_FIELDS,
    *SETTINGS,
    # Those with a default come last.
    *(one for one in _OWN if hasattr(Trace, one.attribute)),
    forms.TraceField(
        "zero_epochs",
        forms.list_of(forms.UINT32, AXES),
        "numbers of the zeros of x, y and z",
        "",
        AXES * (0,),
    ),
    forms.TraceField(
        "zero_times_us",
        forms.list_of(forms.TIME, AXES),
        "when those zeros were found or set",
        "",
        AXES * (0,),
    ),
)
"""The table of a trace's fields, in the order of Trace.msg."""
_PACKED = [(one.attribute, one.form.pack) for one in TRACE_FIELDS]


@dataclass(frozen=True, eq=False)
class TraceBlock:
    """Traces of one survey that have the same frequencies.

    Attributes:
        survey_id: UUID of the survey.
        frequency_hz: Frequencies [Hz, float64, shape (points,)], ascending; empty without traces.
        indices: Places in the plan [int64, shape (traces,)].
        positions: Each row x [mm], y [mm], z [deg] [float64, shape (traces, 3)].
        heights_m: Above the ground [m, float64, shape (traces,)]; NaN if not measured.
        s21: S21, linear [complex64, shape (traces, points)].
    """

    survey_id: str
    frequency_hz: np.ndarray
    indices: np.ndarray
    positions: np.ndarray
    heights_m: np.ndarray
    s21: np.ndarray

    @classmethod
    def of(cls, survey_id: str, traces: Sequence[Trace]) -> TraceBlock:
        """Return the block of traces that have the same frequencies."""
        frequency_hz = traces[0].frequency_hz if traces else np.zeros(0)
        s21 = np.empty((len(traces), len(frequency_hz)), SAMPLE)
        for row, trace in zip(s21, traces):
            row.real, row.imag = trace.s21_real, trace.s21_imag
        places = [[getattr(one, name) for name in POSITION] for one in traces]
        return cls(
            survey_id,
            frequency_hz,
            np.array([one.index for one in traces], np.int64),
            np.array(places, np.float64).reshape(-1, 3),
            np.array([one.antennae_height_m for one in traces], np.float64),
            s21,
        )


def block_fields(block: TraceBlock) -> Dict[str, Any]:
    return {
        "survey_id": block.survey_id,
        "frequency_hz": block.frequency_hz.tolist(),
        "indices": block.indices.tolist(),
        **dict(zip(POSITION, block.positions.T.tolist())),
        "antennae_height_m": block.heights_m.tolist(),
        "s21": block.s21.tobytes(),
    }


def block_from(message: Any) -> TraceBlock:
    """Return the block of an answer of `read_traces`."""
    count, points = len(message.indices), len(message.frequency_hz)
    positions = [getattr(message, name) for name in POSITION]
    return TraceBlock(
        message.survey_id,
        np.array(message.frequency_hz, np.float64),
        np.array(message.indices, np.int64),
        np.array(positions, np.float64).T,
        np.array(message.antennae_height_m, np.float64),
        np.frombuffer(message.s21, SAMPLE).reshape(count, points),
    )
