"""A whole report of a survey, whatever its format."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Optional, Sequence

import xarray as xr

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.errors import ExportError, wrong_ending
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.processing.chain import Step, step_from_text
from gpr20_analysis.report.page import page
from gpr20_analysis.report.records import Report
from gpr20_analysis.report.sections import sections_of
from gpr20_analysis.report.summary import SIMULATED
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.catalogue import Catalogue, Language, language_from_code, read_catalogue
from gpr20_survey.results.candidates import NO_CLEARANCE
from gpr20_survey.results.hiding_map import HidingMap

HTML, PDF = ".html", ".pdf"


def write_report(
    survey: xr.Dataset,
    path: Path,
    output: Path,
    options: Optional[ImageOptions] = None,
    steps: Sequence[Step] = (),
    language: str = Language.ENGLISH.value,
    progress: Progress = no_progress,
    hiding: Optional[HidingMap] = None,
) -> None:
    """Write a report, a page or a PDF.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        output: The file: .html or .pdf.
        options: How the image is made.
        steps: The steps before imaging; without any, coupling and surface echo are subtracted.
        language: Code of the language.
        progress: Shows the progress.
        hiding: Where a mine could hide; None: the report has no such map.

    Raises:
        AnalysisError: The file has another ending or cannot be written.
    """
    check_report_path(output)
    known = language_from_code(language)
    catalogue = read_catalogue(known)
    chosen = list(steps) or [step_from_text(one) for one in DEFAULT_STEPS]
    image_options = options or ImageOptions()
    made = report_of(survey, path, chosen, image_options, known, catalogue, progress, hiding)
    save_report(made, output, catalogue)


def save_report(made: Report, output: Path, catalogue: Catalogue) -> None:
    """Write a report as its ending says, in the language of a catalogue.

    Raises:
        AnalysisError: It cannot be written.
    """
    with atomic_output(output) as place:
        if output.suffix == PDF:
            from gpr20_analysis.report.pdf import write_pdf  # its library is optional

            write_pdf(place, made, catalogue)
        else:
            place.write_text(page(made), encoding="utf-8")


def check_report_path(output: Path) -> None:
    """Check the ending of a report's file, and that what writes it is installed.

    Raises:
        ExportError: It is another one.
        ModuleNotFoundError: A library is missing.
    """
    if output.suffix not in (HTML, PDF):
        raise ExportError(wrong_ending(output, (HTML, PDF)))
    if output.suffix == PDF:
        importlib.import_module("gpr20_analysis.report.pdf")


def report_of(
    survey: xr.Dataset,
    path: Path,
    steps: Sequence[Step],
    options: ImageOptions,
    language: Language,
    catalogue: Catalogue,
    progress: Progress = no_progress,
    hiding: Optional[HidingMap] = None,
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
        hiding: Where a mine could hide.
    """
    name = survey.attrs.get("survey_id", survey.attrs.get("source", ""))
    simulated = bool(survey.attrs.get("simulated"))
    return Report(
        title=catalogue.tr("GPR-20 survey {name}", name=name),
        sections=sections_of(survey, path, steps, options, progress, catalogue, hiding),
        language=language,
        mark=catalogue.tr("SIMULATED") if simulated else "",
        banner=catalogue.text(SIMULATED) if simulated else "",
        footer=catalogue.text(NO_CLEARANCE),
    )
