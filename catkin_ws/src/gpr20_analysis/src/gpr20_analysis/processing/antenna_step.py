"""The antennas of a robot: their model from surveys of a metal plate, and the step without it."""

from __future__ import annotations

import json
from typing import Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import faults
from gpr20_analysis.dataset import (
    ANTENNA,
    ANTENNA_DIMS,
    FREQUENCY,
    MM_PER_M,
    POLARIZATION,
    PROCESSING,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    TERM,
    X,
    Y,
    require,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.antenna_model import (
    FEWEST_HEIGHTS,
    AntennaModel,
    fit_antenna,
    surface_permittivity,
)
from gpr20_analysis.processing.delay import REMOVED, known_height
from gpr20_analysis.processing.surface_echo import MOST_COLUMNS, MOST_ROWS, SURFACE_DELAY, spread
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_analysis.sentences import with_notes
from gpr20_common.message import Message
from gpr20_survey.radar.depth import SPEED_OF_LIGHT_M_S
from gpr20_survey.radar.frequency_to_delay import delay_kernel, phase_advance

SURFACE_PERMITTIVITY = "surface_permittivity"
"""Attribute: permittivity by the reflection of the surface; with the ends of its range."""
ENDS = ("_lowest", "", "_highest")
SEPARATION, PLATE_HEIGHT, CENTRE, MISFIT = "separation_m", "plate_height", "centre_m", "misfit"
# Of heights that are to be one, and of the largest and smallest of all.
MOST_SPREAD_M, LEAST_RANGE_M = 0.006, 0.03
MOST_MISFIT = 0.25
# Of the largest transmission: what is fainter is attenuated, since its noise would be amplified.
FAINT = 10.0 ** (-30.0 / 20.0)
SURFACE_WITHIN_S = 0.4e-9
PADDING = 8
# Of the traces, those in which the surface must be found.
LEAST_SHARE = 0.6
# Of the strongest echo of a trace: what is weaker than that may be one of its sidelobes.
LEAST_LEVEL = 0.05
# Steps that leave the spectra of a trace as they were measured.
HARMLESS = ("polarization",)


def antenna_of(plates: Sequence[xr.Dataset], separation_m: float = 0.0) -> xr.Dataset:
    """Return the model of the antennas from surveys over a metal plate, each at one height.

    Args:
        plates: Surveys as measured, of the same sweep and rotations.
        separation_m: Distance between the antennas [m].

    Returns:
        Dataset with `antenna` (polarization, term, frequency), the terms of `AntennaModel`, and
        what describes the fit.

    Raises:
        WrongDatasetError: The surveys do not determine the model, or no plate explains them.
    """
    for one in plates:
        require_measured(one)
    heights_m = np.array([_height_m(one) for one in plates])
    if len(set(np.round(heights_m, 3))) < FEWEST_HEIGHTS or np.ptp(heights_m) < LEAST_RANGE_M:
        raise WrongDatasetError(
            Message(
                "the heights above the plate are {heights_mm} mm; measure at {fewest} or more that "
                "differ by {range_mm:.0f} mm, in uneven steps, such as 60, 75, 95, 125, 170 mm",
                heights_mm=", ".join(f"{MM_PER_M * one:.0f}" for one in heights_m),
                fewest=FEWEST_HEIGHTS,
                range_mm=MM_PER_M * LEAST_RANGE_M,
            ),
            fault=faults.INPUT,
        )
    for one in plates[1:]:
        _check_sweep(one, plates[0])
    path_m = np.hypot(2.0 * heights_m, separation_m)
    means = np.stack([require(one, S21, S21_DIMS).mean([Y, X]).values for one in plates], axis=1)
    for number in np.flatnonzero(~np.isfinite(means).all(axis=(0, 2))):
        raise WrongDatasetError(
            Message(
                "survey {number} of the plate has a rotation without data; measure it again",
                number=number + 1,
            ),
            fault=faults.INPUT,
        )
    models = [fit_antenna(one, path_m, plates[0][FREQUENCY].values) for one in means]
    for model in models:
        if not model.misfit <= MOST_MISFIT:
            raise WrongDatasetError(
                Message(
                    "a plate leaves {misfit:.0f} % of the measurements unexplained (limit "
                    "{limit:.0f} %); check the heights, and that the plate is level and at least 1 "
                    "m by 1 m",
                    misfit=100.0 * model.misfit,
                    limit=100.0 * MOST_MISFIT,
                ),
                fault=faults.INPUT,
            )
    terms = np.stack([np.stack([one.internal, one.transmission, one.feedback]) for one in models])
    return xr.Dataset(
        {
            ANTENNA: (ANTENNA_DIMS, terms),
            CENTRE: (POLARIZATION, [one.centre_m for one in models]),
            MISFIT: (POLARIZATION, [one.misfit for one in models]),
            PLATE_HEIGHT: ("plate", heights_m),
        },
        {POLARIZATION: plates[0][POLARIZATION], TERM: [0, 1, 2], FREQUENCY: plates[0][FREQUENCY]},
        {SEPARATION: separation_m},
    )


def without_antenna(survey: xr.Dataset, model: xr.Dataset) -> xr.Dataset:
    """Remove what the antennas add: coupling, ringing, delay and the colour of their response.

    What is left is what comes back from the ground: a mirror at a path of 1 m would have magnitude
    1. The reflection of the surface gives its permittivity, which images use if none is given.

    Args:
        survey: Dataset with `s21` as measured.
        model: Written by `gpr20 antenna`.

    Raises:
        WrongDatasetError: The model is of another sweep or rotation, or the data were changed.
        DamagedSurveyError: A usable sample has no height.
    """
    measured = require(survey, S21, S21_DIMS)
    if not {ANTENNA, CENTRE, MISFIT, SEPARATION} <= {*model.variables, *model.attrs}:
        raise WrongDatasetError(
            Message("the file that was given as model is none: make one with gpr20 antenna"),
            fault=faults.INPUT,
        )
    terms = require(model, ANTENNA, ANTENNA_DIMS)
    require_measured(survey)
    _check_sweep(survey, model)
    # Values that differ by rounding only would drop out of the product.
    terms = terms.assign_coords({name: survey[name] for name in (POLARIZATION, FREQUENCY)})
    internal, transmission, feedback = (terms.isel({TERM: one}) for one in range(3))
    received = measured - internal
    # A share of what is lost in noise, so that it is not amplified.
    faint = FAINT * float(np.abs(transmission).max())
    kept = np.abs(transmission) ** 2 / (np.abs(transmission) ** 2 + faint**2)
    ground = (received / (transmission + feedback * received) * kept).transpose(*S21_DIMS)
    cleaned = survey.assign({S21: ground.astype(measured.dtype).assign_attrs(measured.attrs)})
    return _described(cleaned, model)


def _described(cleaned: xr.Dataset, model: xr.Dataset) -> xr.Dataset:
    """Return data without antennas with what is known of their surface."""
    antennas = [_model(model, turn) for turn in range(model.sizes[POLARIZATION])]
    separation_m = float(model.attrs[SEPARATION])
    rows, columns = (
        spread(cleaned.sizes[axis], most) for axis, most in ((Y, MOST_ROWS), (X, MOST_COLUMNS))
    )
    chosen = cleaned.isel({Y: rows, X: columns})
    height_m, known = known_height(chosen).values, usable(chosen).transpose(*SAMPLE_DIMS).values
    sweep = FrequencyGrid.of(cleaned)
    found, later_s = [], []
    for turn, antenna in enumerate(antennas):
        spectra = chosen[S21].values[turn][known[turn]]
        expected_s = np.hypot(2.0 * height_m[turn][known[turn]], separation_m) / SPEED_OF_LIGHT_M_S
        picked_s = _strongest_s(spectra, expected_s, sweep, SURFACE_WITHIN_S)
        clear = np.isfinite(picked_s)
        if np.count_nonzero(clear) < LEAST_SHARE * len(clear) or not clear.any():
            continue
        later_s.append(float(np.median((picked_s - expected_s)[clear])))
        path_m = picked_s[clear] * SPEED_OF_LIGHT_M_S
        found.append(surface_permittivity(spectra[clear], path_m, antenna, separation_m))
    delay_s = float(np.mean([_delay_s(one) for one in antennas]))
    attributes = {ANTENNA_DELAY: 0.0, REMOVED: delay_s}
    if later_s:
        attributes[SURFACE_DELAY] = delay_s + float(np.median(later_s))
    cleaned = cleaned.assign_attrs({**cleaned.attrs, **attributes})
    accepted = [one for one in found if one is not None]
    if not accepted or max(one[0] for one in accepted) > min(one[2] for one in accepted):
        note = Message(
            "the reflection of the surface does not give its permittivity: it is not clear, the "
            "antennas are too near for the distance between them, or the rotations contradict each "
            "other"
        )
        return cleaned.assign_attrs(with_notes(cleaned, [note]))
    ends = np.mean(np.log(accepted), axis=0)
    names = (SURFACE_PERMITTIVITY + end for end in ENDS)
    return cleaned.assign_attrs(dict(zip(names, np.exp(ends).tolist())))


def _strongest_s(
    spectra: np.ndarray, expected_s: np.ndarray, sweep: FrequencyGrid, within_s: float
) -> np.ndarray:
    """Return the delay of the highest maximum near an expected one; NaN if none is strong [s]."""
    step_s = 1.0 / (PADDING * sweep.step_hz * sweep.count)
    reach = max(2, int(np.ceil(within_s / step_s)))
    near_s = within_s / reach * np.arange(-reach - 1, reach + 2)
    least = LEAST_LEVEL * np.abs(a_scans(spectra, sweep, 2 * sweep.count)).max(axis=-1)
    aligned = spectra * phase_advance(sweep.frequency_hz, expected_s)
    level = np.abs(aligned @ delay_kernel(sweep.frequency_hz, near_s))
    here, before, after = level[..., 1:-1], level[..., :-2], level[..., 2:]
    tops = np.where((here >= before) & (here > after), here, -1.0)
    top = np.argmax(tops, axis=-1)[..., None]
    left, middle, right = (np.take_along_axis(level, top + one, -1) for one in (0, 1, 2))
    bend = np.minimum(left - 2.0 * middle + right, -1e-300)
    offset = 0.5 * (left - right) / bend * (within_s / reach)
    found: np.ndarray = expected_s + near_s[1:-1][top[..., 0]] + offset[..., 0]
    return np.where(np.take_along_axis(tops, top, -1)[..., 0] > least, found, np.nan)


def _model(model: xr.Dataset, turn: int) -> AntennaModel:
    internal, transmission, feedback = model[ANTENNA].transpose(*ANTENNA_DIMS).values[turn]
    centre_m, misfit = (float(model[name].values[turn]) for name in (CENTRE, MISFIT))
    frequency_hz = model[FREQUENCY].values.astype(np.float64)
    return AntennaModel(frequency_hz, internal, transmission, feedback, centre_m, misfit)


def _delay_s(model: AntennaModel) -> float:
    """Return the delay of cables and antennas: of the transmission, weighted by its power."""
    step = model.transmission[1:] * model.transmission[:-1].conj()
    turn_rad = float(np.angle(np.sum(step)))
    return -turn_rad / (2.0 * np.pi * float(np.mean(np.diff(model.frequency_hz))))


def require_measured(survey: xr.Dataset) -> None:
    """Check that no step has changed the spectra of a survey.

    Raises:
        WrongDatasetError: One has.
    """
    steps = [one["step"] for one in json.loads(survey.attrs.get(PROCESSING, "[]"))]
    changed = [one for one in steps if one not in HARMLESS]
    if changed:
        raise WrongDatasetError(
            Message(
                "the data were changed by the steps {steps}; the antennas are removed from a "
                "survey as measured, so apply the step antenna first",
                steps=", ".join(changed),
            )
        )


def _height_m(plate: xr.Dataset) -> float:
    """Return the one height of a survey over a plate [m]."""
    heights_m = known_height(plate).where(usable(plate))
    spread_m = float(heights_m.std())
    if not spread_m <= MOST_SPREAD_M:
        raise WrongDatasetError(
            Message(
                "the heights of one survey over the plate differ by {spread_mm:.1f} mm (standard "
                "deviation; limit {limit_mm:.0f} mm); level the plate, and make one survey for "
                "each height",
                spread_mm=MM_PER_M * spread_m,
                limit_mm=MM_PER_M * MOST_SPREAD_M,
            ),
            fault=faults.INPUT,
        )
    return float(heights_m.mean())


def _check_sweep(data: xr.Dataset, other: xr.Dataset) -> None:
    """Check that two Datasets have the same rotations and frequencies."""
    for name in (POLARIZATION, FREQUENCY):
        own, others = (np.asarray(one[name].values, dtype=np.float64) for one in (data, other))
        if len(own) != len(others) or not np.allclose(own, others, 1e-7, 0.05):
            raise WrongDatasetError(
                Message(
                    "the {name} values are {own} and {others}; measure plate and survey with the "
                    "same sweep and rotations",
                    name=name,
                    own=f"{len(own)} from {own[0]:g} to {own[-1]:g}",
                    others=f"{len(others)} from {others[0]:g} to {others[-1]:g}",
                ),
                fault=faults.INPUT,
            )
