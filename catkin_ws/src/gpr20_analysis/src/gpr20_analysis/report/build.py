"""A whole report of a survey, whatever its format."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import xarray as xr

from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.chain import Step
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.report.records import Report
from gpr20_analysis.report.sections import sections_of
from gpr20_analysis.report.summary import SIMULATED
from gpr20_common.catalogue import Catalogue, Language
from gpr20_survey.no_clearance import NO_CLEARANCE


def report_of(
    survey: xr.Dataset,
    path: Path,
    steps: Sequence[Step],
    options: ImageOptions,
    language: Language,
    catalogue: Catalogue,
    progress: Progress = no_progress,
) -> Report:
    """Return the report of a survey.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        steps: The steps before imaging.
        options: How the image is made.
        language: Language of the report.
        catalogue: Its catalogue.
        progress: Shows the progress.

    Returns:
        The report.
    """
    name = survey.attrs.get("survey_id", survey.attrs.get("source", ""))
    simulated = bool(survey.attrs.get("simulated"))
    return Report(
        title=catalogue.tr("GPR-20 survey {name}", name=name),
        sections=sections_of(survey, path, steps, options, progress, catalogue),
        language=language,
        mark=catalogue.tr("SIMULATED") if simulated else "",
        banner=catalogue.text(SIMULATED) if simulated else "",
        footer=catalogue.text(NO_CLEARANCE),
    )
