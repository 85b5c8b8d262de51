"""The first page and the map of a report of the sample survey."""

from __future__ import annotations

import io
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.image import imread

from gpr20_analysis import ImageOptions, load_survey, sample_survey
from gpr20_analysis.imaging.methods import DEFAULT_STEPS
from gpr20_analysis.processing.chain import step_from_text
from gpr20_analysis.report.build import report_of
from gpr20_analysis.report.pdf_pages import pages_of
from gpr20_common.low import catalogue_file
from gpr20_common.low.catalogue_file import read_catalogue

PERMITTIVITY = 5.0
RESOLUTION_DPI = 90


def make(folder: Path) -> None:
    """Write a picture in each language."""
    survey = load_survey(sample_survey())
    steps = [step_from_text(DEFAULT_STEPS[0])]
    for language in catalogue_file.languages():
        catalogue = read_catalogue(language)
        options = ImageOptions(permittivity=PERMITTIVITY)
        report = report_of(survey, sample_survey(), steps, options, language, catalogue)
        pages = pages_of(report, catalogue)
        first = next(pages)
        figure = next(page for page in pages if page.axes)
        path = folder / f"report_{language.value}.png"
        beside(first, figure).savefig(path, dpi=RESOLUTION_DPI)
        print(path)


def beside(left: Figure, right: Figure) -> Figure:
    """Return a picture of two pages beside each other."""
    pictures = []
    for page in (left, right):
        stream = io.BytesIO()
        page.savefig(stream, format="png", dpi=RESOLUTION_DPI)
        stream.seek(0)
        pictures.append(imread(stream))
    heights, widths = zip(*(one.shape[:2] for one in pictures))
    both = Figure(figsize=(sum(widths) / RESOLUTION_DPI, max(heights) / RESOLUTION_DPI))
    left_px = 0
    for picture, height, width in zip(pictures, heights, widths):
        both.figimage(picture, xo=left_px, yo=max(heights) - height)
        left_px += width
    return both
