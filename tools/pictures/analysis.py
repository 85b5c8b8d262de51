"""Pictures of the sample survey and of the real line, by the commands that the pages show."""

from __future__ import annotations

import io
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from gpr20_analysis import (
    ImageOptions,
    find_candidates,
    image_survey,
    load_survey,
    process_survey,
    sample_survey,
)
from gpr20_analysis.commands.main import main
from gpr20_analysis.plotting.projections import candidate_map_figure
from gpr20_analysis.sample import REAL_LINE_FILE
from gpr20_common import catalogue

# Of the simulated soil of the sample, and of the concrete of the real line.
PERMITTIVITY, REAL_PERMITTIVITY = "5", "6"
FEWEST_LINES, FRAME_MS, PAUSE_MS = 3, 250, 3500
DEEPEST_MM = 160.0
REPORT_PX, BROWSER_LIMIT_S = (1100, 1500), 120.0


def animation(folder: Path) -> None:
    """Show how the image grows with each line, and the places to check at the end."""
    survey = process_survey(load_survey(sample_survey()), "background:method=surface")
    options = ImageOptions(permittivity=float(PERMITTIVITY))
    y_mm, frames = 1000.0 * survey.y.values, []
    for lines in range(FEWEST_LINES, len(y_mm) + 1):
        image = image_survey(survey.isel(y=slice(0, lines)), options)
        found = find_candidates(image).candidates if lines == len(y_mm) else ()
        figure = candidate_map_figure(image, [one for one in found if not one.is_doubtful])
        # Of one size and scale, however many lines there are.
        figure.set_size_inches(6.0, 5.0)
        figure.axes[0].set_ylim(y_mm[-1], y_mm[0])
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=70)
        frames.append(Image.open(stream).convert("RGB"))
    times_ms = [FRAME_MS] * (len(frames) - 1) + [PAUSE_MS]
    path = folder / "survey.webp"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=times_ms, loop=0)
    print(path)


def real_line(folder: Path) -> None:
    """Image the line by the default command, and mark above it where its bars were published."""
    with tempfile.TemporaryDirectory() as place:
        line, image = (str(Path(place) / name) for name in ("line.nc", "image.nc"))
        _run("sample", "--real", line)
        _run("image", line, "--permittivity", REAL_PERMITTIVITY, "-o", image)
        figure = candidate_map_figure(load_survey(image), [])
    figure.set_size_inches(9.0, 3.2)
    figure.suptitle(f"Real line over 14 reinforcing bars, permittivity {REAL_PERMITTIVITY}")
    axes = figure.axes[0]
    axes.set_aspect("auto")
    axes.set_ylim(DEEPEST_MM, 0.0)
    with np.load(str(REAL_LINE_FILE)) as file:
        bars_mm = file["rebar_x_m"] * 1000.0
    axes.plot(bars_mm, np.full(len(bars_mm), 8.0), "v", color="white", markeredgecolor="black")
    path = folder / "real_line.png"
    figure.savefig(str(path), dpi=100)
    print(path)


def hiding(folder: Path) -> None:
    """Draw the map of where a mine could hide."""
    options = ("--permittivity", PERMITTIVITY, "--rounds", "24")
    _run("hiding", str(sample_survey()), *options, "-o", str(folder / "hiding.png"))


def report(folder: Path) -> None:
    """Take a picture of the top of a report in each language, by a browser."""
    width, height = REPORT_PX
    for language in catalogue.languages():
        picture = folder / f"report_{language.value}.png"
        with tempfile.TemporaryDirectory() as place:
            page = Path(place) / "report.html"
            options = ("--permittivity", PERMITTIVITY, "--language", language.value)
            _run("report", str(sample_survey()), "-o", str(page), *options)
            browser = ["chromium", "--headless", "--no-sandbox", "--disable-gpu"]
            browser += ["--hide-scrollbars", f"--window-size={width},{height}"]
            browser += [f"--screenshot={picture}", page.as_uri()]
            subprocess.run(browser, check=True, capture_output=True, timeout=BROWSER_LIMIT_S)
        print(picture)


def _run(*arguments: str) -> None:
    if main([*arguments]):
        raise SystemExit(f"gpr20 {arguments[0]} has failed")
