"""gpr20 import: measurements and simulations of other programs as a Dataset."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_analysis import dataset, faults
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import AnalysisError, not_there
from gpr20_analysis.formats import dataset_files
from gpr20_analysis.formats.dataset_files import NETCDF
from gpr20_analysis.formats.facts import SIMULATED_KEY, is_simulated
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_analysis.formats.imports import IMPORTS, Band, import_survey
from gpr20_analysis.processing.to_frequency import to_frequency
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("input", type=Path, help="file, or folder of files")
    parser.add_argument(
        "output",
        type=Path,
        help="Dataset to write, .nc; or the folder of the surveys, into which a survey's "
        "folder is written",
    )
    parser.add_argument(
        "--format", choices=IMPORTS.names(), required=True, help="format of the input"
    )
    parser.add_argument(
        "--band",
        nargs=3,
        type=float,
        metavar=("START_HZ", "STOP_HZ", "POINTS"),
        help="frequencies of the spectra of simulations and of A-scans over time; default: of "
        "simulations 600e6 6e9 501, of others as found in the data",
    )
    parser.add_argument(
        "--height", type=float, metavar="M", help="antenna height [m], if it is not recorded"
    )
    parser.add_argument(
        "--source",
        metavar="SIGNAL",
        help="simulations: signal of the source, by which spectra are divided, if the files do not "
        "contain it: a waveform with its frequency in Hz, such as ricker:1.5e9",
    )
    parser.add_argument(
        "--real-ground",
        action="store_true",
        help="the data show real ground, if the input does not say it; the window marks data of "
        "which that is not known SIMULATED",
    )
    _add_instrument_arguments(parser)
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Convert the input; return the exit status."""
    suffix = chosen.output.suffix
    into_folder = not suffix or (chosen.output.is_dir() and suffix != NETCDF)
    if into_folder:
        outputs.check_survey_folders(chosen.output, [chosen.input])
    else:
        written = [outputs.dataset_output(chosen.output)]
        outputs.check(written, [chosen.input], chosen.overwrite)
    if not chosen.input.exists():
        raise AnalysisError(not_there(chosen.input), fault=faults.INPUT)
    band = _band(chosen)
    survey = import_survey(
        chosen.input,
        chosen.format,
        inputs.progress_bar("reading"),
        band=band,
        height_m=chosen.height,
        source=chosen.source,
        **_instrument_options(chosen),
    )
    if dataset.A_SCAN in survey:
        survey = to_frequency(survey, *(dataclasses.astuple(band) if band else ()))
    if chosen.real_ground and is_simulated(survey):
        raise AnalysisError(
            Message("{path} holds simulated data; leave out --real-ground", path=chosen.input)
        )
    if chosen.real_ground:
        survey = survey.assign_attrs({SIMULATED_KEY: 0})
    inputs.print_warnings(survey, catalogue)
    output = chosen.output
    if into_folder:
        source = ImportSource.of(chosen.input, chosen.format)
        progress = inputs.progress_bar("writing traces")
        output = write_imported_folder(survey, output, source, progress)
    else:
        dataset_files.write_dataset(survey, output)
    sizes = ", ".join(f"{name} {size}" for name, size in survey.sizes.items())
    say(f"{output}: {sizes}")
    return inputs.status_of(survey)


def _add_instrument_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what the files of other instruments may lack; a format refuses what it cannot use."""
    add = parser.add_argument
    add("--time-zero", type=float, metavar="NS",
        help="time in the record at which the pulse leaves the antennas, from the first sample "
        "[ns]; default: as recorded, else 0")  # fmt: skip
    add("--separation", type=float, metavar="M",
        help="distance between the antennas [m]; default: as recorded")  # fmt: skip
    add("--spacing", type=float, metavar="MM",
        help="distance between traces along a line [mm]; default: as recorded")  # fmt: skip
    add("--channel", type=int, metavar="N", help="dzt: channel, from 1")
    add("--interval", type=float, metavar="PS",
        help="segy: time between samples [ps]; default: the number in the header")  # fmt: skip


def _instrument_options(chosen: argparse.Namespace) -> Dict[str, Any]:
    def scaled(value: Optional[float], unit: float) -> Optional[float]:
        return None if value is None else value * unit

    return {
        "time_zero_s": scaled(chosen.time_zero, 1e-9),
        "separation_m": chosen.separation,
        "spacing_m": scaled(chosen.spacing, 1.0 / dataset.MM_PER_M),
        "channel": chosen.channel,
        "interval_s": scaled(chosen.interval, 1e-12),
    }


def _band(chosen: argparse.Namespace) -> Optional[Band]:
    if chosen.band is None:
        return None
    start_hz, stop_hz, points = chosen.band
    if not (0.0 < start_hz < stop_hz and points >= 2 and points == int(points)):
        raise AnalysisError(
            Message(
                "--band is {start_hz:g} {stop_hz:g} {points:g}; it must be 0 < START < STOP and a "
                "whole number of at least 2 points",
                start_hz=start_hz,
                stop_hz=stop_hz,
                points=points,
            )
        )
    return Band(start_hz, stop_hz, int(points))


COMMAND = Command(
    "Read measurements and simulations of other programs, to process them like surveys.",
    add_arguments,
    run,
)
