"""The drift of one survey: its first stop, measured again from time to time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Dict, List, Sequence

import numpy as np

from gpr20_common.message import Message, numeral
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.drift import Drift, drift_between, noise_db, s21_of
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.trace.aux_value import VNA_TEMPERATURE
from gpr20_survey.trace.trace import Trace

MAX_FREQUENCIES = 201  # of more, evenly chosen ones are stored
DETAILS = ("amplitude_db", "phase_deg")
PS = 1e12


@dataclass(frozen=True)
class Revisit:
    """A point of the reference and two sweeps of it in a row, with the axes at rest."""

    stored: Trace
    first: Trace
    second: Trace

    @property
    def mean(self) -> np.ndarray:
        """S21, the mean of both sweeps."""
        return (s21_of(self.first) + s21_of(self.second)) / 2.0


@dataclass(frozen=True)
class Visit:
    """What a visit of the reference says.

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

    After too large a drift the operator looks for its cause and resumes the survey. The reference
    is then measured again, and the limits apply to the drift since. What is stored is always the
    drift since the start.
    """

    def __init__(self, settings: SurveySettings) -> None:
        """Take the settings, which have the limits."""
        self._settings = settings
        self._accepted: Dict[int, np.ndarray] = {}
        self._asked = False

    def visit(self, revisits: Sequence[Revisit], next_index: int, time: str) -> Visit:
        """Return what a visit says.

        Args:
            revisits: One of each rotation.
            next_index: Index of the next trace.
            time: The time of day.
        """
        accepted, self._asked = self._asked, False
        if accepted:
            self._accepted = {one.stored.index: one.mean for one in revisits}
        drifts = [self._since_accepted(one) for one in revisits]
        worst = max(range(len(drifts)), key=lambda place: self._part_of_limits(drifts[place]))
        exceeded = not self._part_of_limits(drifts[worst]) <= 1.0
        values = {
            "time": time,
            "next_index": next_index,
            "limit_db": self._settings.drift_limit_db,
            "limit_deg": self._settings.drift_limit_deg,
            "accepted": accepted,
            "exceeded": exceeded,
            "frequency_hz": _thinned(revisits[0].stored.frequency_hz),
            "rotations": [_recorded(one) for one in revisits],
        }
        return Visit(drifts[worst], revisits[worst].stored.z_coord_deg, exceeded, values)

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

    def _since_accepted(self, revisit: Revisit) -> Drift:
        stored = revisit.stored
        earlier = self._accepted.get(stored.index, s21_of(stored))
        return drift_between(stored.frequency_hz, earlier, revisit.mean)

    def _part_of_limits(self, drift: Drift) -> float:
        return max(
            drift.amplitude_rms_db / self._settings.drift_limit_db,
            drift.phase_rms_deg / self._settings.drift_limit_deg,
        )


def _recorded(revisit: Revisit) -> Dict[str, Any]:
    """Return the drift at one rotation since the survey's start."""
    stored = revisit.stored
    drift = drift_between(stored.frequency_hz, s21_of(stored), revisit.mean)
    heights_m = [revisit.first.antennae_height_m, stored.antennae_height_m]
    temperatures = [one.value for one in revisit.first.aux if one.name == VNA_TEMPERATURE]
    return {
        "index": stored.index,
        "z_deg": stored.z_coord_deg,
        "amplitude_rms_db": _finite(drift.amplitude_rms_db),
        "phase_rms_deg": _finite(drift.phase_rms_deg),
        "gain_db": _finite(drift.gain_db),
        "delay_ps": _finite(drift.delay_s * PS),
        "noise_db": _finite(noise_db(s21_of(revisit.first), s21_of(revisit.second))),
        "height_difference_m": _finite(heights_m[0] - heights_m[1]),
        "vna_temperature_c": temperatures[0] if temperatures else None,
        **{name: _thinned(getattr(drift, name)) for name in DETAILS},
    }


def _thinned(values: np.ndarray) -> List[Any]:
    count = min(len(values), MAX_FREQUENCIES)
    places = np.linspace(0, len(values) - 1, count).round().astype(int)
    return [_finite(float(one)) for one in values[places]]


def _finite(value: float) -> Any:
    # Strict JSON has no other numbers; more digits than these are noise.
    return round(value, 4) if math.isfinite(value) else None
