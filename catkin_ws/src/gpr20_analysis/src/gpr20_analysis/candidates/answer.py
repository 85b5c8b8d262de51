"""From a survey and its options to its answer: the image of the ground, and the places to check.

Window, page, commands, report and the imaging node all ask here, so one survey has one answer. What
is not given is what the survey knows: soil, height, antenna separation, delay of the cables, and
its site's rate of false alarms.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import (
    CLUTTER,
    DEPTH,
    HEIGHT,
    IMAGE,
    MM_PER_M,
    OUTSIDE,
    POLARIZATION,
    SAMPLE_DIMS,
    X,
    Y,
    description_of,
    mapping_of,
    usable,
)
from gpr20_analysis.errors import TOO_FEW_LINES, WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import DEFAULT_STEPS, ImageOptions
from gpr20_analysis.processing.antenna_step import HARMLESS
from gpr20_analysis.processing.chain import process_survey, recorded_steps
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.message import Message
from gpr20_survey.folder.log_record import soil_of_survey
from gpr20_survey.plan.annotation import FALSE_ALARMS_PER_M2, USUAL_FALSE_ALARMS_PER_M2
from gpr20_survey.radar import decibels, soil_of
from gpr20_survey.results.answers import FocusedImage
from gpr20_survey.results.candidates import CandidateList

# With fewer lines of an area neither the background nor the clutter can be measured.
FEWEST_LINES = 3


@dataclass(frozen=True)
class Answer:
    """What a survey shows.

    Attributes:
        processed: The survey without coupling and surface echo.
        image: Dataset of `image_survey`.
        found: Its places to check, and the weaker echoes.
    """

    processed: xr.Dataset
    image: xr.Dataset
    found: CandidateList


def answer(
    survey: xr.Dataset,
    options: Optional[ImageOptions] = None,
    progress: Progress = no_progress,
    steps: Optional[Sequence[str]] = None,
) -> Answer:
    """Return what a survey shows.

    Args:
        survey: Dataset with `s21`. Coupling and surface echo are subtracted, unless a step before
            has done so.
        options: How the image is made; None: with what the survey knows.
        progress: Shows the progress of each polarization.
        steps: What is subtracted; None: see `default_steps`.

    Raises:
        AnalysisError: No image can be made of it.
    """
    options = options or ImageOptions()
    if options.leave_out_missing:
        survey = measured(survey)
    chosen = default_steps(survey) if steps is None else steps
    processed = process_survey(survey, *chosen)
    image = image_survey(processed, options, progress)
    rate = options.false_alarms_per_m2 or site_false_alarms_per_m2(survey)
    return Answer(processed, image, find_candidates(image, rate))


def default_steps(survey: xr.Dataset) -> Sequence[str]:
    """Return the steps before an image, unless a step before has left no surface echo to remove."""
    before = {one["step"] for one in recorded_steps(survey)}
    is_measured = not before or ("antenna" in before and before <= {"antenna", *HARMLESS})
    return DEFAULT_STEPS if is_measured else ()


def site_false_alarms_per_m2(survey: xr.Dataset) -> float:
    """Return the rate of false alarms that the site of a survey has set, else the usual one."""
    found = mapping_of(description_of(survey), "site").get("false_alarms_per_m2")
    lowest, highest = FALSE_ALARMS_PER_M2
    if isinstance(found, (int, float)) and lowest <= found <= highest:
        return float(found)
    return USUAL_FALSE_ALARMS_PER_M2


def with_height(survey: xr.Dataset, height_m: Optional[float]) -> xr.Dataset:
    """Return a survey with one antenna height for all samples; None: as recorded."""
    if height_m is None:
        return survey
    return survey.assign({HEIGHT: xr.full_like(survey[HEIGHT], height_m)})


def field_options(
    permittivity: Optional[float], survey: Optional[xr.Dataset] = None
) -> ImageOptions:
    """Return the options of an image on the robot, whose window offers soils by their value.

    Args:
        permittivity: As it was chosen; that of a soil has the range of that soil. None: what the
            survey says.
        survey: What it says itself counts as not chosen, so that the source is named.

    Returns:
        The options, which leave out missing samples.

    Raises:
        WrongDatasetError: The permittivity is not allowed.
    """
    noted = None if survey is None else soil_of_survey(description_of(survey))
    if noted is not None and permittivity == noted.permittivity:
        permittivity = None
    soil = None if permittivity is None else soil_of(permittivity)
    return ImageOptions(
        permittivity=permittivity if soil is None else None, soil=soil, leave_out_missing=True
    )


def focus(survey: xr.Dataset, permittivity: Optional[float]) -> FocusedImage:
    """Return the answer of what was measured of a survey, as window and page show it.

    Args:
        survey: Dataset of `load_survey`; samples may be missing.
        permittivity: Relative permittivity of the ground; None: what the survey says.

    Raises:
        AnalysisError: There are too few traces, or no image can be made of them.
    """
    found = answer(survey, field_options(permittivity, survey))
    image, present = found.image, usable(survey).transpose(*SAMPLE_DIMS).values
    levels_db = np.full((image.sizes[DEPTH], *present.shape[1:]), np.nan, np.float32)
    rows, columns = _measured_part(survey)
    levels_db[:, rows, columns] = levels_above_clutter_db(image)
    levels_db[:, ~np.any(present, axis=0)] = np.nan
    x_mm, y_mm = (MM_PER_M * survey[name].values.astype(np.float64) for name in (X, Y))
    return FocusedImage(
        traces=int(np.count_nonzero(present)),
        x_mm=x_mm,
        y_mm=y_mm,
        depth_mm=MM_PER_M * image[DEPTH].values,
        levels_db=levels_db,
        found=found.found,
    )


def levels_above_clutter_db(image: xr.Dataset) -> np.ndarray:
    """Return the level of the brighter polarization (depth, y, x) above clutter [dB], float32.

    Args:
        image: Dataset of `image_survey`.
    """
    magnitude = np.abs(image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X).values)
    clutter = image[CLUTTER].transpose(POLARIZATION, DEPTH)
    ratio = (magnitude / clutter.values[:, :, None, None]).max(axis=0)
    return decibels(ratio, float(np.finfo(np.float32).tiny)).astype(np.float32)


def measured(survey: xr.Dataset) -> xr.Dataset:
    """Return a survey without the lines at its edges that have no trace.

    They would count as lines without noise. The notes of its image count them.

    Raises:
        WrongDatasetError: There are too few others.
    """
    rows, columns = _measured_part(survey)
    part = survey.isel({Y: rows, X: columns})
    outside = usable(survey).size - usable(part).size
    return part.assign_attrs({OUTSIDE: outside}) if outside else part


def _measured_part(survey: xr.Dataset) -> Tuple[slice, slice]:
    """Return the rows and columns between the first and the last with a sample (y, x)."""
    present = np.any(usable(survey).transpose(*SAMPLE_DIMS).values, axis=0)
    rows, columns = (np.flatnonzero(np.any(present, axis=axis)) for axis in (1, 0))
    for own, size in zip((rows, columns), present.shape):
        if len(own) < min(FEWEST_LINES, size):
            raise WrongDatasetError(
                Message(
                    "a focused image needs traces on {fewest} lines; lines with traces: {rows}",
                    fewest=FEWEST_LINES,
                    rows=len(own),
                ),
                fault=TOO_FEW_LINES,
            )
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
