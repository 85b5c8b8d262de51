"""One trace, checked: a sweep and where it was measured."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import astuple, dataclass
from typing import Tuple

from gpr20_common.message import Message
from gpr20_survey import faults
from gpr20_survey.axes.zero_epoch import Zeros, are_zeros
from gpr20_survey.trace.aux_value import AuxValue, check_aux
from gpr20_survey.trace.sweep import Sweep, check_time, refuse, shortened

FORMAT = "gpr20-trace/1"
MAX_INDEX = 999_999  # six digits in the file name
MAX_COORDINATE = 10_000.0  # [mm or deg], more than any axis of this robot

SURVEY_ID = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}")
SAMPLE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._:-]{0,127}")


@dataclass(frozen=True, eq=False)
class Trace(Sweep):
    """One S21 sweep at one antenna position; making one checks every value.

    The same record is measured, stored, published and read back. Its names are those of the
    JSON file and of gpr20_msgs/Trace.

    Attributes:
        survey_id: UUID of the survey, lower case with hyphens.
        sample_id: Unique name of this sample within all surveys.
        index: Place in the survey's plan, from 0.
        timestamp_us: When the sample was complete [us since 1970, UTC].
        x_coord_mm: Read from the axis after the move [mm].
        y_coord_mm: Likewise [mm].
        z_coord_deg: Rotation of the antennas [deg].
        antennae_height_m: Above the ground [m]; NaN if it was not measured.
        format: Version of this record.
        aux: What other sensors measured at this trace; names are unique.
        zeros: The zeros that x, y and z refer to; empty if they are not known.

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """

    survey_id: str
    sample_id: str
    index: int
    timestamp_us: int
    x_coord_mm: float
    y_coord_mm: float
    z_coord_deg: float
    antennae_height_m: float
    format: str = FORMAT
    aux: Tuple[AuxValue, ...] = ()
    zeros: Zeros = ()

    def __post_init__(self) -> None:
        self._check_names()
        self._check_position()
        super().__post_init__()
        check_time("timestamp", self.timestamp_us)
        check_aux(self.aux)
        if not are_zeros(self.zeros):
            refuse(
                Message(
                    "the zeros of the axes are {zeros}; each of x, y and z must have one, with a "
                    "number above 0 and a time, or none",
                    zeros=shortened(str(self.zeros)),
                )
            )

    @property
    def label(self) -> Message:
        """Short name for messages."""
        return Message("trace {index} (sample {sample})", index=self.index, sample=self.sample_id)

    def fingerprint(self) -> bytes:
        """Return 16 bytes that are the same only for traces equal to the last bit."""
        height = self.antennae_height_m
        words = (
            *(self.format, self.survey_id, self.sample_id, self.index, self.timestamp_us),
            *(float(self.x_coord_mm), float(self.y_coord_mm), float(self.z_coord_deg)),
            *(None if math.isnan(height) else float(height), len(self.frequency_hz)),
            *(self.sweep_started_us, self.sweep_ended_us, tuple(self.quality)),
            *(float(self.analyzer.if_bandwidth_hz), *astuple(self.analyzer)[1:]),
            *((one.name, float(one.value), one.unit, one.stamp_us) for one in self.aux),
            *map(astuple, self.zeros),
        )
        digest = hashlib.blake2b(repr(words).encode(), digest_size=16)
        for values in (self.frequency_hz, self.s21_real, self.s21_imag):
            digest.update(values.tobytes())
        return digest.digest()

    def _check_names(self) -> None:
        if self.format != FORMAT:
            refuse(
                Message(
                    "format is {format}; it must be '{expected}'",
                    format=shortened(self.format),
                    expected=FORMAT,
                )
            )
        if not SURVEY_ID.fullmatch(self.survey_id):
            refuse(
                Message(
                    "survey_id is {survey_id}; it must be a UUID in lower case with hyphens",
                    survey_id=shortened(self.survey_id),
                )
            )
        if not SAMPLE_ID.fullmatch(self.sample_id):
            refuse(
                Message(
                    "sample_id is {sample_id}; it must be 1 to 128 letters, digits, dots, colons, "
                    "hyphens or underscores, the first a letter or digit",
                    sample_id=shortened(self.sample_id),
                )
            )
        if not 0 <= self.index <= MAX_INDEX:
            refuse(
                Message(
                    "{name} is {value}; it must lie between {lower} and {upper}",
                    name="index",
                    value=self.index,
                    lower=0,
                    upper=MAX_INDEX,
                )
            )

    def _check_position(self) -> None:
        for name in ("x_coord_mm", "y_coord_mm", "z_coord_deg"):
            value = getattr(self, name)
            # Written so that NaN, which fails every comparison, is refused too.
            if not -MAX_COORDINATE <= value <= MAX_COORDINATE:
                refuse(
                    Message(
                        "{name} is {value}; it must lie between {lower} and {upper}",
                        name=name,
                        value=str(value),
                        lower=f"{-MAX_COORDINATE:g}",
                        upper=f"{MAX_COORDINATE:g}",
                    )
                )
        if math.isinf(self.antennae_height_m):
            refuse(
                Message(
                    "antennae_height_m is infinite; it must be a number, or NaN if not measured"
                ),
                fault=faults.SENSOR_NOT_FINITE,
            )
