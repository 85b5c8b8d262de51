"""Recovers the imaginary part of spectra whose imaginary part is a copy of the real part.

The real part of S21 holds every echo twice: at its delay and, mirrored, at minus its delay. With a
frequency step df delays repeat after 1 / df, so if every true delay is between 0 and half of
that, only one of the two is possible, and the imaginary part is the Hilbert transform of the
real part. That the sweep does not begin at 0 Hz does not matter: the mirror image has the opposite
sign of delay at every frequency.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import FREQUENCY, HEIGHT, S21, S21_DIMS, SAMPLE_DIMS
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.display import DISPLAY_ONLY
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans
from gpr20_analysis.sentences import with_decisions, with_notes, with_sentence
from gpr20_common.message import Message
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import Window

NS_PER_S = 1e9
NOTED_DB, REFUSED_DB = -40.0, -20.0
"""Level of an echo near half of the range, relative to the strongest echo [dB]."""
ABOVE_NOISE_DB = 10.0
COPIED = Message(
    "the imaginary part is a copy of the real part, as an old version of the storage wrote it, and "
    "cannot be recovered"
)
RECOVERED = Message(
    "imaginary parts that were copies of the real parts were replaced by numbers calculated from "
    "these"
)


@dataclass
class Recovery:
    """What became of the spectra of a survey.

    Attributes:
        spectra: The spectra; the real parts are unchanged.
        notes: What a user should know.
        refusal: Why the imaginary part could not be recovered; None if it was, or is not missing.
    """

    spectra: List[np.ndarray]
    notes: List[Message]
    refusal: Optional[Message] = None


def with_imaginary_parts(survey: xr.Dataset) -> xr.Dataset:
    """Return a survey with lost imaginary parts recovered, or marked as no data for an image.

    Args:
        survey: Dataset; without `s21`, such as A-scans, it is returned as it is.
    """
    if S21 not in survey:
        return survey
    measured = survey[S21].transpose(*S21_DIMS)
    present = np.all(np.isfinite(measured.values), axis=-1)
    heights_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).values[present]
    found = recover(list(measured.values[present]), survey[FREQUENCY].values, heights_m)
    if not found.notes:
        return survey
    values = measured.values.copy()
    values[present] = found.spectra
    survey = survey.assign({S21: (S21_DIMS, values, measured.attrs)})
    survey = survey.assign_attrs(with_notes(survey, found.notes))
    if found.refusal is None:
        return with_decisions(survey, RECOVERED)
    return survey.assign_attrs(with_sentence(survey.attrs, DISPLAY_ONLY, found.refusal))


def recover(
    spectra: Sequence[np.ndarray], frequency_hz: np.ndarray, heights_m: Sequence[float]
) -> Recovery:
    """Return spectra with their imaginary parts recovered where these copy the real parts.

    Args:
        spectra: One spectrum for each sample.
        frequency_hz: Their frequencies [Hz].
        heights_m: Antenna height of each sample; NaN where unknown [m].
    """
    copies = [
        number
        for number, one in enumerate(spectra)
        if np.any(one) and np.array_equal(one.real, one.imag)
    ]
    if not copies:
        return Recovery(list(spectra), [])
    try:
        sweep = FrequencyGrid.of(xr.Dataset(coords={FREQUENCY: frequency_hz}))
    except WrongDatasetError as error:
        return _refused(
            spectra, Message("{problem}; {reason}", problem=COPIED, reason=error.message)
        )
    real = np.stack([spectra[number].real for number in copies])
    recovered = real - 1j * (real @ _hilbert(sweep.count))
    doubt = _surface_doubt(sweep, heights_m) or _echo_doubt(recovered, sweep)
    if doubt is not None and doubt.refused:
        return _refused(
            spectra, Message("{problem}; {reason}", problem=COPIED, reason=doubt.message)
        )
    found = list(spectra)
    for number, one in zip(copies, recovered):
        found[number] = one
    notes = [
        Message(
            "WARNING: in {count} of {total} samples the imaginary part was a copy of the real "
            "part, as an old version of the storage wrote it; it was recovered from the real part "
            "for echoes with a delay between 0 and {longest_ns:.3g} ns; noise is 3 dB higher than "
            "measured, and echoes less than {nearest_ns:.2g} ns from delay 0 are distorted",
            count=len(copies),
            total=len(spectra),
            longest_ns=0.5 * sweep.unambiguous_s * NS_PER_S,
            nearest_ns=NS_PER_S / (sweep.step_hz * sweep.count),
        )
    ]
    return Recovery(found, notes + ([doubt.message] if doubt is not None else []))


def _refused(spectra: Sequence[np.ndarray], reason: Message) -> Recovery:
    return Recovery(list(spectra), [Message("WARNING: {sentence}", sentence=reason)], reason)


@dataclass(frozen=True)
class _Doubt:
    message: Message
    refused: bool


def _hilbert(count: int) -> np.ndarray:
    """Return the matrix (input, output) of the discrete Hilbert transform over frequency."""
    apart = np.arange(count)[None, :] - np.arange(count)[:, None]
    odd = apart % 2 == 1
    return np.where(odd, 2.0 / (np.pi * np.where(odd, apart, 1)), 0.0)


def _surface_doubt(sweep: FrequencyGrid, heights_m: Sequence[float]) -> Optional[_Doubt]:
    known = [one for one in heights_m if np.isfinite(one)]
    surface_s = two_way_delay_s(max(known, default=0.0))
    if surface_s < 0.25 * sweep.unambiguous_s:
        return None
    message = Message(
        "with a frequency step of {step_hz:g} Hz delays are unambiguous up to {longest_ns:.3g} ns "
        "only, but the echo of the surface already has {surface_ns:.3g} ns",
        step_hz=sweep.step_hz,
        longest_ns=0.5 * sweep.unambiguous_s * NS_PER_S,
        surface_ns=surface_s * NS_PER_S,
    )
    return _Doubt(message, refused=True)


def _echo_doubt(spectra: np.ndarray, sweep: FrequencyGrid) -> Optional[_Doubt]:
    """Return a doubt if there is an echo whose mirror image may be the true one."""
    in_time = a_scans(spectra, sweep, sweep.count, Window.BLACKMAN)
    power = np.mean(np.abs(in_time) ** 2, axis=0)[: sweep.count // 2]
    far = power[sweep.count // 4 :]
    noise, strongest = float(np.median(far)), float(np.max(power))
    if strongest == 0.0 or far.max() <= noise * 10.0 ** (ABOVE_NOISE_DB / 10.0):
        return None
    level_db = 10.0 * np.log10(far.max() / strongest)
    if level_db < NOTED_DB:
        return None
    delay_s = (sweep.count // 4 + int(np.argmax(far))) * sweep.unambiguous_s / sweep.count
    values = {
        "delay_ns": delay_s * NS_PER_S,
        "mirrored_ns": (sweep.unambiguous_s - delay_s) * NS_PER_S,
        "level_db": level_db,
    }
    if level_db < REFUSED_DB:
        message = Message(
            "an echo of {level_db:.0f} dB has a delay of {delay_ns:.3g} ns or, if it is mirrored, "
            "{mirrored_ns:.3g} ns; without the measured imaginary part these cannot be "
            "distinguished",
            **values,
        )
        return _Doubt(message, refused=False)
    message = Message(
        "a strong echo of {level_db:.0f} dB has a delay of {delay_ns:.3g} ns or, if it is "
        "mirrored, {mirrored_ns:.3g} ns, so delays exceed the unambiguous range of the real part",
        **values,
    )
    return _Doubt(message, refused=True)
