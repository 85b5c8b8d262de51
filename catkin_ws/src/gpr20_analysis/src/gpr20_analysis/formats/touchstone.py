"""Touchstone: one two-port file per sample, of which only S21 was measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
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
        OSError: It cannot be written.
    """
    import skrf  # an optional library

    s21 = dataset.require(survey, dataset.S21, dataset.S21_DIMS)
    own = {
        one: dataset.require(survey, one, dataset.SAMPLE_DIMS).values
        for one in ("index", dataset.HEIGHT, *OF_ANALYZER)
        if one in survey or one not in OF_ANALYZER
    }
    frequency = skrf.Frequency.from_f(survey[dataset.FREQUENCY].values, unit="hz")
    folder.mkdir(parents=True, exist_ok=True)
    said = [MOVED] if ADVANCE in survey else []
    said += [f"DOUBTED: {one}" for one in kept_doubts(sentences_of(survey, DOUBTS))]
    turns_deg, y_m, x_m = (survey[axis].values for axis in dataset.SAMPLE_DIMS)
    usable = dataset.usable(survey).transpose(*dataset.SAMPLE_DIMS).values
    places = [tuple(place) for place in np.argwhere(usable)]
    for place in progress(places, len(places)):
        scattering = np.zeros((len(frequency), 2, 2), np.complex128)
        scattering[:, 1, 0] = s21[place]
        here = {**survey.attrs, **{name: values[place] for name, values in own.items()}}
        number = int(here["index"])
        known = [one for one in OF_ANALYZER if here.get(one) and here[one] == here[one]]
        settings = ", ".join(f"{one} {here[one]}" for one in known)
        network = skrf.Network(frequency=frequency, s=scattering, z0=IMPEDANCE_OHM)
        network.comments = "\n".join(
            [
                f"{marked('GPR-20', survey)} survey {here.get('survey_id', '')} sample {number}",
                "only S21 was measured; S11, S12 and S22 are 0 in place of numbers",
                *([settings] if settings else []),
                *said,
                f"{HEIGHT_WORDS} {float(here[dataset.HEIGHT])!r}",
            ]
        )
        x_mm, y_mm = x_m[place[2]] * dataset.MM_PER_M, y_m[place[1]] * dataset.MM_PER_M
        z_deg = turns_deg[place[0]]
        name = f"{number:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{z_deg:+07.2f}.s2p"
        network.write_touchstone(name, dir=str(folder), form="ri")
    return len(places)
