"""The frequencies of a sweep, windows over them, and parts of them."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import FREQUENCY, S21
from gpr20_analysis.errors import WrongDatasetError
from gpr20_common.message import Message

# Relative to the step; recorded frequencies are doubles, an instrument rounds to 1 Hz.
STEP_TOLERANCE = 1e-3


class Window(enum.Enum):
    """Weights over the band: lower sidelobes mean a wider main lobe."""

    NONE = "none"
    HANN = "hann"
    HAMMING = "hamming"
    BLACKMAN = "blackman"

    def weights(self, count: int) -> np.ndarray:
        """Return symmetric weights with a maximum of about 1."""
        # A symmetric Hann window is 0 at both ends, which would discard two frequencies.
        turn = np.linspace(-np.pi, np.pi, count + 2)[1:-1]
        weights: np.ndarray = sum(
            share * np.cos(number * turn) for number, share in enumerate(COSINES[self])
        )
        return weights


# Shares of the cosines. scipy.signal has these windows too, but its import takes half a second.
COSINES = {
    Window.NONE: (1.0,),
    Window.HANN: (0.5, 0.5),
    Window.HAMMING: (0.54, 0.46),
    Window.BLACKMAN: (0.42, 0.5, 0.08),
}


@dataclass(frozen=True)
class FrequencyGrid:
    """A uniform grid of frequencies.

    Attributes:
        start_hz: First frequency [Hz].
        step_hz: Distance between two [Hz].
        count: Number of frequencies.
    """

    start_hz: float
    step_hz: float
    count: int

    @property
    def frequency_hz(self) -> np.ndarray:
        """All frequencies [Hz]."""
        return self.start_hz + self.step_hz * np.arange(self.count)

    @property
    def unambiguous_s(self) -> float:
        """Longest unambiguous delay [s]: 1 / step."""
        return 1.0 / self.step_hz

    @classmethod
    def of(cls, survey: xr.Dataset) -> FrequencyGrid:
        """Return the sweep of a survey.

        Raises:
            WrongDatasetError: It has fewer than two frequencies, or uneven spacing.
        """
        if FREQUENCY not in survey.coords:
            raise WrongDatasetError(
                Message("the data have no coordinate 'frequency', but spectra are needed")
            )
        frequency_hz = np.asarray(survey[FREQUENCY].values, dtype=np.float64)
        if frequency_hz.size < 2 or not np.all(np.isfinite(frequency_hz)):
            raise WrongDatasetError(
                Message(
                    "the sweep has {count} frequencies; two or more finite ones are needed",
                    count=frequency_hz.size,
                )
            )
        step_hz = (frequency_hz[-1] - frequency_hz[0]) / (frequency_hz.size - 1)
        ideal_hz = frequency_hz[0] + step_hz * np.arange(frequency_hz.size)
        off_hz = float(np.max(np.abs(frequency_hz - ideal_hz)))
        if not step_hz > 0.0 or off_hz > STEP_TOLERANCE * step_hz:
            raise WrongDatasetError(
                Message(
                    "the frequencies are not evenly spaced and ascending: they differ by up to "
                    "{off_hz:g} Hz at a step of {step_hz:g} Hz; measure with a linear sweep, or "
                    "resample",
                    off_hz=off_hz,
                    step_hz=step_hz,
                )
            )
        return cls(float(frequency_hz[0]), float(step_hz), int(frequency_hz.size))


def apply_window(survey: xr.Dataset, window: Window = Window.HANN) -> xr.Dataset:
    """Weight the band of each trace.

    Later steps apply windows too; weighting twice narrows the band twice.
    """
    weights = window.weights(survey.sizes[FREQUENCY])
    return survey.assign({S21: survey[S21] * xr.DataArray(weights, dims=FREQUENCY)})


def select_band(survey: xr.Dataset, start_hz: float, stop_hz: float) -> xr.Dataset:
    """Select the frequencies from start to stop, both included [Hz].

    Raises:
        WrongDatasetError: Fewer than two frequencies would be left.
    """
    frequency_hz = survey[FREQUENCY].values
    kept = (frequency_hz >= start_hz) & (frequency_hz <= stop_hz)
    if np.count_nonzero(kept) < 2:
        raise WrongDatasetError(
            Message(
                "the band {start_hz:g} to {stop_hz:g} Hz contains {count} frequencies of the sweep "
                "{first_hz:g} to {last_hz:g} Hz; two or more are needed",
                start_hz=start_hz,
                stop_hz=stop_hz,
                count=np.count_nonzero(kept),
                first_hz=frequency_hz[0],
                last_hz=frequency_hz[-1],
            )
        )
    return survey.isel({FREQUENCY: kept})
