"""The image of the real line that is installed with gpr20_analysis."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from gpr20_analysis import load_survey
from gpr20_analysis.commands.main import main
from gpr20_analysis.plotting.projections import candidate_map_figure
from gpr20_analysis.sample import REAL_LINE_FILE

PERMITTIVITY = "6"
DEEPEST_MM = 160.0
SIZE_IN, DPI = (9.0, 3.2), 100


def make(folder: Path) -> None:
    """Image the line by the default command, and mark above it where its bars were published."""
    with tempfile.TemporaryDirectory() as place:
        line, image = (str(Path(place) / name) for name in ("line.nc", "image.nc"))
        main(["sample", "--real", line])
        main(["image", line, "--permittivity", PERMITTIVITY, "-o", image])
        figure = candidate_map_figure(load_survey(image), [])
    figure.set_size_inches(SIZE_IN)
    figure.suptitle(f"Real line over 14 reinforcing bars, permittivity {PERMITTIVITY}")
    axes, bar = figure.axes
    bar.set_ylabel("magnitude [dB]")
    axes.set_title("")
    axes.set_aspect("auto")
    axes.set_ylim(DEEPEST_MM, 0.0)
    with np.load(str(REAL_LINE_FILE)) as file:
        bars_mm = file["rebar_x_m"] * 1000.0
    axes.plot(bars_mm, np.full(len(bars_mm), 8.0), "v", color="white", markeredgecolor="black")
    path = folder / "real_line.png"
    figure.savefig(str(path), dpi=DPI)
    print(path)
