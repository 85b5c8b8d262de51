"""gpr20 delay and antenna: the delay of cables and antennas, and the model of the antennas."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import List

import xarray as xr

from gpr20_analysis.candidates.answer import with_height
from gpr20_analysis.commands import arguments
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset
from gpr20_analysis.imaging.image_options import check_range
from gpr20_analysis.processing.antenna_step import MISFIT, PLATE_HEIGHT, antenna_of
from gpr20_analysis.processing.chain import recorded_steps
from gpr20_analysis.processing.delay import recorded_delay_s
from gpr20_analysis.processing.surface_echo import fit_delay
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.survey_attributes import DELAY_KEY
from gpr20_common.catalogue import Catalogue
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.radar import one_way_path_m

NS_PER_S = 1e9
FILE = "analyzer.yaml"


def _add_delay(parser: argparse.ArgumentParser) -> None:
    arguments.add_survey(parser)
    _add_separation(parser)
    add = parser.add_argument
    add("--height", type=float, metavar="M",
        help="one antenna height for all samples instead of the recorded ones, such as that above "
        "a metal plate")  # fmt: skip
    add("--plate", action="store_true", help="the survey was measured over a metal plate")


def _delay(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    _check(chosen, [chosen.height])
    survey = arguments.load(chosen, catalogue)
    steps = [one["step"] for one in recorded_steps(survey)]
    if steps:
        raise WrongDatasetError(
            Message(
                "the data were changed by {steps}; fit the delay to the survey as measured",
                steps=", ".join(steps),
            )
        )
    fit = fit_delay(survey, chosen.separation, chosen.height, chosen.plate)
    delay_ns = fit.delay_s * NS_PER_S
    spread_ns = fit.residual_s * NS_PER_S
    spread_mm = one_way_path_m(fit.residual_s) * MM_PER_M
    say(
        f"delay of cables and antennas: {delay_ns:.3f} ns, within "
        f"{fit.uncertainty_s * NS_PER_S:.3f} ns (95 %), from {fit.traces} traces",
        f"spread of single traces: {spread_ns:.3f} ns, {spread_mm:.1f} mm of height",
        "surface and coupling are separated by the differing heights"
        if fit.by_movement
        else "the heights do not separate surface and coupling; the last strong echo of all traces "
        "is taken for the surface",
        f"recorded in the survey: {recorded_delay_s(survey) * NS_PER_S:.3f} ns",
        f"in {FILE} of the robot's configuration:",
        f"{DELAY_KEY}: {delay_ns:.3f}",
    )
    return arguments.status_of(survey)


def _add_antenna(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("plates", type=Path, nargs="+", metavar="SURVEY",
        help="a survey of a metal plate at one height; four or more")  # fmt: skip
    add("--height", type=float, nargs="+", metavar="M",
        help="height over the plate in each survey, instead of the recorded ones")  # fmt: skip
    _add_separation(parser)
    arguments.add_output(parser, [NETCDF], "model: .nc", required=True)


def _antenna(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    heights_m = chosen.height or [None] * len(chosen.plates)
    if len(heights_m) != len(chosen.plates):
        raise WrongDatasetError(
            Message(
                "--height has {count} values for {surveys} surveys; give one for each",
                count=len(heights_m),
                surveys=len(chosen.plates),
            ),
            fault=NOT_ALLOWED,
        )
    _check(chosen, heights_m)
    arguments.check_outputs([chosen.output], chosen.plates, chosen.overwrite)
    plates: List[xr.Dataset] = []
    for path, height_m in zip(chosen.plates, heights_m):
        plates.append(with_height(load_survey(path), height_m))
        arguments.print_warnings(plates[-1], catalogue, str(path))
    model = antenna_of(plates, chosen.separation)
    write_dataset(model, chosen.output)
    heights_mm = MM_PER_M * model[PLATE_HEIGHT].values
    misfit = 100.0 * float(model[MISFIT].max())
    say(
        f"{chosen.output}: antennas by {len(plates)} heights from {heights_mm.min():.0f} to "
        f"{heights_mm.max():.0f} mm; a plate leaves {misfit:.1f} % of their difference unexplained"
    )
    return max([DONE, *map(arguments.status_of, plates)])


def _add_separation(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--separation", type=float, default=0.0, metavar="M",
                        help="distance between the antennas")  # fmt: skip


def _check(chosen: argparse.Namespace, heights_m: list) -> None:
    check_range("--separation", chosen.separation, 0.0, 2.0, "m")
    for height_m in heights_m:
        check_range("--height", height_m, 0.001, 10.0, "m")


DELAY = Command(
    "Fit the delay of cables and antennas to the echo of the surface, or of a metal plate, and the "
    "recorded heights. Use a survey as measured, before any step.",
    _add_delay,
    _delay,
)
ANTENNA = Command(
    "Fit the model of the antennas to surveys of a metal plate at four or more heights. The step "
    "antenna removes coupling and ringing by it, and measures the permittivity of the surface.",
    _add_antenna,
    _antenna,
)
