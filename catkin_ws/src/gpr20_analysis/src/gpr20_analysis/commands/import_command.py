"""gpr20 import: measurements and simulations of others as a Dataset."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats import dataset_files
from gpr20_analysis.formats.conversion import IMPORTS, import_survey
from gpr20_analysis.formats.gprmax import Band
from gpr20_analysis.formats.gprmax_source import WAVEFORMS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    band = Band()
    parser.add_argument("input", type=Path, help="file, or folder of files")
    parser.add_argument("output", type=Path, help="Dataset to write, .nc or .zarr")
    parser.add_argument("--format", choices=IMPORTS, required=True, help="what the input is")
    parser.add_argument(
        "--band",
        nargs=3,
        type=float,
        metavar=("START_HZ", "STOP_HZ", "POINTS"),
        default=(band.start_hz, band.stop_hz, band.points),
        help="gprmax: frequencies of the spectra",
    )
    parser.add_argument("--height", type=float, metavar="M", help="gprmax: antenna height [m]")
    parser.add_argument(
        "--source",
        metavar="SIGNAL",
        help="gprmax: signal of the source, by which spectra are divided, if the files do not hold "
        f"it (version 3): {', '.join(WAVEFORMS)} with the frequency in Hz, such as ricker:1.5e9; a "
        "text file of times [s] and values; or none",
    )
    outputs.add_overwrite(parser)


def run(chosen: argparse.Namespace) -> int:
    """Convert the input; return the exit status."""
    written = [outputs.dataset_output(chosen.output)]
    outputs.check(written, [chosen.input], chosen.overwrite)
    if not chosen.input.exists():
        raise AnalysisError(f"{chosen.input} does not exist")
    survey = import_survey(
        chosen.input,
        chosen.format,
        _band(chosen),
        chosen.height,
        chosen.source,
        inputs.progress_bar("reading"),
    )
    inputs.tell(survey)
    dataset_files.write_dataset(survey, chosen.output)
    print(f"{chosen.output}: {dict(survey.sizes)}")
    return inputs.status_of(survey)


def _band(chosen: argparse.Namespace) -> Band:
    start_hz, stop_hz, points = chosen.band
    if not (0.0 < start_hz < stop_hz and points >= 2 and points == int(points)):
        raise AnalysisError(
            f"--band is {start_hz:g} {stop_hz:g} {points:g}; it must be 0 < START < STOP and a "
            "whole number of at least 2 points"
        )
    return Band(start_hz, stop_hz, int(points))


COMMAND = Command(
    "Read measurements and simulations of others, so that they go through the same steps.",
    add_arguments,
    run,
)
