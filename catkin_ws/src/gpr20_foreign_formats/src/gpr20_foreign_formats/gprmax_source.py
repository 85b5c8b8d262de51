"""The signal of a simulated source, by which spectra are divided to get a transmission."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Dict, Union

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.errors import AnalysisError, UnreadableFileError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

NONE = "none"
WEAKEST_DB = -60.0
"""Where the source is weaker than this, relative to its maximum in the band, only noise is left."""
STEPS_PER_PERIOD = 64
PERIODS = 8.0


@dataclass(frozen=True)
class Signal:
    """A real signal at even times.

    Attributes:
        values: Its values.
        step_s: Time from one to the next [s].
        start_s: Time of the first [s].
    """

    values: np.ndarray
    step_s: float
    start_s: float = 0.0

    def spectrum(self, frequency_hz: np.ndarray) -> np.ndarray:
        """Return the Fourier transform, with the sign of S21: a delay is a negative phase."""
        time_s = self.start_s + np.arange(len(self.values)) * self.step_s
        turns = np.exp(-2j * np.pi * frequency_hz[:, np.newaxis] * time_s)
        spectrum: np.ndarray = turns @ self.values * self.step_s
        return spectrum


def _gaussian(time_s: np.ndarray, frequency_hz: float) -> np.ndarray:
    return np.exp(-2.0 * (np.pi * frequency_hz * (time_s - 1.0 / frequency_hz)) ** 2)


def _gaussian_dot(time_s: np.ndarray, frequency_hz: float) -> np.ndarray:
    late_s = time_s - 1.0 / frequency_hz
    return -4.0 * (np.pi * frequency_hz) ** 2 * late_s * _gaussian(time_s, frequency_hz)


def _gaussian_dot_norm(time_s: np.ndarray, frequency_hz: float) -> np.ndarray:
    largest = 2.0 * np.pi * frequency_hz * np.exp(-0.5)
    return _gaussian_dot(time_s, frequency_hz) / largest


def _ricker(time_s: np.ndarray, frequency_hz: float) -> np.ndarray:
    turns = (np.pi * frequency_hz * (time_s - np.sqrt(2.0) / frequency_hz)) ** 2
    return (1.0 - 2.0 * turns) * np.exp(-turns)


WAVEFORMS: Dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "gaussian": _gaussian,
    "gaussiandot": _gaussian_dot,
    "gaussiandotnorm": _gaussian_dot_norm,
    "ricker": _ricker,
}
"""Waveforms of gprMax by name, as its manual defines them (#waveform)."""


def source_of(text: str) -> Union[Signal, None]:
    """Return the source signal that a user gives; None for `none`: spectra are not divided.

    Args:
        text: `none`, a waveform such as `ricker:1.5e9` (centre frequency in Hz), or a text file
            with a time [s] and a value on each line.

    Raises:
        AnalysisError: It is none of these.
        UnreadableFileError: The file has another content.
    """
    if text == NONE:
        return None
    name, colon, number = text.partition(":")
    if not colon or name not in WAVEFORMS:
        return _from_file(Path(text))
    try:
        frequency_hz = float(number)
    except ValueError:
        frequency_hz = np.nan
    if not 1e6 <= frequency_hz <= 1e12:
        raise AnalysisError(
            Message(
                "--source {text} has no frequency between 1e6 and 1e12 Hz; write it as "
                "{waveform}:1.5e9",
                text=text,
                waveform=name,
            )
        )
    step_s = 1.0 / frequency_hz / STEPS_PER_PERIOD
    time_s = np.arange(int(PERIODS * STEPS_PER_PERIOD)) * step_s
    return Signal(WAVEFORMS[name](time_s, frequency_hz), step_s)


def check_strength(source: Signal, frequency_hz: np.ndarray, name: str) -> np.ndarray:
    """Return the spectrum of a source after a check that it is strong enough in a band.

    Raises:
        UnreadableFileError: It is too weak at a frequency; the message names the usable band.
    """
    spectrum = source.spectrum(frequency_hz)
    strength = np.abs(spectrum)
    largest = float(strength.max())
    strong = strength > largest * 10.0 ** (WEAKEST_DB / 20.0)
    if not (largest > 0.0 and strong.all()):
        if not largest > 0.0:
            raise UnreadableFileError(
                Message("{file}: the source is zero; use --source", file=name), fault=faults.INPUT
            )
        usable_hz = frequency_hz[strong]
        raise UnreadableFileError(
            Message(
                "the source of {file} is too weak at some frequencies of {start_hz:g} to "
                "{stop_hz:g} Hz: more than {weakest_db:g} dB below its maximum; use --band "
                "{first_hz:g} {last_hz:g} POINTS",
                file=name,
                start_hz=frequency_hz[0],
                stop_hz=frequency_hz[-1],
                weakest_db=-WEAKEST_DB,
                first_hz=usable_hz[0],
                last_hz=usable_hz[-1],
            ),
            fault=NOT_ALLOWED,
        )
    return spectrum


def _from_file(path: Path) -> Signal:
    if not path.is_file():
        raise AnalysisError(
            Message(
                "--source {text} is neither a file nor {none} nor one of {waveforms} with a "
                "frequency, such as ricker:1.5e9",
                text=path,
                none=NONE,
                waveforms=", ".join(WAVEFORMS),
            )
        )
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
        # A first line that begins with a letter is a header.
        first = 1 if lines and lines[0][:1].isalpha() else 0
        table = np.array([line.replace(",", " ").split() for line in lines[first:] if line.strip()])
        table = table.astype(np.float64).reshape(len(table), -1)
    except ValueError as error:
        raise UnreadableFileError(
            Message("{file} must contain times and values", file=path.name, details=error),
            fault=faults.INPUT,
        ) from error
    if table.shape[0] < 2 or table.shape[1] != 2 or not np.isfinite(table).all():
        raise UnreadableFileError(
            Message(
                "{file} has {lines} lines of {columns} numbers; a source signal needs two or more "
                "lines, each with a time [s] and a value",
                file=path.name,
                lines=table.shape[0],
                columns=table.shape[1],
            ),
            fault=faults.INPUT,
        )
    steps_s = np.diff(table[:, 0])
    step_s = float(steps_s.mean())
    if not (step_s > 0.0 and np.allclose(steps_s, step_s, rtol=1e-2, atol=0.0)):
        raise UnreadableFileError(
            Message("the times in {file} must be evenly spaced and ascending", file=path.name),
            fault=faults.INPUT,
        )
    return Signal(table[:, 1], step_s, float(table[0, 0]))
