"""Gating in time: fewer frequencies, equal echoes up to a longest delay."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from gpr20_analysis.mid.processing.sweep import Sweep

# Share of the gate over which it fades in, and again over which it fades out.
TRANSITION = 0.06


def gated_sweep(sweep: Sweep, longest_delay_s: float) -> Tuple[Sweep, np.ndarray]:
    """Return a coarser sweep and the matrix that brings spectra onto it.

    The coarser spectrum is that of the trace times a gate, which passes delays from 0 to the
    longest in full and is 0 outside of twice its transition before and after. The gate is a
    raised-cosine in time, so its spectrum is known in closed form and no transform is needed.

    Args:
        sweep: The frequencies of the spectra.
        longest_delay_s: Longest two-way delay that must be kept [s].

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
    coarse = Sweep(sweep.start_hz, band_hz / (count - 1), count)
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
