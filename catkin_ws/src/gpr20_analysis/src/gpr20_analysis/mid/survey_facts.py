"""What is to be told of a survey in a few lines."""

from __future__ import annotations

from typing import Dict

import numpy as np
import xarray as xr

from gpr20_analysis.mid import dataset

MM, GHZ, MHZ = 1e-3, 1e9, 1e6
SIMULATED = "SIMULATED: the data show no real ground"
WORDS = ("survey_id", "source", "started", "ended", "outcome", "reason", "software_revision")


def facts(survey: xr.Dataset) -> Dict[str, str]:
    """Return title and text of what a survey holds, in the order of telling."""
    told = {
        word.replace("_", " "): str(survey.attrs[word]) for word in WORDS if word in survey.attrs
    }
    if "simulated" in survey.attrs:
        told["ground"] = SIMULATED if survey.attrs["simulated"] else "measured"
    if dataset.QUALITY in survey:
        told["samples"] = _samples(survey)
    if dataset.IMAGE in survey:
        told["image"] = (
            f"{survey.attrs.get('method', 'unknown method')}, relative permittivity "
            f"{survey.attrs.get('permittivity', 'unknown')}"
        )
        told["depth"] = _axis(survey[dataset.DEPTH].values)
    told["polarizations"] = ", ".join(f"{one:g} deg" for one in survey[dataset.POLARIZATION].values)
    told["x"] = _axis(survey[dataset.X].values)
    told["y"] = _axis(survey[dataset.Y].values)
    if dataset.FREQUENCY in survey.coords:
        told["frequency"] = _frequency(survey[dataset.FREQUENCY].values)
    if dataset.HEIGHT in survey:
        told["height"] = _height(survey[dataset.HEIGHT].values)
    told["size"] = f"{survey.nbytes / 1e6:.1f} MB"
    return told


def _samples(survey: xr.Dataset) -> str:
    quality = survey[dataset.QUALITY].values
    usable = int(np.count_nonzero((quality & int(dataset.UNUSABLE)) == 0))
    parts = [f"{usable} of {quality.size} of the grid"]
    for flag in (flag for flag in dataset.Quality if flag):
        count = int(np.count_nonzero(quality & int(flag)))
        if count:
            parts.append(f"{count} {str(flag.name).lower().replace('_', ' ')}")
    return ", ".join(parts)


def _axis(values_m: np.ndarray) -> str:
    text = f"{len(values_m)} from {values_m[0] / MM:g} to {values_m[-1] / MM:g} mm"
    if len(values_m) < 2:
        return text
    spacings = np.diff(values_m) / MM
    if np.ptp(spacings) < 0.02:  # two motor steps [mm]
        return f"{text}, every {spacings.mean():.4g} mm"
    return f"{text}, every {spacings.min():.4g} to {spacings.max():.4g} mm"


def _frequency(values_hz: np.ndarray) -> str:
    step = (values_hz[-1] - values_hz[0]) / max(len(values_hz) - 1, 1)
    return (
        f"{len(values_hz)} from {values_hz[0] / GHZ:g} to {values_hz[-1] / GHZ:g} GHz, every "
        f"{step / MHZ:.5g} MHz"
    )


def _height(values_m: np.ndarray) -> str:
    known = values_m[np.isfinite(values_m)]
    if not known.size:
        return "not measured"
    return f"{known.min() / MM:.4g} to {known.max() / MM:.4g} mm, mean {known.mean() / MM:.4g} mm"
