"""The image of a survey as the robot's window shows it, also of one that is still measured."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import (
    CLUTTER,
    DEPTH,
    IMAGE,
    MM_PER_M,
    POLARIZATION,
    SAMPLE_DIMS,
    X,
    Y,
    description_of,
    usable,
)
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.processing.chain import process_survey
from gpr20_common.faults import BUSY
from gpr20_common.message import Message
from gpr20_survey.folder.soil_note import soil_of_survey
from gpr20_survey.radar.frequency_to_delay import decibels
from gpr20_survey.radar.soils import soil_of
from gpr20_survey.results.focused_image import FocusedImage

# With fewer lines neither the background nor the clutter can be measured.
FEWEST_LINES = 3


def focus(survey: xr.Dataset, permittivity: Optional[float]) -> FocusedImage:
    """Return the focused image of what was measured of a survey.

    Args:
        survey: Dataset of `load_survey`; samples may be missing.
        permittivity: Relative permittivity of the ground; None: what the survey says.

    Raises:
        AnalysisError: There are too few traces, or no image can be made of them.
    """
    present = usable(survey).transpose(*SAMPLE_DIMS).values
    rows, columns = _measured_part(np.any(present, axis=0))
    # Lines without any trace would count as lines without noise.
    part = survey.isel({Y: rows, X: columns})
    image = image_survey(process_survey(part, *DEFAULT_STEPS), field_options(permittivity, part))
    levels_db = np.full((image.sizes[DEPTH], *present.shape[1:]), np.nan, np.float32)
    levels_db[:, rows, columns] = levels_above_clutter_db(image)
    levels_db[:, ~np.any(present, axis=0)] = np.nan
    x_mm, y_mm = (MM_PER_M * survey[name].values.astype(np.float64) for name in (X, Y))
    return FocusedImage(
        traces=int(np.count_nonzero(present)),
        x_mm=x_mm,
        y_mm=y_mm,
        depth_mm=MM_PER_M * image[DEPTH].values,
        levels_db=levels_db,
        found=find_candidates(image),
    )


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


def levels_above_clutter_db(image: xr.Dataset) -> np.ndarray:
    """Return the level of the brighter polarization (depth, y, x) above clutter [dB], float32.

    Args:
        image: Dataset of `image_survey`.
    """
    magnitude = np.abs(image[IMAGE].transpose(POLARIZATION, DEPTH, Y, X).values)
    clutter = image[CLUTTER].transpose(POLARIZATION, DEPTH)
    ratio = (magnitude / clutter.values[:, :, None, None]).max(axis=0)
    levels_db = decibels(ratio, float(np.finfo(np.float32).tiny)) / int(clutter.attrs["factors"])
    return levels_db.astype(np.float32)


def _measured_part(present: np.ndarray) -> Tuple[slice, slice]:
    """Return the rows and columns between the first and the last with a sample (y, x)."""
    rows, columns = (np.flatnonzero(np.any(present, axis=axis)) for axis in (1, 0))
    if min(len(rows), len(columns)) < FEWEST_LINES:
        raise WrongDatasetError(
            Message(
                "a focused image needs traces on {fewest} lines; {rows} have any so far",
                fewest=FEWEST_LINES,
                rows=min(len(rows), len(columns)),
            ),
            fault=BUSY.as_note(),
        )
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
