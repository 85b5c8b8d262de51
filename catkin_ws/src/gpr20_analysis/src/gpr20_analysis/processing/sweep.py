"""The frequencies of a sweep, windows over them, and parts of them."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.signal import get_window

from gpr20_analysis.dataset import FREQUENCY, S21
from gpr20_analysis.errors import WrongDatasetError

# Of one step; the recorded frequencies are doubles, an instrument rounds to 1 Hz.
STEP_TOLERANCE = 1e-3


class Window(enum.Enum):
    """Weights over the band: the lower the sidelobes, the wider the main lobe."""

    NONE = "none"
    HANN = "hann"
    HAMMING = "hamming"
    BLACKMAN = "blackman"

    def weights(self, count: int) -> np.ndarray:
        """Return so many weights, symmetric, largest about 1."""
        name = "boxcar" if self is Window.NONE else self.value
        # A symmetric Hann window is 0 at both ends, which would throw two frequencies away.
        return get_window(name, count + 2, fftbins=False)[1:-1]


@dataclass(frozen=True)
class FrequencyGrid:
    """A uniform grid of frequencies.

    Attributes:
        start_hz: First frequency [Hz].
        step_hz: Distance of two [Hz].
        count: How many.
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
        """Longest delay that can be told from a shorter one [s]: 1 / step."""
        return 1.0 / self.step_hz

    @classmethod
    def of(cls, survey: xr.Dataset) -> FrequencyGrid:
        """Return the sweep of a survey.

        Raises:
            WrongDatasetError: Its frequencies are fewer than two or not evenly spaced.
        """
        if FREQUENCY not in survey.coords:
            raise WrongDatasetError("the data have no coordinate 'frequency'; a sweep is needed")
        frequency_hz = np.asarray(survey[FREQUENCY].values, dtype=np.float64)
        if frequency_hz.size < 2 or not np.all(np.isfinite(frequency_hz)):
            raise WrongDatasetError(
                f"the sweep has {frequency_hz.size} frequencies; two or more finite ones are needed"
            )
        step_hz = (frequency_hz[-1] - frequency_hz[0]) / (frequency_hz.size - 1)
        ideal_hz = frequency_hz[0] + step_hz * np.arange(frequency_hz.size)
        off_hz = float(np.max(np.abs(frequency_hz - ideal_hz)))
        if not step_hz > 0.0 or off_hz > STEP_TOLERANCE * step_hz:
            raise WrongDatasetError(
                f"the frequencies are not evenly spaced and ascending: off by up to {off_hz:g} Hz "
                f"at a step of {step_hz:g} Hz; measure or resample with a linear sweep"
            )
        return cls(float(frequency_hz[0]), float(step_hz), int(frequency_hz.size))


def apply_window(survey: xr.Dataset, window: Window = Window.HANN) -> xr.Dataset:
    """Weight the band of each trace.

    Later steps have windows of their own; to weight twice narrows the band twice.
    """
    weights = window.weights(survey.sizes[FREQUENCY])
    return survey.assign({S21: survey[S21] * xr.DataArray(weights, dims=FREQUENCY)})


def select_band(survey: xr.Dataset, start_hz: float, stop_hz: float) -> xr.Dataset:
    """Keep the frequencies from start to stop, both included [Hz].

    Raises:
        WrongDatasetError: Fewer than two frequencies would be left.
    """
    frequency_hz = survey[FREQUENCY].values
    kept = (frequency_hz >= start_hz) & (frequency_hz <= stop_hz)
    if np.count_nonzero(kept) < 2:
        raise WrongDatasetError(
            f"the band {start_hz:g}..{stop_hz:g} Hz holds {np.count_nonzero(kept)} frequencies of "
            f"the sweep {frequency_hz[0]:g}..{frequency_hz[-1]:g} Hz; two or more are needed"
        )
    return survey.isel({FREQUENCY: kept})
