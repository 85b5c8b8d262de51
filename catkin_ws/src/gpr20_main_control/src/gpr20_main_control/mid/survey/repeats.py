"""What a place says that a survey measures again: a known point, and its first stop.

A known point shows whether the axes still have the zeros of the stored traces; the first stop, from
time to time, how the radar drifts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Sequence, Tuple

import numpy as np

from gpr20_common.message import Message, numeral
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.sweep_difference import (
    Drift,
    difference_db,
    difference_power,
    drift_between,
    finite,
    noise_db,
    s21_of,
)
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.trace.aux_value import VNA_TEMPERATURE
from gpr20_survey.trace.trace import Trace

# Another rotation must fit at least this many times better [power] to count as the true one.
ROTATION_FACTOR = 2.0
MAX_FREQUENCIES = 201  # of more, evenly chosen ones are stored
PS = 1e12


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
    def message(self) -> Message:
        """The comparison in one sentence."""
        values = {
            "index": self.stored.index,
            "below_db": numeral(-self.difference_db, ".1f"),
        }
        if not math.isfinite(self.height_difference_m):
            return Message(
                "point {index} was measured again; the difference is {below_db} dB below the "
                "stored trace",
                **values,
            )
        return Message(
            "point {index} was measured again; the difference is {below_db} dB below the stored "
            "trace, that of the height {height_mm:+.1f} mm",
            **values,
            height_mm=1000.0 * self.height_difference_m,
        )


def known_traces(recent: Iterable[Trace], rotations: int) -> List[Trace]:
    """Return the latest stored traces of one stop at all rotations, in the order of their visit.

    Before the first stop is complete: the latest trace of each rotation so far.
    """
    ordered = sorted(recent, key=lambda trace: trace.index)
    stops: Dict[Tuple[float, float], Dict[float, Trace]] = {}
    latest: Dict[float, Trace] = {}
    for trace in ordered:
        stops.setdefault((trace.x_coord_mm, trace.y_coord_mm), {})[trace.z_coord_deg] = trace
        latest[trace.z_coord_deg] = trace
    complete = [stop for stop in stops.values() if len(stop) == rotations]
    chosen = complete[-1] if complete else latest
    return sorted(chosen.values(), key=lambda trace: trace.index)


@dataclass(frozen=True)
class KnownPoint:
    """What measuring a known point again says about the zeros.

    Attributes:
        repeats: It, at each rotation.
        turned: Whether the new traces fit those of other rotations clearly better.
    """

    repeats: Sequence[Repeated]
    turned: bool

    def agrees(self, limit_db: float) -> bool:
        """Return whether every trace differs by less than a limit, and fits its own rotation."""
        return not self.turned and all(one.difference_db <= limit_db for one in self.repeats)

    @property
    def message(self) -> Message:
        """The largest difference in one sentence."""
        return max(self.repeats, key=lambda one: one.difference_db).message


def compare_known_point(repeats: Sequence[Repeated]) -> KnownPoint:
    """Compare the traces of a known point with new ones.

    Where the ground and its targets look the same at every rotation, a wrong rotation cannot
    show; where they do not, traces of a wrong rotation fit those of another one better.
    """
    stored = [s21_of(one.stored) for one in repeats]
    again = [s21_of(one.again[0]) for one in repeats]
    if len(repeats) < 2:
        return KnownPoint(repeats, turned=False)
    powers = np.array([[difference_power(old, new) for old in stored] for new in again])
    own = float(np.trace(powers))
    np.fill_diagonal(powers, np.inf)
    return KnownPoint(repeats, own > ROTATION_FACTOR * float(powers.min(axis=1).sum()))


@dataclass(frozen=True)
class Visit:
    """What a visit of the first stop says.

    Attributes:
        worst: The drift at the rotation where it is largest, since the start or what was accepted.
        z_deg: That rotation [deg].
        exceeded: Whether it exceeds a limit.
        values: What the log says of it.
    """

    worst: Drift
    z_deg: float
    exceeded: bool
    values: Dict[str, Any]

    @property
    def message(self) -> Message:
        """The drift in one sentence."""
        # As text: an infinite drift has no number in JSON.
        return Message(
            "the reference point at {z_deg:g} deg has drifted by {amplitude_db} dB and "
            "{phase_deg} deg",
            z_deg=self.z_deg,
            amplitude_db=numeral(self.worst.amplitude_rms_db, ".2f"),
            phase_deg=numeral(self.worst.phase_rms_deg, ".1f"),
        )


class DriftLimits:
    """Whether the drift of one survey is within its limits.

    After too large a drift the operator looks for its cause and resumes the survey. The first stop
    is then measured again, and the limits apply to the drift since. What is stored is always the
    drift since the start.
    """

    def __init__(self, settings: SurveySettings) -> None:
        """Take the settings, which have the limits."""
        self._settings = settings
        self._accepted: Dict[int, np.ndarray] = {}
        self._asked = False

    def visit(self, repeats: Sequence[Repeated], next_index: int, time: str) -> Visit:
        """Return what a visit says: each rotation, measured twice."""
        accepted, self._asked = self._asked, False
        if accepted:
            self._accepted = {one.stored.index: one.mean for one in repeats}
        drifts = [self._since_accepted(one) for one in repeats]
        worst = max(range(len(drifts)), key=lambda place: self._part_of_limits(drifts[place]))
        exceeded = not self._part_of_limits(drifts[worst]) <= 1.0
        values = {
            "time": time,
            "next_index": next_index,
            "limit_db": self._settings.drift_limit_db,
            "limit_deg": self._settings.drift_limit_deg,
            "accepted": accepted,
            "exceeded": exceeded,
            "frequency_hz": _thinned(repeats[0].stored.frequency_hz),
            "rotations": [_recorded(one) for one in repeats],
        }
        return Visit(drifts[worst], repeats[worst].stored.z_coord_deg, exceeded, values)

    def ask(self, visit: Visit) -> DeviceError:
        """Return what asks the operator; the next visit is accepted as it is."""
        self._asked = True
        return DeviceError(
            Message(
                "{drift}; allowed are {limit_db:g} dB and {limit_deg:g} deg",
                drift=visit.message,
                limit_db=self._settings.drift_limit_db,
                limit_deg=self._settings.drift_limit_deg,
            ),
            fault=faults.DRIFTED,
        )

    def _since_accepted(self, repeated: Repeated) -> Drift:
        stored = repeated.stored
        earlier = self._accepted.get(stored.index, s21_of(stored))
        return drift_between(stored.frequency_hz, earlier, repeated.mean)

    def _part_of_limits(self, drift: Drift) -> float:
        return max(
            drift.amplitude_rms_db / self._settings.drift_limit_db,
            drift.phase_rms_deg / self._settings.drift_limit_deg,
        )


def _recorded(repeated: Repeated) -> Dict[str, Any]:
    """Return the drift at one rotation since the survey's start."""
    stored, (first, second) = repeated.stored, repeated.again
    drift = drift_between(stored.frequency_hz, s21_of(stored), repeated.mean)
    temperatures = [one.value for one in first.aux if one.name == VNA_TEMPERATURE]
    return {
        "index": stored.index,
        "z_deg": stored.z_coord_deg,
        "amplitude_rms_db": finite(drift.amplitude_rms_db),
        "phase_rms_deg": finite(drift.phase_rms_deg),
        "gain_db": finite(drift.gain_db),
        "delay_ps": finite(drift.delay_s * PS),
        "noise_db": finite(noise_db(s21_of(first), s21_of(second))),
        "height_difference_m": finite(repeated.height_difference_m),
        "vna_temperature_c": temperatures[0] if temperatures else None,
        "amplitude_db": _thinned(drift.amplitude_db),
        "phase_deg": _thinned(drift.phase_deg),
    }


def _thinned(values: np.ndarray) -> List[Any]:
    count = min(len(values), MAX_FREQUENCIES)
    places = np.linspace(0, len(values) - 1, count).round().astype(int)
    return [finite(float(one)) for one in values[places]]
