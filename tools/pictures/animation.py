"""The animation of the README: the sample survey, from the first stop to the image."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Iterator, List

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from PIL import Image

from gpr20_analysis import (
    Candidate,
    ImageOptions,
    find_candidates,
    image_survey,
    load_survey,
    process_survey,
    sample_survey,
    to_time,
)

# Of the simulated soil of the sample.
PERMITTIVITY = 5.0
STEPS_PER_LINE = 3
FEWEST_LINES = 3
SIZE_PX = (960, 380)
DPI = 100
FRAME_MS, PAUSE_MS = 90, 3500
DYNAMIC_DB = 30.0
EARLIEST_NS, LATEST_NS = 1.0, 5.0
TEAL, ORANGE = "#00796b", "#ff8f00"


def make(folder: Path) -> None:
    """Write the animation."""
    frames = [frame(figure) for figure in figures()]
    times = [FRAME_MS] * (len(frames) - 1) + [PAUSE_MS]
    first, *others = frames
    path = folder / "survey.webp"
    first.save(
        path, save_all=True, append_images=others, duration=times, loop=0, quality=70, method=6
    )
    print(f"{path}: {len(frames)} frames, {path.stat().st_size / 1e3:.0f} kB")


def frame(figure: Figure) -> Image.Image:
    """Return a figure as an image of pixels."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DPI)
    stream.seek(0)
    return Image.open(stream).convert("RGB")


def figures() -> Iterator[Figure]:
    """Yield the frames: three for each line, and a last one with the candidates."""
    survey = load_survey(sample_survey())
    cleaned = process_survey(survey, "background:method=surface")
    a_scans = to_time(cleaned).isel(polarization=0)
    whole = image_survey(cleaned, ImageOptions(permittivity=PERMITTIVITY))
    bodies = [one for one in find_candidates(whole).candidates if not one.is_doubtful]
    lines, stops = survey.sizes["y"], survey.sizes["x"]
    brightest = float(np.abs(whole.image).max())
    picture = None
    for line in range(lines):
        for part in range(1, STEPS_PER_LINE + 1):
            measured = round(part * stops / STEPS_PER_LINE)
            yield drawn(survey, a_scans, picture, line, measured, brightest, [])
        if line + 1 >= FEWEST_LINES:
            part_of_survey = cleaned.isel(y=slice(0, line + 1))
            picture = image_survey(part_of_survey, ImageOptions(permittivity=PERMITTIVITY))
    yield drawn(survey, a_scans, picture, lines - 1, stops, brightest, bodies)


def drawn(
    survey: xr.Dataset,
    a_scans: xr.Dataset,
    picture: Any,
    line: int,
    measured: int,
    brightest: float,
    bodies: List[Candidate],
) -> Figure:
    """Return one frame, with a number of stops of a line measured."""
    figure = Figure(figsize=(SIZE_PX[0] / DPI, SIZE_PX[1] / DPI), facecolor="white")
    robot, traces, image = figure.subplots(1, 3)
    x_mm, y_mm = survey.x.values * 1e3, survey.y.values * 1e3
    # Every second line is measured backwards.
    order = np.arange(x_mm.size) if line % 2 == 0 else np.arange(x_mm.size)[::-1]
    here = order[:measured]
    _draw_robot(robot, x_mm, y_mm, line, here)
    _draw_traces(traces, a_scans.isel(y=line), float(np.abs(a_scans.a_scan).max()), here)
    _draw_image(image, picture, (x_mm, y_mm), brightest, bodies)
    figure.subplots_adjust(left=0.06, right=0.98, bottom=0.15, top=0.87, wspace=0.32)
    return figure


def _draw_robot(axes: Axes, x_mm: Any, y_mm: Any, line: int, here: Any) -> None:
    axes.set_title("The robot measures", fontsize=11)
    done_x, done_y = np.meshgrid(x_mm, y_mm[:line])
    axes.plot(done_x.ravel(), done_y.ravel(), ".", color=TEAL, markersize=4)
    axes.plot(x_mm[here], np.full(here.size, y_mm[line]), ".", color=TEAL, markersize=4)
    x, y = x_mm[here[-1]], y_mm[line]
    axes.axhspan(y - 7, y + 7, color="#b0bec5", zorder=0)
    axes.add_patch(Rectangle((x - 20, y - 20), 40, 40, color=ORANGE, zorder=3))
    _frame(axes, x_mm, y_mm)


def _draw_traces(axes: Axes, line: xr.Dataset, brightest: float, here: Any) -> None:
    axes.set_title("Traces arrive", fontsize=11)
    x_mm, delays_ns = line.x.values * 1e3, line.delay.values * 1e9
    levels = 20 * np.log10(np.abs(line.a_scan.transpose("delay", "x").values) / brightest)
    shown = np.full(levels.shape, np.nan)
    shown[:, here] = levels[:, here]
    near = (delays_ns >= EARLIEST_NS) & (delays_ns <= LATEST_NS)
    _show(axes, shown[near], x_mm, delays_ns[near])
    axes.set_aspect("auto")
    axes.set_box_aspect(1)
    axes.set_xlim(x_mm[0] - 20, x_mm[-1] + 20)
    axes.set_ylim(LATEST_NS, EARLIEST_NS)
    axes.set_xlabel("x [mm]", fontsize=9)
    axes.set_ylabel("delay [ns]", fontsize=9)
    axes.tick_params(labelsize=8)


def _draw_image(
    axes: Axes, picture: Any, places_mm: Any, brightest: float, bodies: List[Candidate]
) -> None:
    axes.set_title("The image shows the targets", fontsize=11)
    if picture is not None:
        values = np.abs(picture.image).max(["depth", "polarization"])
        levels = 20 * np.log10(values / brightest)
        _show(axes, levels.transpose("y", "x"), picture.x * 1e3, picture.y * 1e3)
    for body in bodies:
        x, y = body.x_m * 1e3, body.y_m * 1e3
        axes.plot(x, y, "o", markersize=20, markerfacecolor="none", markeredgecolor="#00e5ff")
        words = f"{body.depth_m * 1e3:.0f} mm deep"
        axes.annotate(
            words, (x, y - 28), color="#00e5ff", fontsize=9, ha="center", fontweight="bold"
        )
    _frame(axes, *places_mm)


def _show(axes: Axes, levels_db: Any, x: Any, y: Any) -> None:
    """Show levels below the brightest one; each value is in the middle of its place."""
    half_x, half_y = float(x[1] - x[0]) / 2, float(y[1] - y[0]) / 2
    edges = (float(x[0]) - half_x, float(x[-1]) + half_x)
    ends = (float(y[-1]) + half_y, float(y[0]) - half_y)
    axes.imshow(
        levels_db, extent=(*edges, *ends), cmap="magma", vmin=-DYNAMIC_DB, vmax=0,
        interpolation="bicubic", interpolation_stage="data",
    )  # fmt: skip


def _frame(axes: Axes, x_mm: Any, y_mm: Any) -> None:
    axes.set_xlim(x_mm[0] - 20, x_mm[-1] + 20)
    axes.set_ylim(y_mm[-1] + 20, y_mm[0] - 20)
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]", fontsize=9)
    axes.set_ylabel("y [mm]", fontsize=9)
    axes.tick_params(labelsize=8)
