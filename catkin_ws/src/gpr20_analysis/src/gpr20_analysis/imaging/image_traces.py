"""The traces of a survey that an image is made of, and notes on them."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import errors, work
from gpr20_analysis.dataset import (
    DISPLAY_ONLY,
    HEIGHT,
    MM_PER_M,
    NAMED,
    OUTSIDE,
    POLARIZATION,
    S21,
    S21_DIMS,
    SAMPLE_DIMS,
    X,
    Y,
    missing_samples,
    require,
    usable,
)
from gpr20_analysis.errors import DamagedSurveyError, WrongDatasetError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Traces
from gpr20_analysis.processing.delay import ADVANCE, REMOVED, delay_to_remove_s, known_height
from gpr20_analysis.processing.surface_echo import SURFACE_DELAY
from gpr20_analysis.processing.sweep import FrequencyGrid
from gpr20_analysis.sentences import first_of, sentence_of
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import one_way_path_m, phase_advance

NOTED_M = 0.005
"""Median difference of surface echo and height above which an image has a note [m]."""
# Height differences of level ground, by the noise of the height sensor.
NOTED_RELIEF_M = 0.01
# Standard deviation of the heights. If the ground is uneven but imaged as level, that of the phase
# of an echo is 4 pi f sqrt(permittivity) / c times this: 1.4 rad at 3.3 GHz and permittivity 4,
# and echoes lose half of their power. The noise of the height sensor is 1 to 2 mm.
MOST_RELIEF_M = 0.005
# Spectra as measured, without missing samples, and in single precision while they are gated.
COPIES = 2.5


def traces_of(survey: xr.Dataset, options: ImageOptions) -> Tuple[List[Traces], List[Message]]:
    """Return the traces of each polarization, and notes on them.

    Raises:
        WrongDatasetError: The data are not spectra, or were changed for display.
        DamagedSurveyError: Samples or heights are missing, and that was not allowed.
    """
    changed = sentence_of(survey, DISPLAY_ONLY)
    if changed is not None:
        raise WrongDatasetError(
            Message(
                "the data were changed for display ({reason}); make the image without that step",
                reason=changed,
            )
        )
    recorded = require(survey, S21, S21_DIMS)
    work.require_bytes(COPIES * recorded.nbytes, Message("an image"))
    measured = recorded.values
    with np.errstate(invalid="ignore"):
        # A sum is finite only if all of its values are.
        finite = np.isfinite(np.sum(measured, axis=-1))
    present = usable(survey).transpose(*SAMPLE_DIMS).values & finite
    _check_present(survey, present, options)
    is_seen = np.any(present & np.any(measured != 0.0, axis=-1), axis=(1, 2))
    if not np.all(is_seen):
        raise WrongDatasetError(
            Message(
                "every trace at {rotation_deg:g} deg is missing or zero, so no echo can be seen; "
                "see gpr20 info, and check the steps: the background of a single trace is the "
                "trace itself",
                rotation_deg=survey[POLARIZATION].values[np.argmin(is_seen)],
            ),
            fault=errors.INPUT,
        )
    height_m = np.full(present.shape, options.height_m)
    if options.height_m is None:
        # A sample that is left out adds nothing, so its height does not matter.
        height_m = known_height(survey).values
        height_m = np.where(present, height_m, np.mean(height_m, where=present))
    _check_relief(height_m, options)
    sweep = FrequencyGrid.of(survey)
    delay_s = delay_to_remove_s(survey, options.delay_s)
    later_s = np.asarray(delay_s)
    if ADVANCE in survey:
        later_s = delay_s - np.nan_to_num(survey[ADVANCE].transpose(*SAMPLE_DIMS).values)
    if np.any(later_s):
        measured = measured * phase_advance(sweep.frequency_hz, later_s)
    # Single precision is 140 dB below the strongest echo that the steps have left.
    spectra = measured.astype(np.complex64)
    spectra[~present] = 0.0
    x_m, y_m = (np.asarray(survey[name].values, dtype=np.float64) for name in (X, Y))
    traces = [
        Traces(own, sweep, x_m, y_m, own_m, float(turn))
        for own, own_m, turn in zip(spectra, height_m, survey[POLARIZATION].values)
    ]
    return traces, _notes(survey, options, present, height_m, delay_s)


def _check_present(survey: xr.Dataset, present: np.ndarray, options: ImageOptions) -> None:
    """Check that no sample is missing unless it may be left out."""
    absent = [] if options.leave_out_missing else missing_samples(survey)
    if absent:
        raise DamagedSurveyError(
            Message(
                "samples without data: {count} ({samples}); --leave-out-missing makes the image "
                "without them",
                count=len(absent),
                samples=first_of(absent, NAMED),
            ),
            fault=errors.INPUT,
        )
    if not options.leave_out_missing and not np.all(present):
        raise WrongDatasetError(
            Message(
                "{count} samples that are marked as good contain NaN from an earlier step; "
                "check the steps",
                count=np.count_nonzero(~present),
            )
        )


def _check_relief(height_m: np.ndarray, options: ImageOptions) -> None:
    """Check that the method can image the heights, if it is not known why they differ."""
    deviation_m = float(np.max(np.std(height_m, axis=(1, 2))))
    if deviation_m <= MOST_RELIEF_M or options.ground is not None or options.method.exact_paths:
        return
    raise WrongDatasetError(
        Message(
            "the recorded heights differ by {range_mm:.0f} mm (standard deviation "
            "{deviation_mm:.1f} mm), too much for this method if the ground is uneven; use "
            "--method back-projection --ground uneven, or --ground level if the antennas moved "
            "up and down over level ground",
            range_mm=MM_PER_M * float(np.ptp(height_m)),
            deviation_mm=MM_PER_M * deviation_m,
        ),
        fault=NOT_ALLOWED,
    )


def _notes(
    survey: xr.Dataset,
    options: ImageOptions,
    present: np.ndarray,
    height_m: np.ndarray,
    delay_s: float,
) -> List[Message]:
    """Return what was left out, and what is doubtful of the heights.

    Raises:
        WrongDatasetError: The surface is not where the image assumes it, which a buried reference
            cannot have.
    """
    notes = []
    absent = int(np.count_nonzero(~present))
    if absent:
        notes.append(
            Message(
                "{count} of {total} samples were left out of the image ({samples})",
                count=absent,
                total=present.size,
                samples=first_of(missing_samples(survey), NAMED),
            )
        )
    if survey.attrs.get(OUTSIDE):
        around = int(survey.attrs[OUTSIDE])
        notes.append(
            Message("{count} planned samples around the image were not measured", count=around)
        )
    range_m = float(np.ptp(height_m))
    if options.ground is None and range_m > NOTED_RELIEF_M:
        notes.append(
            Message(
                "the recorded heights differ by {range_mm:.0f} mm, but the image assumes level "
                "ground; if the ground is uneven, echoes are misplaced: use --method "
                "back-projection --ground uneven",
                range_mm=MM_PER_M * range_m,
            )
        )
    difference_m = 0.0
    # Without that attribute the surface echo was not clear.
    if SURFACE_DELAY in survey.attrs:
        recorded_m = float(survey[HEIGHT].where(usable(survey)).median())
        used_m = recorded_m if options.height_m is None else options.height_m
        later_s = survey.attrs[SURFACE_DELAY] - delay_s - survey.attrs.get(REMOVED, 0.0)
        expected_m = float(np.hypot(used_m, 0.5 * options.separation_m))
        difference_m = recorded_m + one_way_path_m(float(later_s)) - expected_m
    # Written so that what is not known gives no note.
    if abs(difference_m) > NOTED_M:
        away = Message(
            "the surface echo is {difference_mm:+.0f} mm from the antenna height (median of the "
            "traces; limit {limit_mm:.0f} mm), so all depths are wrong; find the delay of cables "
            "and antennas with gpr20 delay, and check the height sensor",
            difference_mm=MM_PER_M * difference_m,
            limit_mm=MM_PER_M * NOTED_M,
        )
        if options.buried is not None:
            raise WrongDatasetError(
                Message(
                    "{note}; with that a buried reference gives a wrong permittivity: give the "
                    "delay with --delay, or the distance of the antennas with --separation",
                    note=away,
                ).reporting_only(NOT_ALLOWED)
            )
        notes.append(away)
    return notes
