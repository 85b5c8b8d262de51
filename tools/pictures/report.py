"""The first page of a report of the sample survey."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

from gpr20_analysis import sample_survey
from gpr20_analysis.commands.main import main
from gpr20_common import catalogue

PERMITTIVITY = 5.0
SIZE_PX = (1100, 1500)
LIMIT_S = 120.0


def make(folder: Path) -> None:
    """Write a picture in each language."""
    for language in catalogue.languages():
        with tempfile.TemporaryDirectory() as place:
            report = Path(place) / "report.html"
            main(
                [
                    *("report", str(sample_survey()), "-o", str(report)),
                    *("--permittivity", f"{PERMITTIVITY:g}", "--language", language.value),
                ]
            )
            photograph(report, folder / f"report_{language.value}.png")


def photograph(page: Path, picture: Path) -> None:
    """Take a picture of the top of a page, by a browser."""
    width, height = SIZE_PX
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
    command = ["chromium", *options, f"--window-size={width},{height}",
               f"--screenshot={picture.resolve()}", page.resolve().as_uri()]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=LIMIT_S)
    print(picture)
