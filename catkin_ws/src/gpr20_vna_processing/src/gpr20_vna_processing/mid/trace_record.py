"""One trace, checked."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import dataclass
from typing import NoReturn, Tuple

import numpy as np

from gpr20_vna_processing.errors import TraceRefusedError
from gpr20_vna_processing.mid import utc_time

FORMAT = "gpr20-trace/1"
MAX_INDEX = 999_999  # six digits in the file name
MIN_POINTS, MAX_POINTS = 2, 4001
MAX_COORDINATE = 10_000.0  # [mm or deg], more than any axis of this robot
MAX_REMARKS, MAX_REMARK_CHARACTERS = 32, 200

SURVEY_ID = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}")
SAMPLE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9._:-]{0,127}")


@dataclass(frozen=True, eq=False)
class TraceRecord:
    """One S21 sweep at one antenna position; making one checks every value.

    Times are whole microseconds since 1970 in UTC: JSON, recordings and the published
    message are all made from this record and so hold the same moment.

    Raises:
        TraceRefusedError: A value is not allowed; the message names it.
    """

    format: str
    survey_id: str
    sample_id: str
    index: int
    timestamp_us: int
    x_coord_mm: float
    y_coord_mm: float
    z_coord_deg: float
    antennae_height_m: float
    frequency_hz: np.ndarray
    s21_real: np.ndarray
    s21_imag: np.ndarray
    sweep_started_us: int
    sweep_ended_us: int
    quality: Tuple[str, ...]

    def __post_init__(self) -> None:
        self._check_names()
        self._check_position()
        self._check_sweep()
        self._check_times()
        self._check_quality()

    @property
    def label(self) -> str:
        """Short name for messages."""
        return f"trace {self.index} (sample {self.sample_id})"

    def fingerprint(self) -> bytes:
        """Return 16 bytes that are the same only for traces equal to the last bit."""
        height = self.antennae_height_m
        words = (
            *(self.format, self.survey_id, self.sample_id, self.index, self.timestamp_us),
            *(float(self.x_coord_mm), float(self.y_coord_mm), float(self.z_coord_deg)),
            *(None if math.isnan(height) else float(height), len(self.frequency_hz)),
            *(self.sweep_started_us, self.sweep_ended_us, tuple(self.quality)),
        )
        digest = hashlib.blake2b(repr(words).encode(), digest_size=16)
        for values in (self.frequency_hz, self.s21_real, self.s21_imag):
            digest.update(values.tobytes())
        return digest.digest()

    def _check_names(self) -> None:
        if self.format != FORMAT:
            _refuse(f"format is {_short(self.format)}; it must be '{FORMAT}'")
        if not SURVEY_ID.fullmatch(self.survey_id):
            _refuse(f"survey_id is {_short(self.survey_id)}; it must be a UUID in lower case")
        if not SAMPLE_ID.fullmatch(self.sample_id):
            _refuse(
                f"sample_id is {_short(self.sample_id)}; it must be 1 to 128 letters, digits, "
                "dots, colons, hyphens or underscores, the first a letter or digit"
            )
        if not 0 <= self.index <= MAX_INDEX:
            _refuse(f"index is {self.index}; it must lie between 0 and {MAX_INDEX}")

    def _check_position(self) -> None:
        for name in ("x_coord_mm", "y_coord_mm", "z_coord_deg"):
            value = getattr(self, name)
            # Written so that NaN, which fails every comparison, is refused too.
            if not -MAX_COORDINATE <= value <= MAX_COORDINATE:
                _refuse(f"{name} is {value}; it must lie within +-{MAX_COORDINATE:g}")
        if math.isinf(self.antennae_height_m):
            _refuse("antennae_height_m is infinite; it must be a number, or NaN if not measured")

    def _check_sweep(self) -> None:
        points = len(self.frequency_hz)
        if not MIN_POINTS <= points <= MAX_POINTS:
            _refuse(f"there are {points} points; there must be {MIN_POINTS} to {MAX_POINTS}")
        for name in ("frequency_hz", "s21_real", "s21_imag"):
            values = getattr(self, name)
            if values.dtype != np.float64 or values.shape != (points,):
                _refuse(f"{name} has {values.size} values for {points} frequencies")
            if not np.isfinite(values).all():
                _refuse(f"{name} holds {np.count_nonzero(~np.isfinite(values))} NaN or infinities")
        if self.frequency_hz[0] <= 0.0 or not (np.diff(self.frequency_hz) > 0.0).all():
            _refuse("frequency_hz must be above zero and ascend from each point to the next")

    def _check_times(self) -> None:
        for name in ("timestamp_us", "sweep_started_us", "sweep_ended_us"):
            value = getattr(self, name)
            if not utc_time.is_plausible(value):
                moment = utc_time.iso_text(value)
                _refuse(f"{name[:-3]} is {moment}; set the computer's clock")
        if self.sweep_ended_us < self.sweep_started_us:
            _refuse(
                f"sweep_ended {utc_time.iso_text(self.sweep_ended_us)} lies before "
                f"sweep_started {utc_time.iso_text(self.sweep_started_us)}"
            )

    def _check_quality(self) -> None:
        if len(self.quality) > MAX_REMARKS:
            _refuse(f"quality has {len(self.quality)} remarks; at most {MAX_REMARKS} are allowed")
        for remark in self.quality:
            if len(remark) > MAX_REMARK_CHARACTERS or not remark.isprintable():
                _refuse(
                    f"quality holds {_short(remark)}; a remark must be printable and "
                    f"have at most {MAX_REMARK_CHARACTERS} characters"
                )


def _refuse(reason: str) -> NoReturn:
    raise TraceRefusedError(f"the trace is refused: {reason}")


def _short(text: str) -> str:
    return repr(text if len(text) <= 64 else text[:61] + "...")
