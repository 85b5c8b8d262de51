"""Time zero picked in the traces, and topography: where each trace begins in a picture."""

from __future__ import annotations

import enum
from typing import Tuple

import numpy as np
import scipy.fft
import xarray as xr

from gpr20_analysis.dataset import S21, S21_DIMS, SAMPLE_DIMS, require, usable
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.processing.delay import ADVANCE, advanced, known_height, recorded_delay_s
from gpr20_analysis.processing.sweep import FrequencyGrid, a_scans
from gpr20_analysis.sentences import with_notes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral
from gpr20_survey.radar.depth import two_way_delay_s
from gpr20_survey.radar.frequency_to_delay import delay_kernel, phase_advance
from gpr20_survey.radar.soils import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY

TOPOGRAPHY = "topography_permittivity"
"""Attribute: permittivity with which the step `topography` moved the traces."""
PADDING = 8
# Of the traces, those in which the surface must be found.
LEAST_SHARE = 0.6
# Of the strongest echo of a trace: what is weaker than that may be one of its sidelobes.
LEAST_LEVEL = 0.05


class Arrival(enum.Enum):
    """What is picked as time zero."""

    SURFACE = "surface"
    """The strongest echo near the recorded height."""
    FIRST = "first"
    """Where the envelope first reaches a share of its maximum: in general the coupling."""


def pick_time_zero(
    survey: xr.Dataset,
    arrival: Arrival = Arrival.SURFACE,
    within_s: float = 0.3e-9,
    share: float = 0.5,
) -> xr.Dataset:
    """Put delay 0 at an arrival that is picked in each trace.

    Like `set_time_zero` this changes the spectra, and variable `advance` holds what was removed,
    so images are the same as without this step.

    Args:
        survey: Dataset with `s21`.
        arrival: What is picked.
        within_s: For the surface: largest difference to the delay of the recorded height [s].
            Where no maximum is found within it, the height with the median difference is used.
        share: For the first arrival: share of the trace's maximum, 0 to 1.

    Raises:
        WrongDatasetError: Time zero was set before, a value is not allowed, or the surface is
            found in too few traces.
        DamagedSurveyError: A usable sample has no height, which the surface needs.
    """
    measured = require(survey, S21, S21_DIMS)
    if ADVANCE in survey:
        raise WrongDatasetError(
            Message("time zero was set before; setting it again would shift it twice")
        )
    if not (within_s > 0.0 and 0.0 < share <= 1.0):
        raise WrongDatasetError(
            Message(
                "the pick of time zero has within_s {within_s:g} and share {share:g}; they must be "
                "more than 0, and the share at most 1",
                within_s=within_s,
                share=share,
            ),
            fault=NOT_ALLOWED,
        )
    if arrival is Arrival.FIRST:
        sweep = FrequencyGrid.of(survey)
        picked_s = first_arrival_s(measured.values, sweep, share)
        return advanced(survey, xr.DataArray(picked_s, dims=SAMPLE_DIMS))
    picked, count = _surface_picks(survey, measured, within_s)
    result = advanced(survey, picked)
    if not count:
        return result
    note = Message(
        "time zero of {count} traces is by their height, because no surface echo is near it",
        count=count,
    )
    return result.assign_attrs(with_notes(result, [note]))


def correct_topography(survey: xr.Dataset, permittivity: float) -> xr.Dataset:
    """Move each trace down by the relief of the ground, so that a section shows its shape.

    The antennas are assumed to move in a level plane, so the surface is highest where the recorded
    height is least. Delay 0 is at that level; a lower surface is shown at the two-way delay that
    soil of this permittivity would have down to it. Variable `advance` follows, so images are the
    same as without this step.

    Args:
        survey: Dataset with `s21`, after time_zero or pick_time_zero.
        permittivity: Relative permittivity of the soil.

    Raises:
        WrongDatasetError: Time zero was not set, or topography was applied before.
        DamagedSurveyError: A usable sample has no height.
    """
    if ADVANCE not in survey:
        raise WrongDatasetError(
            Message("topography moves traces that begin at the surface; apply time_zero before it")
        )
    if TOPOGRAPHY in survey.attrs:
        raise WrongDatasetError(
            Message("topography was applied before; it would move traces twice")
        )
    if not MIN_PERMITTIVITY <= permittivity <= LARGEST_PERMITTIVITY:
        raise WrongDatasetError(
            Message(
                "{name} is {value}; it must lie between {lower} and {upper}",
                name=Message("the permittivity"),
                value=numeral(permittivity),
                lower=numeral(MIN_PERMITTIVITY),
                upper=numeral(LARGEST_PERMITTIVITY),
            ),
            fault=NOT_ALLOWED,
        )
    height_m = known_height(survey)
    relief_m = height_m - float(height_m.where(usable(survey)).min())
    down_s = two_way_delay_s(np.sqrt(permittivity) * relief_m)
    before_s = survey[ADVANCE].transpose(*SAMPLE_DIMS)
    moved = advanced(survey.drop_vars(ADVANCE), -down_s)
    advance = (before_s - down_s).assign_attrs(before_s.attrs)
    return moved.assign({ADVANCE: advance}).assign_attrs({TOPOGRAPHY: permittivity})


def first_arrival_s(spectra: np.ndarray, sweep: FrequencyGrid, share: float) -> np.ndarray:
    """Return where the envelope of each trace first reaches a share of its maximum [s]."""
    count = scipy.fft.next_fast_len(PADDING * sweep.count)
    # The last eighth of the period is before delay 0, where the main lobe of an echo begins.
    envelope = np.roll(np.abs(a_scans(spectra, sweep, count)), count // 8, -1)
    least = share * envelope.max(axis=-1, keepdims=True)
    above = np.argmax(envelope >= least, axis=-1)[..., None]
    after = np.take_along_axis(envelope, above, -1)
    before = np.take_along_axis(envelope, np.maximum(above - 1, 0), -1)
    part = np.where(
        after > before, (least - before) / np.where(after > before, after - before, 1), 1
    )
    place = above - 1 + part - count // 8
    found: np.ndarray = place[..., 0] * (sweep.unambiguous_s / count)
    return np.where(np.isfinite(spectra).all(axis=-1), found, np.nan)


def strongest_s(
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


def _surface_picks(
    survey: xr.Dataset, measured: xr.DataArray, within_s: float
) -> Tuple[xr.DataArray, int]:
    """Return the picks, and how many of them are by the height only."""
    sweep = FrequencyGrid.of(survey)
    expected = two_way_delay_s(known_height(survey)) + recorded_delay_s(survey)
    expected = expected.transpose(*SAMPLE_DIMS)
    # Row by row: the levels near each trace are many times the traces.
    picked = xr.full_like(expected, np.nan)
    for place in np.ndindex(*expected.shape[:2]):
        own = strongest_s(measured.values[place], expected.values[place], sweep, within_s)
        picked.values[place] = own
    present = usable(survey).transpose(*SAMPLE_DIMS)
    found = np.isfinite(picked) & present
    total, count = int(present.sum()), int(found.sum())
    if not count or count < LEAST_SHARE * total:
        raise WrongDatasetError(
            Message(
                "the surface echo is within {within_s:g} s of the recorded height in only {count} "
                "of {total} traces; pick it before the background is removed, or use a larger "
                "within_s",
                within_s=within_s,
                count=count,
                total=total,
            )
        )
    median_s = float((picked - expected).where(found).median())
    return picked.where(found, expected + median_s), total - count
