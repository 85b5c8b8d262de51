"""The views of a survey and its image, for the report."""

from __future__ import annotations

from typing import TYPE_CHECKING, List, Sequence, Tuple

import numpy as np
import xarray as xr
from scipy.constants import speed_of_light

from gpr20_analysis import dataset
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.echoes import Echo, find_echoes
from gpr20_analysis.imaging.image import ImageOptions, image_survey
from gpr20_analysis.imaging.image_output import doubtful_echoes, permittivity_line
from gpr20_analysis.plotting import scans
from gpr20_analysis.processing.chain import Step, apply_steps
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.report.page import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLICES = 3
NS_PER_S, PS_PER_S = 1e9, 1e12
# Shown beyond the deepest layer of the image, and where heights or permittivity are not known.
MARGIN_S, HEIGHT_M, PERMITTIVITY = 1e-9, 0.3, 9.0
IMAGE_TITLE = "Image of the ground"
ECHO_HEADING = (
    "polarization",
    "x mm",
    "y mm",
    "depth mm",
    "level dB",
    "above noise dB",
    "-3 dB width x, y, depth mm",
)

Pictures = List[Tuple[str, "Figure"]]


def as_measured(survey: xr.Dataset, options: ImageOptions) -> Section:
    """Return A-, B- and C-scans before any processing."""
    in_time = _shown(survey, options)
    x_m, y_m = _middle(survey)
    figures: Pictures = []
    if dataset.usable(survey).sel(x=x_m, y=y_m).values.any():
        figures.append(("A-scan in the middle", scans.a_scan_figure(in_time, x_m, y_m)))
    figures += _b_scans(in_time, x_m, y_m)
    surface_s = 2.0 * _height_m(survey) / speed_of_light
    if np.isfinite(survey[dataset.HEIGHT]).any():
        caption = f"C-scan at the surface, {surface_s * PS_PER_S:.0f} ps"
        figures.append((caption, scans.c_scan_figure(in_time, surface_s)))
    last_ns = float(in_time[dataset.DELAY][-1]) * NS_PER_S
    line = f"Delays up to {last_ns:.1f} ns are shown, a little more than the image reaches."
    return Section("Data as measured", lines=[line], figures=figures)


def imaged(
    survey: xr.Dataset,
    steps: Sequence[Step],
    options: ImageOptions,
) -> List[Section]:
    """Return the data after the steps, the image, and the echoes in it."""
    try:
        processed = apply_steps(survey, steps, _no_other_survey)
    except AnalysisError as error:
        # The report of a survey that cannot be imaged is wanted all the more.
        return [Section(IMAGE_TITLE, warnings=[f"No image was made: {error}"])]
    views = []
    if dataset.S21 in processed:
        figures = _b_scans(_shown(processed, options), *_middle(processed))
        lines = [f"step: {_told(step)}" for step in steps]
        views.append(Section("Data after the steps", lines=lines, figures=figures))
    try:
        image = image_survey(processed, options)
    except AnalysisError as error:
        return [*views, Section(IMAGE_TITLE, warnings=[f"No image was made: {error}"])]
    return [*views, *_image(image, options)]


def _image(image: xr.Dataset, options: ImageOptions) -> List[Section]:
    echoes = find_echoes(image)
    figures: Pictures = [
        (f"Maximum projections at {turn:g} deg", scans.projection_figure(image, number))
        for number, turn in enumerate(image[dataset.POLARIZATION].values)
    ]
    slices_m = image[dataset.DEPTH].sel(depth=[one.depth_m for one in echoes], method="nearest")
    # Echoes of both polarizations are mostly at one depth.
    for depth_m in list(dict.fromkeys(slices_m.values.tolist()))[:SLICES]:
        figures.append((f"Slice at {_mm(depth_m)} mm", scans.c_scan_figure(image, depth_m)))
    depths = image[dataset.DEPTH].values
    rows = [
        ("permittivity", permittivity_line(image)),
        ("depths", f"{len(depths)} from {_mm(depths[0])} to {_mm(depths[-1])} mm"),
        ("method", options.method.value),
        ("window", options.window.value),
        ("widest angle in air", f"{options.widest_angle_deg:g} deg"),
        ("height", "as recorded" if options.height_m is None else f"{options.height_m:g} m"),
    ]
    lines = doubtful_echoes(echoes) if echoes else ["No echo stands out."]
    listed = Section("Echoes", lines=lines, heading=ECHO_HEADING)
    listed.rows = [_row(echo) for echo in echoes]
    return [Section(IMAGE_TITLE, rows=rows, figures=figures), listed]


def _row(echo: Echo) -> Tuple[str, ...]:
    widths = (echo.width_x_m, echo.width_y_m, echo.width_depth_m)
    turn_deg = echo.polarization_deg
    return (
        "combined" if np.isnan(turn_deg) else f"{turn_deg:g} deg",
        *(_mm(one) for one in (echo.x_m, echo.y_m, echo.depth_m)),
        f"{echo.level_db:.1f}",
        f"{echo.above_noise_db:.1f}",
        ", ".join(_mm(one) for one in widths),
    )


def _mm(value_m: float) -> str:
    return f"{value_m * dataset.MM_PER_M:.1f}"


def _told(step: Step) -> str:
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


def _b_scans(in_time: xr.Dataset, x_m: float, y_m: float) -> Pictures:
    figures: Pictures = []
    for along, at_m in ((dataset.X, y_m), (dataset.Y, x_m)):
        if in_time.sizes[along] > 1:
            figure = scans.b_scan_figure(in_time, along, at_m)
            figures.append((f"B-scan along {along}", figure))
    return figures


def _no_other_survey(path: str) -> xr.Dataset:
    raise AnalysisError(f"a report subtracts no other survey, but a step names {path}")
