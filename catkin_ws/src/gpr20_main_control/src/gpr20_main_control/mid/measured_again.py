"""A place measured again: how two sweeps differ, and what a survey concludes from that.

A known point shows whether the axes still have the zeros of the stored traces; the first stop, from
time to time, how the radar drifts. The daily check uses the same differences.

With r the earlier sweep and m the later one, the ratio m / r gives at each frequency the drift of
amplitude, 20 log10 |m / r| [dB], and of phase, arg(m / r) [deg, -180 to 180]. Summed over the
band each frequency counts by its power |r|^2, so that nulls, where only noise is left, count for
nothing: RMS = sqrt(sum(|r|^2 d^2) / sum(|r|^2)).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message, numeral, verbatim
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.trace import Trace

# Another rotation must fit at least this many times better [power] to count as the true one.
ROTATION_FACTOR = 2.0


@dataclass(frozen=True)
class Drift:
    """The difference of a later sweep from an earlier one; infinite if that has no signal."""

    amplitude_rms_db: float = math.inf
    phase_rms_deg: float = math.inf


def s21_of(sweep: Sweep) -> np.ndarray:
    """Return the complex S21 of a sweep."""
    return sweep.s21_real + 1j * sweep.s21_imag


def drift_between(earlier: np.ndarray, later: np.ndarray) -> Drift:
    """Return the drift of S21 between two sweeps of the same frequencies."""
    power = np.abs(earlier) ** 2
    known = power > 0.0
    if not known.any():
        return Drift()
    # Relative to the largest: the sum of tiny powers must not become 0.
    weights = power[known] / power.max()
    ratio = later[known] / earlier[known]
    with np.errstate(divide="ignore"):
        amplitude_db = 20.0 * np.log10(np.abs(ratio))
    phase_deg = np.degrees(np.angle(ratio))
    return Drift(_weighted_rms(amplitude_db, weights), _weighted_rms(phase_deg, weights))


def difference_db(earlier: np.ndarray, later: np.ndarray) -> float:
    """Return the RMS of the difference relative to the earlier sweep [dB].

    Minus infinity if they are equal; infinity or NaN if the earlier one has no signal.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.linalg.norm(later - earlier) / np.linalg.norm(earlier)
        return float(20.0 * np.log10(ratio))


def noise_db(first: np.ndarray, second: np.ndarray) -> float:
    """Return the noise of one sweep relative to its signal, from two in a row at rest [dB].

    The difference of two sweeps has the noise of both: rms(second - first) / sqrt(2) is that of
    one. Minus infinity if they are equal.
    """
    return difference_db(first, second) - 10.0 * math.log10(2.0)


def finite(value: float) -> Optional[float]:
    """Return a figure as it is stored: strict JSON has no NaN, and more digits are noise."""
    return round(value, 4) if math.isfinite(value) else None


def _weighted_rms(values: np.ndarray, weights: np.ndarray) -> float:
    return math.sqrt(float(np.sum(weights * values**2) / np.sum(weights)))


@dataclass(frozen=True)
class Repeated:
    """A stored trace, and its point measured again: sweeps in a row, with the axes at rest."""

    stored: Trace
    again: Tuple[Trace, ...]

    @property
    def difference_db(self) -> float:
        """RMS of the difference of S21, relative to the stored trace [dB]; -inf if equal."""
        return difference_db(s21_of(self.stored), s21_of(self.again[0]))

    @property
    def height_difference_m(self) -> float:
        """New height minus the stored one [m]; NaN if either is missing."""
        return self.again[0].antennae_height_m - self.stored.antennae_height_m

    @property
    def mean(self) -> np.ndarray:
        """S21, the mean of the new sweeps."""
        return np.mean([s21_of(one) for one in self.again], axis=0)

    @property
    def values(self) -> Dict[str, Any]:
        """The comparison as the log has it."""
        return {
            "index": self.stored.index,
            "difference_db": finite(self.difference_db),
            "height_difference_m": finite(self.height_difference_m),
        }

    @property
    def message(self) -> Message:
        """The comparison in one sentence."""
        height_mm = 1000.0 * self.height_difference_m
        return Message(
            "point {index} was measured again; the difference is {below_db} dB below the stored "
            "trace, that of the height {height_mm} mm",
            index=self.stored.index,
            below_db=numeral(-self.difference_db, ".1f"),
            height_mm=numeral(height_mm, "+.1f") if math.isfinite(height_mm) else verbatim("-"),
        )


def known_traces(recent: Iterable[Trace], rotations: int) -> List[Trace]:
    """Return the latest stored traces of one stop at all rotations, in the order of their visit.

    Before the first stop is complete: the latest trace of each rotation so far.
    """
    stops: Dict[Tuple[float, float], Dict[float, Trace]] = {}
    latest: Dict[float, Trace] = {}
    for trace in sorted(recent, key=lambda trace: trace.index):
        stops.setdefault((trace.x_coord_mm, trace.y_coord_mm), {})[trace.z_coord_deg] = trace
        latest[trace.z_coord_deg] = trace
    complete = [stop for stop in stops.values() if len(stop) == rotations]
    chosen = complete[-1] if complete else latest
    return sorted(chosen.values(), key=lambda trace: trace.index)


@dataclass(frozen=True)
class KnownPoint:
    """What measuring a known point again, at each rotation, says about the zeros."""

    repeats: Sequence[Repeated]

    @property
    def turned(self) -> bool:
        """Whether the new traces fit those of other rotations clearly better.

        Where the ground and its targets look the same at every rotation, a wrong rotation cannot
        show; where they do not, traces of a wrong rotation fit those of another one better.
        """
        if len(self.repeats) < 2:
            return False
        stored = np.array([s21_of(one.stored) for one in self.repeats])
        again = np.array([s21_of(one.again[0]) for one in self.repeats])
        powers = np.sum(np.abs(again[:, None] - stored[None]) ** 2, axis=2)
        own = float(np.trace(powers))
        np.fill_diagonal(powers, np.inf)
        return own > ROTATION_FACTOR * float(powers.min(axis=1).sum())

    def agrees(self, limit_db: float) -> bool:
        """Return whether every trace differs by less than a limit, and fits its own rotation."""
        return not self.turned and all(one.difference_db <= limit_db for one in self.repeats)

    @property
    def message(self) -> Message:
        """The largest difference in one sentence."""
        return max(self.repeats, key=lambda one: one.difference_db).message


@dataclass(frozen=True)
class Visit:
    """What a visit of the first stop says, whether it is too much, and what the log says of it."""

    message: Message
    exceeded: bool
    # Always since the start.
    values: Dict[str, Any]


class DriftLimits:
    """Whether the drift of one survey is within its limits.

    After too large a drift the operator looks for its cause and resumes the survey. The first stop
    is then measured again, and the limits apply to the drift since.
    """

    def __init__(self, settings: SurveySettings) -> None:
        """Take the settings, which have the limits."""
        self._limits = {"limit_db": settings.drift_limit_db, "limit_deg": settings.drift_limit_deg}
        self._accepted: Dict[int, np.ndarray] = {}
        self._asked = False

    def visit(self, repeats: Sequence[Repeated], next_index: int, time: str) -> Visit:
        """Return what a visit says: each rotation, measured twice."""
        accepted = self._asked
        if accepted:
            self._accepted = {one.stored.index: one.mean for one in repeats}
        drifts = [self._since_accepted(one) for one in repeats]
        worst = max(range(len(drifts)), key=lambda place: self._part_of_limits(drifts[place]))
        # Written so that NaN exceeds it too.
        self._asked = not self._part_of_limits(drifts[worst]) <= 1.0
        # As text: an infinite drift has no number in JSON.
        message = Message(
            "the reference point at {z_deg:g} deg has drifted by {amplitude_db} dB and "
            "{phase_deg} deg; allowed are {limit_db:g} dB and {limit_deg:g} deg",
            z_deg=repeats[worst].stored.z_coord_deg,
            amplitude_db=numeral(drifts[worst].amplitude_rms_db, ".2f"),
            phase_deg=numeral(drifts[worst].phase_rms_deg, ".1f"),
            **self._limits,
        )
        values = {
            "time": time,
            "next_index": next_index,
            **self._limits,
            "accepted": accepted,
            "exceeded": self._asked,
            "rotations": [_recorded(one) for one in repeats],
        }
        return Visit(message, self._asked, values)

    def _since_accepted(self, repeated: Repeated) -> Drift:
        stored = repeated.stored
        return drift_between(self._accepted.get(stored.index, s21_of(stored)), repeated.mean)

    def _part_of_limits(self, drift: Drift) -> float:
        return max(
            drift.amplitude_rms_db / self._limits["limit_db"],
            drift.phase_rms_deg / self._limits["limit_deg"],
        )


def _recorded(repeated: Repeated) -> Dict[str, Any]:
    """Return the drift at one rotation since the survey's start."""
    stored, (first, second) = repeated.stored, repeated.again
    drift = drift_between(s21_of(stored), repeated.mean)
    return {
        "index": stored.index,
        "z_deg": stored.z_coord_deg,
        "amplitude_rms_db": finite(drift.amplitude_rms_db),
        "phase_rms_deg": finite(drift.phase_rms_deg),
        "noise_db": finite(noise_db(s21_of(first), s21_of(second))),
        "height_difference_m": finite(repeated.height_difference_m),
    }
