"""Finely sampled A-scans, from which voxels are interpolated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
import scipy.fft

from gpr20_analysis.processing.sweep import FrequencyGrid, summed
from gpr20_survey.radar.frequency_to_delay import Window

# Linear interpolation between samples of the analytic signal loses (2 pi f dt)^2 / 8 of a
# component: 0.6 % at 3.3 GHz, 2 % at 6 GHz, without a phase error.
SAMPLE_S = 10.6e-12


@dataclass(frozen=True)
class Transform:
    """Turns spectra to A-scans between delay 0 and a longest one.

    Attributes:
        matrix: From the spectrum to the gated and weighted one of a coarser sweep.
        sweep: The coarser sweep.
        count: Samples within the unambiguous delay.
        kept: Samples of an A-scan.
    """

    matrix: np.ndarray
    sweep: FrequencyGrid
    count: int
    kept: int

    @classmethod
    def until(cls, longest_delay_s: float, sweep: FrequencyGrid, window: Window) -> Transform:
        """Return the transform of a sweep.

        Args:
            longest_delay_s: Longest two-way delay; the A-scans are slightly longer [s].
            sweep: Frequencies of the spectra.
            window: Weights over the band.
        """
        coarse, gate = gated_sweep(sweep, longest_delay_s)
        shares = window.shares(sweep.count) * (coarse.step_hz / sweep.step_hz)
        matrix = (gate * shares[:, None]).astype(np.complex64)
        count = scipy.fft.next_fast_len(int(np.ceil(coarse.unambiguous_s / SAMPLE_S)))
        kept = int(np.ceil(longest_delay_s / (coarse.unambiguous_s / count))) + 4
        return cls(matrix, coarse, count, kept)

    @property
    def sample_s(self) -> float:
        """Step of the A-scans [s]."""
        return self.sweep.unambiguous_s / self.count

    def a_scans(self, spectra: np.ndarray) -> np.ndarray:
        """Return analytic A-scans (trace, delay) from delay 0 on, complex64.

        Args:
            spectra: Spectra (trace, frequency).
        """
        gated = spectra.astype(np.complex64, copy=False) @ self.matrix
        samples = summed(gated, self.sweep, self.count)
        # Never shorter than requested: compiled loops read there without a check.
        beyond = ((0, 0), (0, max(0, self.kept - self.count)))
        return np.ascontiguousarray(np.pad(samples[:, : self.kept], beyond))


def gated_a_scans(
    spectra: np.ndarray, sweep: FrequencyGrid, window: Window, longest_delay_s: float
) -> Tuple[np.ndarray, float]:
    """Return analytic A-scans (trace, delay) from delay 0 on, complex64, and their step [s].

    Args:
        spectra: Spectra (trace, frequency).
        sweep: Their frequencies.
        window: Weights over the band.
        longest_delay_s: Longest two-way delay; the A-scans are slightly longer [s].
    """
    transform = Transform.until(longest_delay_s, sweep, window)
    return transform.a_scans(spectra), transform.sample_s


# Share of the gate over which it fades in, and again over which it fades out.
TRANSITION = 0.06


def gated_sweep(sweep: FrequencyGrid, longest_delay_s: float) -> Tuple[FrequencyGrid, np.ndarray]:
    """Return a coarser sweep and the matrix that transforms spectra to it.

    The coarser spectrum is that of the trace times a gate, which passes delays from 0 to the
    longest in full and is 0 outside of twice its transition before and after. The gate is a
    raised-cosine in time, so its spectrum is known in closed form and no transform is needed.

    Args:
        sweep: The frequencies of the spectra.
        longest_delay_s: Longest two-way delay that must remain [s].

    Returns:
        The sweep, and a matrix (count of the sweep given, count of the sweep returned): the
        product spectra @ matrix is the gated spectra; that of an echo within the gate keeps its
        values. If gating would save nothing, the sweep itself and the identity.
    """
    width_s = longest_delay_s * (1.0 + TRANSITION)
    support_s = width_s * (1.0 + TRANSITION)
    band_hz = sweep.step_hz * (sweep.count - 1)
    count = math.ceil(band_hz * support_s) + 1
    if count >= sweep.count:
        return sweep, np.eye(sweep.count)
    coarse = FrequencyGrid(sweep.start_hz, band_hz / (count - 1), count)
    off_hz = coarse.frequency_hz[None, :] - sweep.frequency_hz[:, None]
    matrix = _gate_spectrum(off_hz, width_s) * np.exp(-1j * np.pi * off_hz * longest_delay_s)
    return coarse, matrix * sweep.step_hz


def _gate_spectrum(off_hz: np.ndarray, width_s: float) -> np.ndarray:
    """Fourier transform of a raised-cosine gate about 0, in seconds."""
    turns = off_hz * width_s
    denominator = 1.0 - (2.0 * TRANSITION * turns) ** 2
    # At its zero the quotient's limit is pi / 4.
    regular = np.abs(denominator) > 1e-9
    quotient = np.where(
        regular,
        np.cos(np.pi * TRANSITION * turns) / np.where(regular, denominator, 1.0),
        np.pi / 4.0,
    )
    return width_s * np.sinc(turns) * quotient
