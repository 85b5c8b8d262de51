"""gpr20 antenna: the model of the antennas, from surveys of a metal plate."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import List

import xarray as xr

from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.dataset import HEIGHT, MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.imaging.image_options import check_range
from gpr20_analysis.processing.antenna_step import MISFIT, PLATE_HEIGHT, antenna_of
from gpr20_analysis.read.load import load_survey
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("plates", type=Path, nargs="+", metavar="SURVEY",
        help="a survey of a metal plate at one height; four or more")  # fmt: skip
    add("--output", "-o", type=Path, required=True, help="model: .nc")
    add("--height", type=float, nargs="+", metavar="M",
        help="height over the plate in each survey, instead of the recorded ones")  # fmt: skip
    add("--separation", type=float, default=0.0, metavar="M", help="distance between the antennas")
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Fit the model, write it and return the exit status."""
    check_range("--separation", chosen.separation, 0.0, 2.0, "m")
    outputs.check([outputs.dataset_output(chosen.output)], chosen.plates, chosen.overwrite)
    plates = [load_survey(one) for one in chosen.plates]
    if chosen.height is not None:
        plates = [
            plate.assign({HEIGHT: xr.full_like(plate[HEIGHT], height_m)})
            for plate, height_m in zip(plates, _heights_m(chosen))
        ]
    for path, plate in zip(chosen.plates, plates):
        inputs.print_warnings(plate, catalogue, str(path))
    model = antenna_of(plates, chosen.separation)
    write_dataset(model, chosen.output)
    say(catalogue.tr("{path}: antennas by {count} heights from {lowest_mm:.0f} to {highest_mm:.0f} "
                     "mm; a plate leaves {misfit:.1f} % of their difference unexplained",
                     path=chosen.output,
                     count=len(plates),
                     lowest_mm=MM_PER_M * float(model[PLATE_HEIGHT].min()),
                     highest_mm=MM_PER_M * float(model[PLATE_HEIGHT].max()),
                     misfit=100.0 * float(model[MISFIT].max())))  # fmt: skip
    return max([DONE, *(inputs.status_of(one) for one in plates)])


def _heights_m(chosen: argparse.Namespace) -> List[float]:
    if len(chosen.height) != len(chosen.plates):
        raise WrongDatasetError(
            Message(
                "--height has {count} values for {surveys} surveys; give one for each",
                count=len(chosen.height),
                surveys=len(chosen.plates),
            ),
            fault=NOT_ALLOWED,
        )
    for height_m in chosen.height:
        check_range("--height", height_m, 0.001, 10.0, "m")
    return list(chosen.height)


COMMAND = Command(
    "Fit the model of the antennas to surveys of a metal plate at four or more heights. The step "
    "antenna removes coupling and ringing by it, and measures the permittivity of the surface.",
    add_arguments,
    run,
)
