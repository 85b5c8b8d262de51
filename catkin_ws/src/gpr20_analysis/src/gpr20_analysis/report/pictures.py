"""The figures of a survey and its image, and its candidates, for the report."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.candidates.table import (
    candidate_heading,
    candidate_row,
    tail_sentences,
)
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.imaging.permittivity import permittivity_line
from gpr20_analysis.plotting import projections, scans
from gpr20_analysis.plotting.ranges import last_delay_s, surface_delay_s, until
from gpr20_analysis.processing.chain import Step, apply_steps
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.report.records import Section
from gpr20_analysis.sentences import ENGLISH, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.mid.checks import with_unit
from gpr20_survey.results.candidates import NO_CLEARANCE, CandidateList

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLICES = 3
NS_PER_S, PS_PER_S = 1e9, 1e12
# Of the figures, where the survey's steps are longer.
FINE_STEP_M, MOST_VOXELS = 0.005, 4_000_000
IMAGE_TITLE, CANDIDATES_TITLE = Message("Image of the ground"), Message("Candidates")

Pictures = List[Tuple[str, "Figure"]]


def as_measured(
    survey: xr.Dataset, options: ImageOptions, catalogue: Catalogue = ENGLISH
) -> Section:
    """Return A-, B- and C-scans before any processing."""
    in_time, last_s = to_time(survey), _last_s(survey, options)
    x_m, y_m = _middle(survey)
    figures: Pictures = []
    if dataset.usable(survey).sel(x=x_m, y=y_m).values.any():
        figure = scans.a_scan_figure(in_time, x_m, y_m, last_s, catalogue)
        figures.append((catalogue.tr("A-scan in the middle"), figure))
    figures += _b_scans(in_time, (x_m, y_m), last_s, options.permittivity, catalogue)
    surface_s = surface_delay_s(survey)
    if surface_s is not None and not dataset.is_line(survey):
        delay_ps = surface_s * PS_PER_S
        caption = catalogue.tr("C-scan at the surface, {delay_ps:.0f} ps", delay_ps=delay_ps)
        figures.append((caption, scans.c_scan_figure(in_time, surface_s, catalogue)))
    last_ns = float(until(in_time, last_s)[dataset.DELAY][-1]) * NS_PER_S
    line = catalogue.tr(
        "Delays up to {last_ns:.1f} ns are shown, slightly more than the image covers.",
        last_ns=last_ns,
    )
    return Section(catalogue.tr("Data as measured"), lines=[line], figures=figures)


def imaged(
    survey: xr.Dataset,
    steps: Sequence[Step],
    options: ImageOptions,
    catalogue: Catalogue = ENGLISH,
) -> List[Section]:
    """Return the candidates, the image, and the data from which it was made.

    Args:
        survey: Dataset with `s21`.
        steps: The steps before imaging.
        options: How the image is made.
        catalogue: Language of the texts.

    Returns:
        The sections; the first says why if there is no image.
    """
    try:
        processed = apply_steps(survey, steps, _no_other_survey)
    except AnalysisError as error:
        # A survey that cannot be imaged gets a report too, which says why.
        return [_no_image(error, catalogue)]
    try:
        image = image_survey(processed, options)
    except AnalysisError as error:
        views = _after_steps(processed, steps, options, options.permittivity, catalogue)
        return [_no_image(error, catalogue), *views]
    permittivity = float(image.attrs["permittivity"])
    found = find_candidates(image)
    drawn = _finer(processed, image, options)
    return [
        _candidates(drawn, found, catalogue),
        _image(drawn, found, options, catalogue),
        *_after_steps(processed, steps, options, permittivity, catalogue),
    ]


def _finer(processed: xr.Dataset, image: xr.Dataset, options: ImageOptions) -> xr.Dataset:
    """Return an image with a finer grid for the figures, if it takes little time and memory."""
    steps_m = [np.diff(image[axis].values) for axis in (dataset.X, dataset.Y)]
    coarsest_m = max((float(np.max(one)) for one in steps_m if one.size), default=0.0)
    voxels = image[dataset.IMAGE].size * (coarsest_m / FINE_STEP_M) ** 2
    if (
        options.grid_step_m is not None
        or options.method is not Method.PHASE_SHIFT
        or coarsest_m <= FINE_STEP_M
        or voxels > MOST_VOXELS
    ):
        return image
    permittivity = float(image.attrs["permittivity"])
    # However it is known, it is that of the image now.
    known = replace(options, permittivity=permittivity, soil=None, buried=None)
    finer = replace(known, grid_step_m=FINE_STEP_M)
    # What is said about the estimate and the data is that of the image with the candidates.
    return image_survey(processed, finer, with_echoes=False).assign_attrs(image.attrs)


def _after_steps(
    processed: xr.Dataset,
    steps: Sequence[Step],
    options: ImageOptions,
    permittivity: Optional[float],
    catalogue: Catalogue,
) -> List[Section]:
    if dataset.S21 not in processed:
        return []
    last_s = _last_s(processed, options)
    figures = _b_scans(to_time(processed), _middle(processed), last_s, permittivity, catalogue)
    lines = [catalogue.tr("step: {step}", step=_step_text(step)) for step in steps]
    return [Section(catalogue.tr("Data after the steps"), lines=lines, figures=figures)]


def _no_image(error: AnalysisError, catalogue: Catalogue) -> Section:
    warning = Message("No image was made: {reason}", reason=error.message)
    return Section(
        catalogue.text(CANDIDATES_TITLE),
        catalogue.text(NO_CLEARANCE),
        [shown(warning, catalogue)],
    )


def _candidates(image: xr.Dataset, found: CandidateList, catalogue: Catalogue) -> Section:
    figure = projections.candidate_map_figure(image, found.candidates, catalogue)
    listed = found.shown()
    return Section(
        catalogue.text(CANDIDATES_TITLE),
        catalogue.text(NO_CLEARANCE),
        lines=[shown(one, catalogue) for one in [*tail_sentences(found, listed), *found.notes]],
        rows=[candidate_row(one, catalogue) for one in listed],
        heading=candidate_heading(catalogue),
        figures=[(catalogue.tr("Map of the candidates"), figure)],
    )


def _image(
    image: xr.Dataset, found: CandidateList, options: ImageOptions, catalogue: Catalogue
) -> Section:
    figures: Pictures = []
    for number, turn in enumerate(image[dataset.POLARIZATION].values):
        caption = catalogue.tr("Maximum projections at {rotation_deg:g} deg", rotation_deg=turn)
        figure = projections.projection_figure(image, number, found.candidates, catalogue)
        figures.append((caption, figure))
    depths_m = [one.depth_m for one in found.candidates]
    slices_m = image[dataset.DEPTH].sel(depth=depths_m, method="nearest")
    if dataset.is_line(image):
        slices_m = slices_m[:0]
    # Some candidates are at one depth.
    for depth_m in list(dict.fromkeys(slices_m.values.tolist()))[:SLICES]:
        caption = catalogue.tr("Slice at {depth_mm:.1f} mm", depth_mm=depth_m * dataset.MM_PER_M)
        figures.append((caption, scans.c_scan_figure(image, depth_m, catalogue)))
    rows = _parameters(image, options, catalogue)
    return Section(catalogue.text(IMAGE_TITLE), rows=rows, figures=figures)


def _parameters(
    image: xr.Dataset, options: ImageOptions, catalogue: Catalogue
) -> List[Tuple[str, ...]]:
    depths_mm = image[dataset.DEPTH].values * dataset.MM_PER_M
    depths = catalogue.tr(
        "{count} from {first_mm:.1f} to {last_mm:.1f} mm",
        count=len(depths_mm),
        first_mm=depths_mm[0],
        last_mm=depths_mm[-1],
    )
    height_m = options.height_m
    height = Message("as recorded") if height_m is None else with_unit(height_m, "m")
    return [
        (catalogue.tr("permittivity"), catalogue.text(permittivity_line(image))),
        (catalogue.tr("depths"), depths),
        (catalogue.tr("method"), options.method.name),
        (catalogue.tr("window"), options.window.value),
        (
            catalogue.tr("widest angle in air"),
            catalogue.tr("{angle_deg:g} deg", angle_deg=options.widest_angle_deg),
        ),
        (catalogue.tr("height"), catalogue.text(height)),
    ]


def _step_text(step: Step) -> str:
    values = ", ".join(f"{key} {value}" for key, value in step.parameters.items())
    return f"{step.name} ({values})" if values else step.name


def _last_s(survey: xr.Dataset, options: ImageOptions) -> float:
    return last_delay_s(survey, options.depth_m[-1], options.permittivity)


def _middle(survey: xr.Dataset) -> Tuple[float, float]:
    x_m, y_m = (float(survey[axis][survey.sizes[axis] // 2]) for axis in (dataset.X, dataset.Y))
    return x_m, y_m


def _b_scans(
    in_time: xr.Dataset,
    place_m: Tuple[float, float],
    last_s: float,
    permittivity: Optional[float],
    catalogue: Catalogue,
) -> Pictures:
    figures: Pictures = []
    x_m, y_m = place_m
    for along, at_m in ((dataset.X, y_m), (dataset.Y, x_m)):
        if in_time.sizes[along] > 1:
            figure = scans.b_scan_figure(
                in_time,
                along,
                at_m,
                last_s=last_s,
                permittivity=permittivity,
                catalogue=catalogue,
            )
            figures.append((catalogue.tr("B-scan along {axis}", axis=along), figure))
    return figures


def _no_other_survey(path: str) -> xr.Dataset:
    raise AnalysisError(
        Message(
            "a report cannot subtract another survey; leave out the step that names {path}",
            path=path,
        ),
        fault=faults.STEPS,
    )
