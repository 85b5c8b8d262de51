"""The echoes of a survey so far, bounded in memory, and the one scale of their levels.

Levels are in dB above the noise floor, which is measured where no echo arrives. The darkest shade
is just below the level that noise alone does not exceed, the brightest one at the strongest echoes
of the whole survey: both are the same at each depth and on each line. Noise alone reaches less
than a tenth of the scale.

Complex noise has magnitudes of a Rayleigh distribution: they exceed r times their root mean square
with the probability exp(-r^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.grid import Cells, Stop, SurveyGrid
from gpr20_survey.radar import (
    SMALLEST_LEVEL,
    FrequencyToDelay,
    decibels,
    delay_kernel,
    delay_of_depth,
    unambiguous_s,
)
from gpr20_survey.trace.trace import TraceBlock

MAX_VOLUME_BYTES = 256 << 20
BYTES_PER_SAMPLE = 8  # complex64
MAX_SAMPLES = 1024
# The mean of fewer traces contains too much of a target to be subtracted.
MIN_BACKGROUND_TRACES = 8
# So much above the surface is shown too: its echo shows whether the height is right.
ABOVE_SURFACE_M = 0.05
# The scale ends at the strong echoes of some of the traces: a few disturbed ones do not darken it.
TRACES_FOR_SCALE = 400
STRONG_PART = 0.98
# The scale is estimated again when there are so many times more traces, and when all are there.
SCALE_GROWTH = 1.05
# Delays at which only noise is expected. They begin at this part of the unambiguous delay and end
# before its end, where sidelobes of delay 0 are wrapped to. Their distance is that of independent
# samples below a Hann window, in reciprocals of the bandwidth.
LATE_PART = 0.5
LATE_MARGIN, LATE_STEP = 10.0, 2.0
MAX_LATE_SAMPLES, MIN_LATE_SAMPLES = 48, 4
# The lower quartile: some late delays may hold echoes of walls and trees, which only add power.
QUANTILE = 0.25
QUANTILE_OF_POWER = -math.log(1.0 - QUANTILE)
# Probability that noise alone exceeds the threshold anywhere in a whole survey.
FALSE_ALARM = 0.01
# The noise floor is an estimate: how far it may be off, with the hysteresis [dB].
ESTIMATE_MARGIN_DB = 0.8
# The darkest shade is so much below the highest level of noise, so that what comes close to it is
# not lost, and the brightest one at least so much above it [dB].
BELOW_THRESHOLD_DB = 2.0
MIN_SPAN_DB = 26.0
# The brightest level is a multiple of this, so that it changes rarely [dB].
TOP_STEP_DB, TICK_STEP_DB = 5.0, 10.0
# Smaller changes of the noise floor are not followed [dB].
HYSTERESIS_DB = 0.5


class RadarModel:
    """Takes traces in any order, also repeated ones, and stores their echoes.

    Nothing else of a trace is stored: single precision and a few delays are enough for a picture.
    The echoes of all planned traces have their place from the start, but memory is used only
    for those that are there. Of a plan so large that they would need more than MAX_VOLUME_BYTES,
    fewer delays of each are stored.

    Attributes:
        grid: The plan of the survey that is shown.
        transform: How sweeps become echoes; None before the first trace.
        count: How many traces are here.
        present: Which stops have a trace (bool, polarizations x rows x columns).
        echoes: Their echoes (complex64, the same shape x samples); 0 where no trace is.
        latest: Stop of the trace that came last of all, or of each polarization that has one.
        given_up: Traces that cannot be shown, and why, by their place in the plan.
    """

    def __init__(self) -> None:
        self.revision = 0
        self.begin(None)

    def begin(self, grid: Optional[SurveyGrid]) -> None:
        """Forget everything and wait for the traces of another survey."""
        self.grid = grid
        self.transform: Optional[FrequencyToDelay] = None
        shape = (0, 0, 0) if grid is None else (len(grid.rotations_deg), *grid.shape)
        self.present = np.zeros(shape, bool)
        self._heights_m = np.full(shape, np.nan, np.float32)
        self.echoes = np.zeros((*shape, 0), np.complex64)
        self._late = np.zeros((0, 0), np.complex64)
        self._sums = np.zeros((shape[0], 0), np.complex128)
        self._noises = np.full(shape, np.nan, np.float32)
        # With whether the background is removed, and how many traces were here.
        self._scale: Optional[Tuple[LevelScale, bool, int]] = None
        self.count = 0
        self.latest: Dict[Optional[int], Stop] = {}
        self.given_up: Dict[int, Message] = {}
        self.revision += 1

    def add_block(self, block: TraceBlock) -> Tuple[Message, ...]:
        """Take traces; return why some of them do not belong to their places in the plan.

        Those are given up. No trace is in the block twice.

        Raises:
            SurveyNotReadableError: They belong to another survey.
        """
        if not block.indices.size:
            return ()
        if self.grid is None or block.survey_id != self.grid.survey_id:
            raise SurveyNotReadableError(
                Message(
                    "trace {index} belongs to survey {survey}; another survey is shown",
                    index=int(block.indices[0]),
                    survey=block.survey_id[:40],
                )
            )
        planned = block.indices < self.grid.planned
        places = self.grid.cells(np.where(planned, block.indices, 0))
        fits = self.transform is None or self.transform.fits(block.frequency_hz)
        right = planned & self.grid.holds(places, block.positions) & fits
        wrong = {
            index: Message(
                "trace {index} is not as planned: it has another place or other frequencies",
                index=index,
            )
            for index in block.indices[~right].tolist()
        }
        self.given_up.update(wrong)
        if right.any():
            self._store(block, right, tuple(one[right] for one in places))
        self.revision += 1
        return tuple(wrong.values())

    def _store(self, block: TraceBlock, right: np.ndarray, places: Cells) -> None:
        row, column, polarization = places
        place = (polarization, row, column)
        transform = self.transform or self._begin_volume(block.frequency_hz)
        s21 = block.s21[right]
        echoes = transform.transform(s21)
        # Of one that came before, too; where none is, they are 0.
        changes = echoes - self.echoes[place]
        for number in np.unique(polarization).tolist():
            of_number = polarization == number
            self._sums[number] += changes[of_number].sum(axis=0, dtype=np.complex128)
            self.latest[number] = Stop(int(row[of_number][-1]), int(column[of_number][-1]))
        self.latest[None] = Stop(int(row[-1]), int(column[-1]))
        self.count += int(np.count_nonzero(~self.present[place]))
        self.echoes[place] = echoes
        self._heights_m[place] = block.heights_m[right]
        self._noises[place] = noise_of_traces(s21.astype(np.complex64) @ self._late)
        self.present[place] = True
        for index in self.given_up.keys() & set(block.indices[right].tolist()):
            del self.given_up[index]

    def give_up(self, index: int, reason: Message) -> None:
        """Note that a stored trace cannot be shown; it is not requested again."""
        self.given_up[index] = reason
        self.revision += 1

    def absent(self, stored: np.ndarray) -> np.ndarray:
        """Return which of the stored places in the plan are not here, ascending."""
        if self.grid is None:
            return np.zeros(0, np.intp)
        row, column, polarization = self.grid.cells(stored)
        absent = stored[~self.present[polarization, row, column]]
        return absent[~np.isin(absent, list(self.given_up))]

    def heights_m(self, polarization: int) -> np.ndarray:
        """Return the height of every stop [m]; one that is not known is the median of the rest.

        All are NaN if none is known.
        """
        own = self._heights_m[polarization]
        return np.where(np.isfinite(own), own, self.typical_height_m())

    def typical_height_m(self) -> float:
        """Return the median of the known heights [m]; NaN if none is known."""
        known = self._heights_m[np.isfinite(self._heights_m)]
        return float(np.median(known)) if known.size else math.nan

    def background(self, polarization: int) -> Optional[np.ndarray]:
        """Return what the traces of a polarization have in common; None while they are too few."""
        # Without a plan there are no polarizations.
        count = int(np.count_nonzero(self.present[polarization : polarization + 1]))
        if count < MIN_BACKGROUND_TRACES:
            return None
        return (self._sums[polarization] / count).astype(np.complex64)

    def scale(self) -> Optional[LevelScale]:
        """Return the one scale of levels for all pictures; None before the first trace."""
        if self.transform is None:
            return None
        counts = np.count_nonzero(self.present, axis=(1, 2))
        # Only where every polarization that has traces has a background.
        removed = bool((counts[counts > 0] >= MIN_BACKGROUND_TRACES).all())
        stops, before, scale = self.present.size, 0, None
        if self._scale is not None and self._scale[1] is removed:
            scale, _removed, before = self._scale
        if scale is None or self.count >= SCALE_GROWTH * before + 1 or before < self.count == stops:
            found = noise_of_survey(self._noises), self._strongest(self.transform, removed)
            scale = LevelScale.of(stops * self.transform.samples, *found, before=scale)
            self._scale = scale, removed, self.count
        return scale

    def _strongest(self, transform: FrequencyToDelay, removed: bool) -> float:
        """Return the amplitude of the strong echoes from just above the surface on."""
        height_m = self.typical_height_m()
        first_s = 0.0
        if np.isfinite(height_m):
            first_s = float(delay_of_depth(-min(ABOVE_SURFACE_M, height_m), height_m, 1.0))
        first = min(int(first_s / transform.step_s), transform.samples - 1)
        strongest = 0.0
        for polarization, present in enumerate(self.present):
            rows, columns = np.nonzero(present)
            every = max(1, len(rows) // TRACES_FOR_SCALE)
            some = self.echoes[polarization][rows[::every], columns[::every], first:]
            background = self.background(polarization) if removed else None
            if some.size:
                echoes = some if background is None else some - background[first:]
                peaks = np.abs(echoes).max(axis=1)
                strongest = max(strongest, float(np.quantile(peaks, STRONG_PART)))
        return strongest

    def _begin_volume(self, frequency_hz: np.ndarray) -> FrequencyToDelay:
        room = MAX_VOLUME_BYTES // (BYTES_PER_SAMPLE * max(1, self.present.size))
        transform = FrequencyToDelay.resolved(frequency_hz, min(MAX_SAMPLES, room))
        self.transform, self._late = transform, late_kernel(frequency_hz)
        # Zeros are given by the system page by page when they are written.
        self.echoes = np.zeros((*self.present.shape, transform.samples), np.complex64)
        self._sums = np.zeros((len(self.present), transform.samples), np.complex128)
        return transform


def late_kernel(frequency_hz: np.ndarray) -> np.ndarray:
    """Return what turns sweeps into samples at delays at which only noise is expected.

    It is complex64 (frequency, delay).
    """
    bandwidth_hz = float(frequency_hz[-1] - frequency_hz[0])
    end_s = unambiguous_s(frequency_hz)
    first_s, last_s = LATE_PART * end_s, end_s - LATE_MARGIN / bandwidth_hz
    count = int((last_s - first_s) * bandwidth_hz / LATE_STEP)
    if count < MIN_LATE_SAMPLES:
        # Few frequencies: echoes may arrive here, so that the noise is rather overestimated.
        delays_s = np.linspace(first_s, end_s, MIN_LATE_SAMPLES, endpoint=False)
    else:
        delays_s = np.linspace(first_s, last_s, min(count, MAX_LATE_SAMPLES))
    return delay_kernel(frequency_hz, delays_s).astype(np.complex64)


def noise_of_traces(late: np.ndarray) -> np.ndarray:
    """Return the root mean square of the noise of each trace.

    Args:
        late: Complex samples at delays where no echo is expected (..., delay).
    """
    # Much faster than numpy's quantile, which interpolates between two of the samples.
    place = int(QUANTILE * late.shape[-1])
    power = np.partition(late.real**2 + late.imag**2, place, axis=-1)[..., place]
    return np.sqrt(power / QUANTILE_OF_POWER)


def noise_of_survey(noises: np.ndarray) -> float:
    """Return the noise floor: that of the noisier polarization; 0 if nothing is known.

    Args:
        noises: Noise of each trace, first axis polarization; NaN where there is no trace.
    """
    flat = noises.reshape(len(noises), -1)
    known = [row[np.isfinite(row)] for row in flat]
    return max((float(np.median(row)) for row in known if row.size), default=0.0)


def noise_threshold_db(samples: int) -> float:
    """Return the level above the noise floor [dB] that noise alone does not exceed.

    Args:
        samples: How many values of noise there are in all.
    """
    ratio = math.sqrt(-math.log(FALSE_ALARM / max(samples, 1)))
    return float(decibels(ratio)) + ESTIMATE_MARGIN_DB


@dataclass(frozen=True)
class LevelScale:
    """How levels become shades.

    Args:
        noise: Root mean square of the noise, as an amplitude.
        threshold_db: Level that noise alone does not exceed [dB above noise].
        top_db: Level of the brightest shade [dB above noise].
    """

    noise: float
    threshold_db: float
    top_db: float

    @classmethod
    def of(
        cls, samples: int, noise: float, strongest: float, before: Optional[LevelScale] = None
    ) -> LevelScale:
        """Return the scale of a survey; it changes rarely while traces come, its top only rises.

        Args:
            samples: How many values of noise the planned survey has.
            noise: Noise floor, as an amplitude.
            strongest: Amplitude of the strong echoes of the survey.
            before: Its scale so far.
        """
        noise, threshold_db = max(noise, SMALLEST_LEVEL), noise_threshold_db(samples)
        if before is not None and abs(decibels(noise / before.noise)) <= HYSTERESIS_DB:
            noise = before.noise
        strongest_db = float(decibels(max(strongest, SMALLEST_LEVEL) / noise))
        top_db = max(strongest_db, threshold_db + MIN_SPAN_DB, before.top_db if before else 0.0)
        return cls(noise, threshold_db, math.ceil(top_db / TOP_STEP_DB) * TOP_STEP_DB)

    def levels_db(self, amplitudes: np.ndarray) -> np.ndarray:
        """Return levels of amplitudes [dB above noise]; NaN stays NaN."""
        return decibels(amplitudes) - float(decibels(self.noise))

    def shades(self, levels_db: np.ndarray) -> np.ndarray:
        """Return shades of levels [dB above noise] from 0, noise, to 1 (float32); NaN stays NaN."""
        dark_db = self.threshold_db - BELOW_THRESHOLD_DB
        parts = (np.asarray(levels_db) - dark_db) / (self.top_db - dark_db)
        return np.clip(parts, 0.0, 1.0).astype(np.float32)

    def ticks(self) -> np.ndarray:
        """Return round levels [dB above noise] and their shades, the lowest first (n x 2)."""
        first = math.ceil((self.threshold_db - BELOW_THRESHOLD_DB) / TICK_STEP_DB) * TICK_STEP_DB
        levels_db = np.arange(first, self.top_db + 1.0, TICK_STEP_DB)
        return np.stack((levels_db, self.shades(levels_db)), axis=1)
