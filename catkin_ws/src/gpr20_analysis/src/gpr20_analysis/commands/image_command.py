"""gpr20 image: the image of the ground, and the candidates in it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import List

import numpy as np

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.candidates.answer import Answer
from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output, save_figure
from gpr20_analysis.dataset import DEPTH, MM_PER_M, POLARIZATION, is_line
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_common.catalogue import Catalogue

FIGURES = ("projections_*.png", "slice_*.png")
MOST_SLICES = 12


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    image_options.add_options(parser)
    image_options.add_list_options(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, action="append", default=[],
        help="image as .nc; may be given more than once")  # fmt: skip
    add("--figures", type=Path, metavar="FOLDER", help="draw projections and slices as PNG")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Make the image and return the exit status."""
    options = image_options.options_of(chosen)
    steps = image_options.steps_of(chosen)
    outputs.check(_outputs(chosen), inputs.inputs_of(chosen, steps), chosen.overwrite)
    found, status = image_options.answer_of(chosen, options, catalogue)
    for path in chosen.output:
        write_dataset(found.image, path)
    if chosen.figures:
        with atomic_output(chosen.figures) as folder:
            _draw(found, folder, catalogue)
    image_options.print_answer(found, chosen, catalogue)
    return status


def _outputs(chosen: argparse.Namespace) -> List[Output]:
    figures = [Output(chosen.figures, FIGURES)] if chosen.figures else []
    return [*figures, *map(outputs.dataset_output, chosen.output)]


def _draw(found: Answer, folder: Path, catalogue: Catalogue) -> None:
    from gpr20_analysis.plotting.projections import projection_figure
    from gpr20_analysis.plotting.scans import c_scan_figure

    folder.mkdir()
    image, places = found.image, found.found.shown()
    for turn, degrees in enumerate(image[POLARIZATION].values):
        figure = projection_figure(image, turn, places, catalogue)
        word = "combined" if np.isnan(degrees) else f"{degrees:g}deg"
        save_figure(figure, folder / f"projections_{word}.png")
    marked = [] if is_line(image) else places[:MOST_SLICES]
    depths_m = image[DEPTH].sel(depth=[one.depth_m for one in marked], method="nearest")
    for depth_m in list(dict.fromkeys(depths_m.values.tolist())):
        figure = c_scan_figure(image, depth_m, catalogue)
        save_figure(figure, folder / f"slice_{round(depth_m * MM_PER_M):04d}mm.png")


COMMAND = Command(
    "Image the ground below a survey and list the candidates in it. Without steps coupling "
    "and surface echo are subtracted first (background:method=surface).",
    add_arguments,
    run,
)
