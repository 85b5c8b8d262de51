"""The places of a survey and its figures, for the report."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, List, Optional, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import dataset, faults
from gpr20_analysis.candidates.answer import Answer, answer
from gpr20_analysis.candidates.table import candidate_table, places_sentence, weaker_sentence
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import Method
from gpr20_analysis.plotting import projections, scans
from gpr20_analysis.plotting.hiding import hiding_figure
from gpr20_analysis.plotting.ranges import last_delay_s, surface_delay_s, until
from gpr20_analysis.processing.chain import Step, apply_steps
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.report.page import Section
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.mid.checks import with_unit
from gpr20_survey.results.candidates import NO_CLEARANCE, SIMULATED
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLICES = 3
NS_PER_S, PS_PER_S = 1e9, 1e12
# Of the figures, where the survey's steps are longer.
FINE_STEP_M, MOST_VOXELS = 0.005, 4_000_000

Pictures = List[Tuple[str, "Figure"]]


def answered(
    survey: xr.Dataset, steps: Sequence[Step], options: ImageOptions
) -> Tuple[Optional[Answer], Optional[AnalysisError]]:
    """Return what a survey shows after steps, or why there is no image.

    A survey that cannot be imaged gets a report too, which says why.
    """
    try:
        return answer(apply_steps(survey, steps, _no_other_survey), options), None
    except AnalysisError as error:
        return None, error


def places_section(
    found: Optional[Answer], error: Optional[AnalysisError], options: ImageOptions,
    catalogue: Catalogue,
) -> Section:  # fmt: skip
    """Return how many places there are to check, and where, or why that is not known."""
    title, notice = catalogue.tr("Places to check"), catalogue.text(NO_CLEARANCE)
    if found is None:
        reason = "" if error is None else error.message
        warning = Message("No image was made: {reason}", reason=reason)
        return Section(title, notice, [shown(warning, catalogue)])
    listed = found.found
    image = _finer(found.processed, found.image, options)
    figure = projections.candidate_map_figure(image, listed.shown(), catalogue)
    heading, *rows = candidate_table(listed, listed.candidates, catalogue)
    places, weaker = rows[: listed.primary], rows[listed.primary :]
    title = catalogue.tr("Places to check: {count}", count=listed.primary)
    return Section(
        title,
        notice,
        lines=[catalogue.text(places_sentence(listed))],
        rows=places,
        heading=heading,
        more=(catalogue.text(weaker_sentence(listed)), weaker) if weaker else ("", ()),
        figures=[(catalogue.tr("Map of the places to check"), figure)],
        figures_first=True,
    )


def missed_section(
    survey: xr.Dataset, hiding: Optional[HidingMap], catalogue: Catalogue
) -> Section:
    """Return what could have been missed: ground without data, and the map of what can hide."""
    section = Section(catalogue.tr("What could have been missed"))
    size, absent = survey[dataset.QUALITY].size, len(dataset.missing_samples(survey))
    if absent:
        section.warnings.append(
            catalogue.tr(
                "{count} of {total} samples have no data: the ground below them was NOT searched",
                count=absent,
                total=size,
            )
        )
    else:
        section.lines.append(catalogue.tr("All {total} samples of the grid have data.", total=size))
    if hiding is None:
        section.lines.append(
            catalogue.tr(
                "There is no map of where a mine could hide: make one with gpr20 hiding, and give "
                "it with --hiding. What this radar does not see is on no list."
            )
        )
        return section
    section.notice = catalogue.text(ONLY_THIS)
    left_out = (ONLY_THIS, SIMULATED)
    section.lines += [shown(one, catalogue) for one in hiding.sentences if one not in left_out]
    title = catalogue.tr("Where could a mine hide?")
    section.figures.append((title, hiding_figure(hiding, catalogue)))
    return section


def image_section(found: Answer, options: ImageOptions, catalogue: Catalogue) -> Section:
    """Return the image and how it was made."""
    figures: Pictures = []
    image, places = _finer(found.processed, found.image, options), found.found.shown()
    for number, turn in enumerate(image[dataset.POLARIZATION].values):
        caption = catalogue.tr("Maximum projections at {rotation_deg:g} deg", rotation_deg=turn)
        figure = projections.projection_figure(image, number, places, catalogue)
        figures.append((caption, figure))
    depths_m = [] if dataset.is_line(image) else [one.depth_m for one in places]
    slices_m = image[dataset.DEPTH].sel(depth=depths_m, method="nearest")
    # Some are at one depth.
    for depth_m in list(dict.fromkeys(slices_m.values.tolist()))[:SLICES]:
        caption = catalogue.tr("Slice at {depth_mm:.1f} mm", depth_mm=depth_m * dataset.MM_PER_M)
        figures.append((caption, scans.c_scan_figure(image, depth_m, catalogue)))
    depths_mm = image[dataset.DEPTH].values * dataset.MM_PER_M
    depths = catalogue.tr(
        "{count} from {first_mm:.1f} to {last_mm:.1f} mm",
        count=len(depths_mm),
        first_mm=depths_mm[0],
        last_mm=depths_mm[-1],
    )
    height_m = options.height_m
    height = Message("as recorded") if height_m is None else with_unit(height_m, "m")
    rows = [
        (catalogue.tr("depths"), depths),
        (catalogue.tr("method"), options.method.name),
        (catalogue.tr("height"), catalogue.text(height)),
    ]
    return Section(catalogue.tr("Image of the ground"), rows=rows, figures=figures)


def measured_section(survey: xr.Dataset, options: ImageOptions, catalogue: Catalogue) -> Section:
    """Return A-, B- and C-scans before any processing."""
    in_time, last_s = to_time(survey), last_delay_s(survey, options.depth_m[-1])
    x_m, y_m = _middle(survey)
    figures: Pictures = []
    if dataset.usable(survey).sel(x=x_m, y=y_m).values.any():
        figure = scans.a_scan_figure(in_time, x_m, y_m, last_s, catalogue)
        figures.append((catalogue.tr("A-scan in the middle"), figure))
    figures += _b_scans(in_time, last_s, options.permittivity, catalogue)
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


def processed_section(
    found: Answer, steps: Sequence[Step], options: ImageOptions, catalogue: Catalogue
) -> Section:
    """Return the data from which the image was made."""
    permittivity = float(found.image.attrs["permittivity"])
    last_s = last_delay_s(found.processed, options.depth_m[-1], permittivity)
    figures = _b_scans(to_time(found.processed), last_s, permittivity, catalogue)
    lines = [catalogue.tr("step: {step}", step=_step_text(step)) for step in steps]
    return Section(catalogue.tr("Data after the steps"), lines=lines, figures=figures)


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


def _step_text(step: Step) -> str:
    values = ", ".join(f"{key} {value}" for key, value in step.parameters.items())
    return f"{step.name} ({values})" if values else step.name


def _middle(survey: xr.Dataset) -> Tuple[float, float]:
    x_m, y_m = (float(survey[axis][survey.sizes[axis] // 2]) for axis in (dataset.X, dataset.Y))
    return x_m, y_m


def _b_scans(
    in_time: xr.Dataset, last_s: float, permittivity: Optional[float], catalogue: Catalogue
) -> Pictures:
    figures: Pictures = []
    x_m, y_m = _middle(in_time)
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
