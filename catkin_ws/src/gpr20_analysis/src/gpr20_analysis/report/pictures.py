"""The figures of a survey and its image, for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis import dataset
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.candidates.table import (
    candidate_heading,
    candidate_row,
    head_sentences,
    tail_sentences,
)
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.image_output import permittivity_line
from gpr20_analysis.plotting import scans
from gpr20_analysis.processing.chain import Step, apply_steps
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.report.page import Section
from gpr20_analysis.sentences import ENGLISH, NOTES, sentences_of, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLICES = 3
NS_PER_S, PS_PER_S = 1e9, 1e12
# Margin below the deepest layer of the image, and values for unknown height and permittivity.
MARGIN_S, HEIGHT_M, PERMITTIVITY = 1e-9, 0.3, 9.0
IMAGE_TITLE = Message("Image of the ground")

Pictures = List[Tuple[str, "Figure"]]


def as_measured(
    survey: xr.Dataset, options: ImageOptions, catalogue: Catalogue = ENGLISH
) -> Section:
    """Return A-, B- and C-scans before any processing."""
    in_time = _shown(survey, options)
    x_m, y_m = _middle(survey)
    figures: Pictures = []
    if dataset.usable(survey).sel(x=x_m, y=y_m).values.any():
        figure = scans.a_scan_figure(in_time, x_m, y_m, catalogue)
        figures.append((catalogue.tr("A-scan in the middle"), figure))
    figures += _b_scans(in_time, x_m, y_m, catalogue)
    surface_s = 2.0 * _height_m(survey) / speed_of_light
    if np.isfinite(survey[dataset.HEIGHT]).any():
        delay_ps = surface_s * PS_PER_S
        caption = catalogue.tr("C-scan at the surface, {delay_ps:.0f} ps", delay_ps=delay_ps)
        figures.append((caption, scans.c_scan_figure(in_time, surface_s, catalogue)))
    last_ns = float(in_time[dataset.DELAY][-1]) * NS_PER_S
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
    """Return the data after the steps, the image, and the candidates in it."""
    try:
        processed = apply_steps(survey, steps, _no_other_survey)
    except AnalysisError as error:
        # A survey that cannot be imaged gets a report too, which says why.
        return [_no_image(error, catalogue)]
    views = []
    if dataset.S21 in processed:
        figures = _b_scans(_shown(processed, options), *_middle(processed), catalogue)
        lines = [catalogue.tr("step: {step}", step=_step_text(step)) for step in steps]
        views.append(Section(catalogue.tr("Data after the steps"), lines=lines, figures=figures))
    try:
        image = image_survey(processed, options)
    except AnalysisError as error:
        return [*views, _no_image(error, catalogue)]
    known = sentences_of(survey, NOTES)
    notes = [one for one in sentences_of(image, NOTES) if one not in known]
    return [*views, *_image(image, notes, options, catalogue)]


def _no_image(error: AnalysisError, catalogue: Catalogue) -> Section:
    warning = Message("No image was made: {reason}", reason=error.message)
    return Section(catalogue.text(IMAGE_TITLE), warnings=[shown(warning, catalogue)])


def _image(
    image: xr.Dataset, notes: Sequence[Message], options: ImageOptions, catalogue: Catalogue
) -> List[Section]:
    found = find_candidates(image)
    figures: Pictures = []
    for number, turn in enumerate(image[dataset.POLARIZATION].values):
        caption = catalogue.tr("Maximum projections at {rotation_deg:g} deg", rotation_deg=turn)
        figures.append((caption, scans.projection_figure(image, number, catalogue)))
    slices_m = image[dataset.DEPTH].sel(
        depth=[one.depth_m for one in found.candidates], method="nearest"
    )
    for depth_m in list(dict.fromkeys(slices_m.values.tolist()))[:SLICES]:
        caption = catalogue.tr("Slice at {depth_mm:.1f} mm", depth_mm=depth_m * dataset.MM_PER_M)
        figures.append((caption, scans.c_scan_figure(image, depth_m, catalogue)))
    listed = Section(
        catalogue.tr("Candidates"),
        warnings=[catalogue.text(one) for one in head_sentences(found)],
        lines=[catalogue.text(one) for one in tail_sentences(found)],
        rows=[candidate_row(one, catalogue) for one in found.candidates],
        heading=candidate_heading(catalogue),
    )
    rows = _parameters(image, options, catalogue)
    title, warnings = catalogue.text(IMAGE_TITLE), [shown(one, catalogue) for one in notes]
    return [Section(title, warnings=warnings, rows=rows, figures=figures), listed]


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
    recorded = options.height_m is None
    height = catalogue.tr("as recorded") if recorded else f"{options.height_m:g} m"
    return [
        (catalogue.tr("permittivity"), catalogue.text(permittivity_line(image))),
        (catalogue.tr("depths"), depths),
        (catalogue.tr("method"), options.method.value),
        (catalogue.tr("window"), options.window.value),
        (
            catalogue.tr("widest angle in air"),
            catalogue.tr("{angle_deg:g} deg", angle_deg=options.widest_angle_deg),
        ),
        (catalogue.tr("height"), height),
    ]


def _step_text(step: Step) -> str:
    values = ", ".join(f"{key} {value}" for key, value in step.parameters.items())
    return f"{step.name} ({values})" if values else step.name


def _shown(survey: xr.Dataset, options: ImageOptions) -> xr.Dataset:
    in_time = to_time(survey)
    permittivity = options.permittivity or PERMITTIVITY
    path_m = _height_m(survey) + options.depth_m[-1] * np.sqrt(permittivity)
    last_s = 2.0 * path_m / speed_of_light + MARGIN_S
    some = max(2, int(np.searchsorted(in_time[dataset.DELAY].values, last_s)))
    return in_time.isel({dataset.DELAY: slice(None, some)})


def _height_m(survey: xr.Dataset) -> float:
    heights_m = survey[dataset.HEIGHT].values
    known = np.isfinite(heights_m)
    return float(heights_m[known].max()) if known.any() else HEIGHT_M


def _middle(survey: xr.Dataset) -> Tuple[float, float]:
    x_m, y_m = (float(survey[axis][survey.sizes[axis] // 2]) for axis in (dataset.X, dataset.Y))
    return x_m, y_m


def _b_scans(in_time: xr.Dataset, x_m: float, y_m: float, catalogue: Catalogue) -> Pictures:
    figures: Pictures = []
    for along, at_m in ((dataset.X, y_m), (dataset.Y, x_m)):
        if in_time.sizes[along] > 1:
            figure = scans.b_scan_figure(in_time, along, at_m, catalogue=catalogue)
            figures.append((catalogue.tr("B-scan along {axis}", axis=along), figure))
    return figures


def _no_other_survey(path: str) -> xr.Dataset:
    raise AnalysisError(
        Message("a report cannot subtract another survey, but a step names {path}", path=path)
    )
