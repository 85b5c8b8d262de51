"""How two sweeps of the same place differ: drift of amplitude, phase and delay, and noise.

With r the earlier sweep and m the later one, the ratio m / r gives at each frequency the drift of
amplitude, 20 log10 |m / r| [dB], and of phase, arg(m / r) [deg, -180 to 180]. Summed over the
band each frequency counts by its power |r|^2, so that nulls, where only noise is left, count for
nothing: RMS = sqrt(sum(|r|^2 d^2) / sum(|r|^2)).

What is common to the band is one gain and one delay, as of a cable that grew warm. With
c = m conj(r), the delay t = -arg(sum(c[k+1] conj(c[k]))) / (2 pi df) needs no unwrapped phase; it
is unambiguous within half of the reciprocal of the frequency step df.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np

from gpr20_survey.radar.frequency_to_delay import phase_advance
from gpr20_survey.trace.sweep import Sweep


@dataclass(frozen=True)
class Drift:
    """The difference of a later sweep from an earlier one.

    Attributes:
        amplitude_db: At each frequency [dB]; NaN where the earlier sweep is 0.
        phase_deg: At each frequency [deg]; NaN where the earlier sweep is 0.
        amplitude_rms_db: Over the band, weighted by power [dB].
        phase_rms_deg: Over the band, weighted by power [deg].
        gain_db: Common to the band [dB].
        delay_s: Common to the band [s].
    """

    amplitude_db: np.ndarray
    phase_deg: np.ndarray
    amplitude_rms_db: float
    phase_rms_deg: float
    gain_db: float
    delay_s: float


def s21_of(sweep: Sweep) -> np.ndarray:
    """Return the complex S21 of a sweep."""
    return sweep.s21_real + 1j * sweep.s21_imag


def drift_between(frequency_hz: np.ndarray, earlier: np.ndarray, later: np.ndarray) -> Drift:
    """Return the drift between two sweeps; without any signal, it is infinite.

    Args:
        frequency_hz: Ascending, evenly spaced frequencies of both [Hz], at least two.
        earlier: S21 of one sweep.
        later: S21 of the other.
    """
    power = np.abs(earlier) ** 2
    known = power > 0.0
    ratio = np.full(len(power), complex(math.nan, math.nan))
    np.divide(later, earlier, out=ratio, where=known)
    with np.errstate(divide="ignore"):
        amplitude_db = 20.0 * np.log10(np.abs(ratio))
    phase_deg = np.where(known, np.degrees(np.angle(ratio)), math.nan)
    common = later * np.conj(earlier)
    turn = np.sum(common[1:] * np.conj(common[:-1]))
    step_hz = float(frequency_hz[-1] - frequency_hz[0]) / (len(frequency_hz) - 1)
    delay_s = -float(np.angle(turn)) / (2.0 * math.pi * step_hz)
    aligned = np.abs(np.sum(common * phase_advance(frequency_hz, np.array(delay_s))))
    return Drift(
        amplitude_db,
        phase_deg,
        _weighted_rms(amplitude_db, power),
        _weighted_rms(phase_deg, power),
        _decibels(float(aligned), float(np.sum(power))),
        delay_s,
    )


def difference_power(one: np.ndarray, other: np.ndarray) -> float:
    """Return the power of the difference of two sweeps, summed over their frequencies."""
    return float(np.sum(np.abs(other - one) ** 2))


def difference_db(earlier: np.ndarray, later: np.ndarray) -> float:
    """Return the RMS of the difference relative to the earlier sweep [dB].

    Minus infinity if they are equal; infinity if only the earlier one has no signal.
    """
    reference = float(np.sum(np.abs(earlier) ** 2))
    return _decibels(math.sqrt(difference_power(earlier, later)), math.sqrt(reference))


def noise_db(first: np.ndarray, second: np.ndarray) -> float:
    """Return the noise of one sweep relative to its signal, from two in a row at rest [dB].

    The difference of two sweeps has the noise of both: rms(second - first) / sqrt(2) is that of
    one. Minus infinity if they are equal.
    """
    return difference_db(first, second) - 10.0 * math.log10(2.0)


def finite(value: float) -> Optional[float]:
    """Return a figure as it is stored: strict JSON has no NaN, and more digits are noise."""
    return round(value, 4) if math.isfinite(value) else None


def _weighted_rms(values: np.ndarray, power: np.ndarray) -> float:
    known = power > 0.0
    if not known.any():
        return math.inf
    # Relative to the largest: the sum of tiny powers must not become 0.
    weights = power[known] / power[known].max()
    return math.sqrt(float(np.sum(weights * values[known] ** 2) / np.sum(weights)))


def _decibels(level: float, reference: float) -> float:
    if level == 0.0:
        return -math.inf
    return 20.0 * math.log10(level / reference) if reference > 0.0 else math.inf
