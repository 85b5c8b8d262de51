"""The sections of a survey's report, in their order."""

from __future__ import annotations

import datetime
import platform
from importlib import metadata
from pathlib import Path
from typing import Callable, Dict, List, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset
from gpr20_analysis.imaging.image import ImageOptions
from gpr20_analysis.plotting import maps
from gpr20_analysis.processing.chain import Step
from gpr20_analysis.progress import Progress, silent
from gpr20_analysis.read.verification import FILES, Verification, verify_survey
from gpr20_analysis.report import pictures
from gpr20_analysis.report.page import Section, table
from gpr20_analysis.report.summary import SIMULATED, settings_of, summarize

TOLD = 50
LIBRARIES = ("numpy", "scipy", "xarray", "h5py", "matplotlib", "rosbags", "mcap")


def sections_of(
    survey: xr.Dataset,
    path: Path,
    steps: Sequence[Step],
    options: ImageOptions,
    progress: Progress = silent,
) -> List[Section]:
    """Return the sections of a survey's report.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        steps: What is done before imaging.
        options: How the image is made.
        progress: Shows how far it has come.
    """
    found: List[Section] = []
    parts: List[Callable[[], Sequence[Section]]] = [
        lambda: _checked(survey, path),
        lambda: [Section("Survey", rows=table(summarize(survey)))],
        lambda: [Section("How it was measured", rows=settings_of(survey))],
        lambda: [_quality(survey)],
        lambda: [pictures.as_measured(survey, options)],
        lambda: pictures.imaged(survey, steps, options),
        lambda: [Section("Made with", rows=table(versions(survey)))],
    ]
    for part in progress(parts, len(parts)):
        found += [one for one in part() if not one.empty]
    return found


def versions(survey: xr.Dataset) -> Dict[str, str]:
    """Return what the survey was measured and the report was made with."""
    now = datetime.datetime.now(datetime.timezone.utc)
    return {
        "report made": now.isoformat(timespec="seconds"),
        "robot's software": str(survey.attrs.get("software_revision", "not recorded")),
        "gpr20_analysis": __version__,
        "Python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
    }


def _checked(survey: xr.Dataset, path: Path) -> List[Section]:
    """Return verdict and verification: what must be known before anything else."""
    warnings = [SIMULATED] if survey.attrs.get("simulated") else []
    size, absent = survey[dataset.QUALITY].size, len(dataset.missing_samples(survey))
    if absent:
        warnings.append(
            f"{absent} of {size} samples have no numbers: the ground below them was NOT searched"
        )
    good = [] if absent else [f"every one of the {size} samples of the grid is there"]
    if not path.is_dir() or not any((path / name).exists() for name in FILES):
        lines = ["Only the folder of a survey can be verified against its plan and checksums."]
        return [Section("Verdict", warnings, [*good, *lines])]
    found = verify_survey(path)
    (warnings if found.status else good).append(found.verdict)
    return [Section("Verdict", warnings, good), _verification(found)]


def _verification(found: Verification) -> Section:
    more = len(found.faults) - TOLD
    warnings = found.faults[:TOLD] + ([f"and {more} more"] if more > 0 else [])
    return Section("Verification", warnings, found.notes)


def _quality(survey: xr.Dataset) -> Section:
    warnings = [f"DAMAGED: {one}" for one in survey.attrs.get("faults", [])[:TOLD]]
    absent = dataset.missing_samples(survey)
    warnings += absent[:TOLD] + ([f"and {len(absent) - TOLD} more"] if len(absent) > TOLD else [])
    remarks = survey["remarks"].values if "remarks" in survey else np.array([])
    lines = [f"note: {one}" for one in survey.attrs.get("notes", [])]
    lines += [
        f"remark of the robot on {np.count_nonzero(remarks == one)} samples: {one}"
        for one in sorted(set(remarks.ravel()))
        if one
    ]
    figures = [("Coverage", maps.coverage_figure(survey))]
    if np.isfinite(survey[dataset.HEIGHT]).any():
        figures.append(("Antenna height above the ground", maps.height_figure(survey)))
    rows: List[Tuple[str, ...]] = [
        (f"{turn:g} deg", f"{int(own.sum())} of {own.size} samples usable")
        for turn, own in zip(survey[dataset.POLARIZATION].values, dataset.usable(survey).values)
    ]
    return Section("Coverage and quality", warnings, lines, rows, figures=figures)
