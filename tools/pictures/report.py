"""The first pages of a report of the sample survey."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import List

import pypdfium2
from PIL import Image

from gpr20_analysis import sample_survey
from gpr20_analysis.commands.main import main
from gpr20_common import catalogue

PERMITTIVITY = 5.0
SCALE = 90 / 72


def make(folder: Path) -> None:
    """Write a picture in each language."""
    for language in catalogue.languages():
        with tempfile.TemporaryDirectory() as place:
            report = Path(place) / "report.pdf"
            main(
                [
                    *("report", str(sample_survey()), "-o", str(report)),
                    *("--permittivity", f"{PERMITTIVITY:g}", "--language", language.value),
                ]
            )
            pages = list(pypdfium2.PdfDocument(report))[:2]
            pictures = [page.render(scale=SCALE).to_pil() for page in pages]
        path = folder / f"report_{language.value}.png"
        beside(pictures).save(path)
        print(path)


def beside(pictures: List[Image.Image]) -> Image.Image:
    """Return pictures of the same height beside each other."""
    both = Image.new("RGB", (sum(one.width for one in pictures), pictures[0].height))
    left_px = 0
    for one in pictures:
        both.paste(one, (left_px, 0))
        left_px += one.width
    return both
