"""The antennas of a robot: their model from surveys of a metal plate, and the step without it.

The far-field model is that of Lambot, Slob, van den Bosch, Stockbroeckx and Vanclooster, "Modeling
of ground-penetrating radar for accurate characterization of subsurface electric properties", IEEE
Transactions on Geoscience and Remote Sensing 42 (2004), 2555 to 2568: at each frequency

    S21 = internal + transmission * ground / (1 - feedback * ground),

where `ground` is what comes back from below an isotropic source. Internal are the coupling and the
ringing of the antennas, feedback is what they reflect back to the ground. Over a metal plate the
ground is known: a mirror at the known height. So measurements at several heights give all three.

How strongly the surface reflects gives the permittivity of the soil there. At normal incidence soil
reflects (1 - n) / (1 + n) of what a metal plate reflects, with the refractive index n. A rough
surface reflects exp(-2 (k sigma)^2) of that, with the wave number k in air and the standard
deviation sigma of the heights (Ament, "Toward a theory of reflection by a rough surface",
Proceedings of the IRE 41 (1953), 142 to 146): it is extrapolated to frequency 0.
"""

from __future__ import annotations

import json
from typing import Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import errors
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
from gpr20_analysis.processing.delay import REMOVED, known_height
from gpr20_analysis.processing.surface_echo import SURFACE_DELAY, thinned
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans, matched, steps_to_top
from gpr20_analysis.read.survey_attributes import ANTENNA_DELAY
from gpr20_analysis.sentences import with_notes
from gpr20_common.message import Message
from gpr20_survey.radar import SPEED_OF_LIGHT_M_S, delay_kernel, phase_advance

SURFACE_PERMITTIVITY = "surface_permittivity"
"""Attribute: permittivity by the reflection of the surface; with the ends of its range."""
ENDS = ("_lowest", "", "_highest")
SEPARATION, PLATE_HEIGHT, CENTRE, MISFIT = "separation_m", "plate_height", "centre_m", "misfit"
# Of heights that are to be one, and of the largest and smallest of all.
MOST_SPREAD_M, LEAST_RANGE_M = 0.006, 0.03
FEWEST_HEIGHTS = 4
MOST_MISFIT = 0.25
# Three unknowns of each frequency are not determined if the heights look alike to it.
SMALLEST_SHARE = 1e-3
# Of the path: where waves seem to come from, above or below the plane of the antennas.
CENTRES_M = np.linspace(-0.08, 0.08, 9)
MOST_ROUNDS = 40
SETTLED_M = 2e-6
# Of the largest transmission: what is fainter is attenuated, since its noise would be amplified.
FAINT = 10.0 ** (-30.0 / 20.0)
SURFACE_WITHIN_S = 0.4e-9
PADDING = 8
# Of the traces, those in which the surface must be found.
LEAST_SHARE = 0.6
# Of the strongest echo of a trace: what is weaker than that may be one of its sidelobes.
LEAST_LEVEL = 0.05
BLOCKS = 8
# Half of a 95 % range, as a share of the reflection: plate and antennas are not perfect.
OF_MODEL = 0.01
# Over wave number and path, squared: near a dipole the reflection of soil is smaller by that much.
OF_NEAR_FIELD = 3.0
LEAST, MOST = 0.02, 0.85
WIDEST_RATIO = 2.25
"""Of the ends of a measured range: depths are then known to a factor of 1.5."""
# Steps that leave the spectra of a trace as they were measured.
HARMLESS = ("polarization",)


def antenna_of(plates: Sequence[xr.Dataset], separation_m: float = 0.0) -> xr.Dataset:
    """Return the model of the antennas from surveys over a metal plate, each at one height.

    Args:
        plates: Surveys as measured, of the same sweep and rotations.
        separation_m: Distance between the antennas [m].

    Returns:
        Dataset with `antenna` (polarization, term, frequency): internal, transmission [m] and
        feedback [m]; and what describes the fit.

    Raises:
        WrongDatasetError: The surveys do not determine the model, or no plate explains them.
    """
    for one in plates:
        require_measured(one)
    plates = [matched(one, plates[0]) for one in plates]
    heights = [known_height(one).where(usable(one)) for one in plates]
    heights_m = np.array([float(one.mean()) for one in heights])
    spread_m = max(float(one.std()) for one in heights)
    if not (
        len(set(np.round(heights_m, 3))) >= FEWEST_HEIGHTS
        and np.ptp(heights_m) >= LEAST_RANGE_M
        and spread_m <= MOST_SPREAD_M
    ):
        raise WrongDatasetError(
            Message(
                "the heights above the plate are {heights_mm} mm, within one survey they differ by "
                "{spread_mm:.1f} mm (standard deviation; limit {limit_mm:.0f} mm); level the plate "
                "and make one survey for each of {fewest} heights or more that differ by "
                "{range_mm:.0f} mm, in uneven steps, such as 60, 75, 95, 125, 170 mm",
                heights_mm=", ".join(f"{MM_PER_M * one:.0f}" for one in heights_m),
                spread_mm=MM_PER_M * spread_m,
                limit_mm=MM_PER_M * MOST_SPREAD_M,
                fewest=FEWEST_HEIGHTS,
                range_mm=MM_PER_M * LEAST_RANGE_M,
            ),
            fault=errors.INPUT,
        )
    path_m = np.hypot(2.0 * heights_m, separation_m)
    means = np.stack([require(one, S21, S21_DIMS).mean([Y, X]).values for one in plates], axis=1)
    for number in np.flatnonzero(~np.isfinite(means).all(axis=(0, 2))):
        raise WrongDatasetError(
            Message(
                "survey {number} of the plate has a rotation without data; measure it again",
                number=number + 1,
            ),
            fault=errors.INPUT,
        )
    centres_m = CENTRES_M[-0.5 * float(path_m.min()) < CENTRES_M]
    frequency_hz = plates[0][FREQUENCY].values
    fits = [
        min((_fitted(own, path_m, frequency_hz, one) for one in centres_m), key=lambda one: one[1])
        for own in means
    ]
    terms, misfits, centres_m = zip(*fits)
    if not max(misfits) <= MOST_MISFIT:
        raise WrongDatasetError(
            Message(
                "a plate leaves {misfit:.0f} % of the measurements unexplained (limit "
                "{limit:.0f} %); check the heights, and that the plate is level and at least 1 "
                "m by 1 m",
                misfit=100.0 * max(misfits),
                limit=100.0 * MOST_MISFIT,
            ),
            fault=errors.INPUT,
        )
    return xr.Dataset(
        {
            ANTENNA: (ANTENNA_DIMS, np.stack(terms)),
            CENTRE: (POLARIZATION, list(centres_m)),
            MISFIT: (POLARIZATION, list(misfits)),
            PLATE_HEIGHT: ("plate", heights_m),
        },
        {POLARIZATION: plates[0][POLARIZATION], TERM: [0, 1, 2], FREQUENCY: plates[0][FREQUENCY]},
        {SEPARATION: separation_m},
    )


def _mirror(path_m: np.ndarray, frequency_hz: np.ndarray, centre_m: float) -> np.ndarray:
    """Return what comes back from a plate (path, frequency), by the length of its path [m].

    Args:
        path_m: Paths.
        frequency_hz: Frequencies.
        centre_m: Added to the length of a path, whose inverse is the spreading of a wave [m].
    """
    turns = np.outer(path_m, frequency_hz) / SPEED_OF_LIGHT_M_S
    spread: np.ndarray = -np.exp(-2j * np.pi * turns) / (path_m + centre_m)[:, None]
    return spread


def _fitted(
    s21: np.ndarray, path_m: np.ndarray, frequency_hz: np.ndarray, centre_m: float
) -> Tuple[np.ndarray, float, float]:
    """Return terms (3, frequency), misfit and centre of the model that explains a plate.

    The misfit is the root mean square of what the model leaves, as a share of what differs between
    the heights. The recorded heights are corrected, since an error of 1 mm turns the phase at 6 GHz
    by 14 degrees; their mean is kept.

    Args:
        s21: Mean spectra at each height (height, frequency), of at least `FEWEST_HEIGHTS`.
        path_m: From one antenna over the plate to the other, at each height [m].
        frequency_hz: Frequencies [Hz].
        centre_m: Where the waves are taken to come from [m], see `_mirror`.
    """
    differing = float(np.sum(np.abs(s21 - s21.mean(axis=0)) ** 2))
    wave = 2.0 * np.pi * frequency_hz / SPEED_OF_LIGHT_M_S
    moved_m = np.zeros(len(path_m))
    for _ in range(MOST_ROUNDS):
        mirror = _mirror(path_m + moved_m, frequency_hz, centre_m)
        terms = _solved(s21, mirror)
        internal, transmission, feedback = terms
        explained = transmission * mirror / (1.0 - feedback * mirror)
        left = s21 - internal - explained
        # By how much each path is longer, from the phase that is left.
        level = np.abs(explained) ** 2
        turned = np.angle((s21 - internal) * explained.conj())
        weight = np.maximum(np.sum(level * wave**2, axis=1), 1e-300)
        step_m = -np.sum(level * turned * wave, axis=1) / weight
        step_m -= step_m.mean()
        moved_m = moved_m + step_m
        if np.abs(step_m).max() < SETTLED_M:
            break
    # Surveys that do not differ are explained by anything, which explains nothing.
    alike = differing <= 1e-20 * float(np.sum(np.abs(s21) ** 2))
    misfit = 1.0 if alike else float(np.sqrt(np.sum(np.abs(left) ** 2) / differing))
    return terms, misfit, centre_m


def _solved(s21: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Return the terms by least squares at each frequency, with the heights given.

    Times the denominator, the equation is linear in internal, in feedback, and in transmission
    less the product of both.
    """
    columns = np.stack([np.ones_like(s21), mirror, s21 * mirror], axis=-1).transpose(1, 0, 2)
    scale = np.maximum(np.linalg.norm(columns, axis=1), 1e-300)
    inverse = np.linalg.pinv(columns / scale[:, None], rcond=SMALLEST_SHARE)
    found = np.einsum("fkh,hf->kf", inverse, s21) / scale.T
    return np.stack([found[0], found[1] + found[0] * found[2], found[2]])


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
            fault=errors.INPUT,
        )
    require_measured(survey)
    model = matched(model, survey)
    terms = require(model, ANTENNA, ANTENNA_DIMS)
    internal, transmission, feedback = (terms.isel({TERM: one}) for one in range(3))
    received = measured - internal
    # A share of what is lost in noise, so that it is not amplified.
    faint = FAINT * float(np.abs(transmission).max())
    kept = np.abs(transmission) ** 2 / (np.abs(transmission) ** 2 + faint**2)
    ground = (received / (transmission + feedback * received) * kept).transpose(*S21_DIMS)
    cleaned = survey.assign({S21: ground.astype(measured.dtype).assign_attrs(measured.attrs)})
    return _with_surface(cleaned, model)


def _with_surface(cleaned: xr.Dataset, model: xr.Dataset) -> xr.Dataset:
    """Return data without antennas with the delay and the permittivity by their surface."""
    separation_m = float(model.attrs[SEPARATION])
    chosen = thinned(cleaned)
    height_m, known = known_height(chosen).values, usable(chosen).transpose(*SAMPLE_DIMS).values
    sweep = FrequencyGrid.of(cleaned)
    later_s, ranges, delays_s = [], [], []
    for turn, fit in enumerate(model.transpose(POLARIZATION, ...)[ANTENNA].values):
        transmission = fit[1]
        step = transmission[1:] * transmission[:-1].conj()
        delays_s.append(-float(np.angle(np.sum(step))) / (2.0 * np.pi * sweep.step_hz))
        spectra = chosen[S21].values[turn][known[turn]]
        expected_s = np.hypot(2.0 * height_m[turn][known[turn]], separation_m) / SPEED_OF_LIGHT_M_S
        picked_s = _strongest_s(spectra, expected_s, sweep)
        clear = np.isfinite(picked_s)
        if np.count_nonzero(clear) < LEAST_SHARE * len(clear) or not clear.any():
            continue
        later_s.append(float(np.median((picked_s - expected_s)[clear])))
        path_m = picked_s[clear] * SPEED_OF_LIGHT_M_S
        ratio = spectra[clear] / _mirror(path_m, sweep.frequency_hz, float(model[CENTRE][turn]))
        aslant = (separation_m / float(np.mean(path_m))) ** 2
        ranges.append(
            _permittivity(ratio, path_m, transmission, sweep, aslant, float(model[MISFIT][turn]))
        )
    # What the antennas add is the delay of the transmission, weighted by its power.
    delay_s = float(np.mean(delays_s))
    attributes = {ANTENNA_DELAY: 0.0, REMOVED: delay_s}
    if later_s:
        attributes[SURFACE_DELAY] = delay_s + float(np.median(later_s))
    cleaned = cleaned.assign_attrs({**cleaned.attrs, **attributes})
    accepted = [one for one in ranges if one is not None]
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


def _strongest_s(spectra: np.ndarray, expected_s: np.ndarray, sweep: FrequencyGrid) -> np.ndarray:
    """Return the delay of the highest maximum near an expected one; NaN if none is strong [s]."""
    reach = max(2, int(np.ceil(SURFACE_WITHIN_S * PADDING * sweep.step_hz * sweep.count)))
    near_s = SURFACE_WITHIN_S / reach * np.arange(-reach - 1, reach + 2)
    least = LEAST_LEVEL * np.abs(a_scans(spectra, sweep, 2 * sweep.count)).max(axis=-1)
    aligned = spectra * phase_advance(sweep.frequency_hz, expected_s)
    level = np.abs(aligned @ delay_kernel(sweep.frequency_hz, near_s))
    here, before, after = level[:, 1:-1], level[:, :-2], level[:, 2:]
    tops = np.where((here >= before) & (here > after), here, -1.0)
    at = 1 + np.argmax(tops, axis=1)
    found_s = expected_s + near_s[at] + SURFACE_WITHIN_S / reach * steps_to_top(level, at)
    return np.where(tops.max(axis=1) > least, found_s, np.nan)


def _permittivity(
    ratio: np.ndarray,
    path_m: np.ndarray,
    transmission: np.ndarray,
    sweep: FrequencyGrid,
    aslant: float,
    misfit: float,
) -> Optional[Tuple[float, float, float]]:
    """Return lowest, best and highest permittivity, or None if the reflection is not clear enough.

    Args:
        ratio: What comes back from the ground, relative to a plate (trace, frequency).
        path_m: Path over the surface of each trace, by the delay of its echo [m].
        transmission: That of the antennas, by which frequencies are weighted.
        sweep: The frequencies.
        aslant: Square of the tangent of the angle between the antennas.
        misfit: Of the antennas' model.
    """
    weights = np.abs(transmission) * np.hanning(sweep.count + 2)[1:-1]
    wave = 2.0 * np.pi * sweep.frequency_hz / SPEED_OF_LIGHT_M_S
    at_once, level = _reflection(ratio.mean(axis=0), wave, weights)
    # Jackknife over blocks: neighbouring traces see the same ground.
    blocks = np.array_split(np.arange(len(ratio)), min(BLOCKS, len(ratio)))
    left_out = [
        _reflection(np.delete(ratio, block, axis=0).mean(axis=0), wave, weights)[0]
        for block in blocks
        if len(block) < len(ratio)
    ]
    scatter = np.sqrt((len(left_out) - 1.0) * np.var(left_out)) if left_out else level
    near = (OF_NEAR_FIELD / float(np.average(wave, weights=weights) * np.mean(path_m))) ** 2
    share = OF_MODEL + aslant + max(near, misfit)
    half = at_once * share + 2.0 * float(scatter) + 0.5 * abs(at_once - level)
    ends = at_once - half, at_once, at_once + half
    # Written so that NaN is refused too.
    if not (ends[0] > LEAST and ends[2] < MOST):
        return None
    lowest, best, highest = (((1.0 + one) / (1.0 - one)) ** 2 for one in ends)
    return (lowest, best, highest) if highest <= WIDEST_RATIO * lowest else None


def _reflection(mean: np.ndarray, wave: np.ndarray, weights: np.ndarray) -> Tuple[float, float]:
    """Return the reflection at frequency 0, and its mean over the band."""
    level = float(np.abs(np.average(mean, weights=weights)))
    # Of the logarithm, by the square of the wave number; each weighted by its amplitude.
    weights = weights * np.abs(mean)
    squared = wave**2 - np.average(wave**2, weights=weights)
    logarithm = np.log(np.maximum(np.abs(mean), 1e-12))
    middle = float(np.average(logarithm, weights=weights))
    slope = float(np.sum(weights * squared * logarithm) / np.sum(weights * squared**2))
    if not slope < 0.0:
        return level, level
    return float(np.exp(middle - slope * np.average(wave**2, weights=weights))), level


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
