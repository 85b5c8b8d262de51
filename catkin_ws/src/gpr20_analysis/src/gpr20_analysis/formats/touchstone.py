"""Touchstone: one two-port file per sample, of which only S21 was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.errors import MissingLibraryError, library_missing
from gpr20_analysis.formats.common import usable_samples
from gpr20_analysis.formats.facts import marked
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_analysis.read.survey_attributes import OF_ANALYZER
from gpr20_analysis.sentences import DOUBTS, kept_doubts, sentences_of
from gpr20_analysis.work import Progress, no_progress

IMPEDANCE_OHM = 50.0
HEIGHT_WORDS = "antenna height [m]"
MOVED = "time zero of each sample was moved: delays are not those of the antennas"


def write_touchstone(survey: xr.Dataset, folder: Path, progress: Progress = no_progress) -> int:
    """Write files such as `000123_X0050.00_Y0050.00_Z+090.00.s2p` and return their number.

    S11, S12 and S22 were not measured; the format needs values there, so they are 0, as a comment
    in each file says.

    Raises:
        MissingLibraryError: scikit-rf is not installed.
        OSError: It cannot be written.
    """
    skrf = _skrf()
    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    index, height_m = (
        dataset.require(survey, one, dataset.SAMPLE_DIMS).values
        for one in ("index", dataset.HEIGHT)
    )
    frequency = skrf.Frequency.from_f(survey[dataset.FREQUENCY].values, unit="hz")
    folder.mkdir(parents=True, exist_ok=True)
    samples = usable_samples(survey)
    said = [MOVED] if ADVANCE in survey else []
    said += [f"DOUBTED: {one}" for one in kept_doubts(sentences_of(survey, DOUBTS))]
    shared = "".join(f"\n{one}" for one in said)
    settings = {
        one: dataset.require(survey, one, dataset.SAMPLE_DIMS).values
        for one in OF_ANALYZER
        if one in survey
    }
    for place, x_mm, y_mm, z_deg in progress(samples, len(samples)):
        scattering = np.zeros((len(frequency), 2, 2), np.complex128)
        scattering[:, 1, 0] = s21[place]
        number = int(index[place])
        own = {**survey.attrs, **{one: values[place] for one, values in settings.items()}}
        network = skrf.Network(frequency=frequency, s=scattering, z0=IMPEDANCE_OHM)
        network.comments = (
            f"{marked('GPR-20', survey)} survey {survey.attrs.get('survey_id', '')} "
            f"sample {number}\n"
            "only S21 was measured; S11, S12 and S22 are 0 in place of numbers"
            f"{_settings(own)}{shared}\n"
            f"{HEIGHT_WORDS} {float(height_m[place])!r}"
        )
        name = f"{number:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{z_deg:+07.2f}.s2p"
        network.write_touchstone(name, dir=str(folder), form="ri")
    return len(samples)


def _settings(own: Mapping[str, Any]) -> str:
    """Return those of the VNA at a sample as one more line of the comment."""
    known = [f"{one} {own[one]}" for one in OF_ANALYZER if own.get(one) and own[one] == own[one]]
    return ("\n" + ", ".join(known)) if known else ""


def _skrf() -> Any:
    try:
        import skrf
    except ImportError as error:
        raise MissingLibraryError(library_missing("scikit-rf", "touchstone")) from error
    return skrf
