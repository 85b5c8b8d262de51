"""What a report tells of a survey."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import Dict, List, Sequence

import numpy as np
import scipy
import xarray as xr

from gpr20_analysis import __version__
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.mid import dataset
from gpr20_analysis.mid.imaging.echoes import find_echoes
from gpr20_analysis.mid.imaging.image import ImageOptions, image_survey
from gpr20_analysis.mid.imaging.image_output import echo_lines, permittivity_line
from gpr20_analysis.mid.imaging.refraction import SPEED_OF_LIGHT_M_S
from gpr20_analysis.mid.plotting import maps, scans
from gpr20_analysis.mid.processing.chain import Step, apply_steps
from gpr20_analysis.mid.processing.delay import to_time
from gpr20_analysis.mid.report.page import Section, table
from gpr20_analysis.mid.survey_facts import SIMULATED, facts
from gpr20_analysis.mid.verification import FILES, verify

TOLD = 50
SLICES = 3
PS_PER_S = 1e12


def sections_of(
    survey: xr.Dataset, path: Path, steps: Sequence[Step], options: ImageOptions
) -> List[Section]:
    """Return the sections of a survey's report.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        steps: What is done before imaging.
        options: How the image is made.
    """
    return [
        _summary(survey),
        _verification(path),
        _quality(survey),
        _views(survey),
        _image(survey, steps, options),
        Section("Versions", rows=table(versions())),
    ]


def versions() -> Dict[str, str]:
    """Return what the report was made with."""
    return {
        "gpr20_analysis": __version__,
        "Python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "xarray": xr.__version__,
    }


def _summary(survey: xr.Dataset) -> Section:
    warnings = [SIMULATED] if survey.attrs.get("simulated") else []
    absent = len(dataset.missing_samples(survey))
    if absent:
        warnings.append(
            f"{absent} of {survey[dataset.QUALITY].size} samples have no numbers: the ground "
            "below them was NOT searched"
        )
    return Section("Survey", warnings=warnings, rows=table(facts(survey)))


def _verification(path: Path) -> Section:
    if not path.is_dir() or not any((path / name).exists() for name in FILES):
        return Section("Verification", lines=["Only the folder of a survey can be verified."])
    found = verify(path)
    warnings = [found.verdict] if found.status else []
    return Section(
        "Verification",
        warnings=warnings + found.faults[:TOLD],
        lines=([] if warnings else [found.verdict]) + found.notes,
    )


def _quality(survey: xr.Dataset) -> Section:
    warnings = [f"DAMAGED: {one}" for one in survey.attrs.get("faults", [])[:TOLD]]
    warnings += dataset.missing_samples(survey)[:TOLD]
    remarks = survey["remarks"].values if "remarks" in survey else np.array([])
    lines = [f"note: {one}" for one in survey.attrs.get("notes", [])]
    lines += [f"remark of the robot: {one}" for one in sorted(set(remarks.ravel())) if one]
    figures = [("Coverage", maps.coverage_figure(survey))]
    if np.isfinite(survey[dataset.HEIGHT]).any():
        figures.append(("Antenna height", maps.height_figure(survey)))
    return Section("Coverage and quality", warnings, lines, figures=figures)


def _views(survey: xr.Dataset) -> Section:
    in_time = to_time(survey)
    x_m, y_m = (float(survey[axis][survey.sizes[axis] // 2]) for axis in (dataset.X, dataset.Y))
    usable = dataset.usable(survey).sel(x=x_m, y=y_m).values.any()
    figures = []
    if usable:
        figures.append(("A-scan in the middle", scans.a_scan_figure(in_time, x_m, y_m)))
    figures.append(("B-scan along x", scans.b_scan_figure(in_time, dataset.X, y_m)))
    figures.append(("B-scan along y", scans.b_scan_figure(in_time, dataset.Y, x_m)))
    heights = survey[dataset.HEIGHT].values
    if np.isfinite(heights).any():
        surface_s = 2.0 * float(np.nanmean(heights)) / SPEED_OF_LIGHT_M_S
        caption = f"C-scan at the surface, {surface_s * PS_PER_S:.0f} ps"
        figures.append((caption, scans.c_scan_figure(in_time, surface_s)))
    return Section("Data as measured", figures=figures)


def _image(survey: xr.Dataset, steps: Sequence[Step], options: ImageOptions) -> Section:
    title = "Image of the ground"
    try:
        image = image_survey(apply_steps(survey, steps, _no_other_survey), options)
    except AnalysisError as error:
        # The report of a survey that cannot be imaged is wanted all the more.
        return Section(title, warnings=[f"No image was made: {error}"])
    echoes = find_echoes(image)
    figures = [
        (f"Maximum projections at {turn:g} deg", scans.projection_figure(image, number))
        for number, turn in enumerate(image[dataset.POLARIZATION].values)
    ]
    figures += [
        (
            f"Slice at {echo.depth_m * dataset.MM_PER_M:.0f} mm",
            scans.c_scan_figure(image, echo.depth_m),
        )
        for echo in echoes[:SLICES]
    ]
    lines = [permittivity_line(image), *(echo_lines(echoes) if echoes else ["no echo stands out"])]
    lines += [f"step: {step}" for step in steps]
    lines.append(f"method: {image.attrs['method']}")
    return Section(title, lines=lines, figures=figures)


def _no_other_survey(path: str) -> xr.Dataset:
    raise AnalysisError(f"a report subtracts no other survey, but a step names {path}")


def _slice_name(depth_m: float) -> str:
    return f"Slice at a depth of {depth_m * dataset.MM_PER_M:.0f} mm"
