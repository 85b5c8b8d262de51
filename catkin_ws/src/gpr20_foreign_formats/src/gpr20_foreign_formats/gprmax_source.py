"""The signal of a simulated source, by which spectra are divided to get a transmission."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict

import numpy as np

from gpr20_analysis.errors import AnalysisError
from gpr20_common.message import Message
from gpr20_foreign_formats.header import refusal

WEAKEST_DB = -60.0
"""Where the source is weaker than this, relative to its maximum in the band, only noise is left."""
STEPS_PER_PERIOD, PERIODS = 64, 8


@dataclass(frozen=True)
class Signal:
    """A real signal at even times."""

    values: np.ndarray
    step_s: float
    start_s: float = 0.0

    def spectrum(self, frequency_hz: np.ndarray) -> np.ndarray:
        """Return the Fourier transform, with the sign of S21: a delay is a negative phase."""
        time_s = self.start_s + np.arange(len(self.values)) * self.step_s
        turns = np.exp(-2j * np.pi * frequency_hz[:, np.newaxis] * time_s)
        spectrum: np.ndarray = turns @ self.values * self.step_s
        return spectrum


def _gaussian(periods: np.ndarray) -> np.ndarray:
    return np.exp(-2.0 * (np.pi * (periods - 1.0)) ** 2)


def _ricker(periods: np.ndarray) -> np.ndarray:
    turns = (np.pi * (periods - np.sqrt(2.0))) ** 2
    return (1.0 - 2.0 * turns) * np.exp(-turns)


WAVEFORMS: Dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "gaussian": _gaussian,
    "gaussiandotnorm": lambda periods: (
        -2.0 * np.pi * (periods - 1.0) * np.exp(0.5) * _gaussian(periods)
    ),
    "ricker": _ricker,
}
"""Waveforms of gprMax by name, over periods of the centre frequency, as its manual has them."""


def source_of(text: str) -> Signal:
    """Return the signal of a waveform and its centre frequency in Hz, such as `ricker:1.5e9`.

    Raises:
        AnalysisError: It is none.
    """
    name, _, number = text.partition(":")
    try:
        frequency_hz = float(number)
    except ValueError:
        frequency_hz = np.nan
    if name not in WAVEFORMS or not 1e6 <= frequency_hz <= 1e12:
        raise AnalysisError(
            Message(
                "--source {text} is none of {waveforms} with a frequency from 1e6 to 1e12 Hz, such "
                "as ricker:1.5e9",
                text=text,
                waveforms=", ".join(WAVEFORMS),
            )
        )
    periods = np.arange(PERIODS * STEPS_PER_PERIOD) / STEPS_PER_PERIOD
    return Signal(WAVEFORMS[name](periods), 1.0 / frequency_hz / STEPS_PER_PERIOD)


def check_strength(source: Signal, frequency_hz: np.ndarray, name: str) -> np.ndarray:
    """Return the spectrum of a source after a check that it is strong enough in a band.

    Raises:
        UnreadableFileError: It is too weak at a frequency; the message names the usable band.
    """
    spectrum = source.spectrum(frequency_hz)
    strength = np.abs(spectrum)
    strong = strength > strength.max() * 10.0 ** (WEAKEST_DB / 20.0)
    if not strong.any():
        raise refusal(Message("{file}: the source is zero; use --source", file=name))
    if not strong.all():
        raise refusal(
            Message(
                "the source of {file} is too weak at some frequencies of {start_hz:g} to "
                "{stop_hz:g} Hz: more than {weakest_db:g} dB below its maximum; use --band "
                "{first_hz:g} {last_hz:g} POINTS",
                file=name,
                start_hz=frequency_hz[0],
                stop_hz=frequency_hz[-1],
                weakest_db=-WEAKEST_DB,
                first_hz=frequency_hz[strong][0],
                last_hz=frequency_hz[strong][-1],
            )
        )
    return spectrum
