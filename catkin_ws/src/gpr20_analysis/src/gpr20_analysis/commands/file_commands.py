"""gpr20 export, import and sample: surveys in the files of other programs, and to try it out."""

from __future__ import annotations

import argparse
import shutil
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, Dict, Tuple

import xarray as xr

from gpr20_analysis import dataset, errors
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import arguments
from gpr20_analysis.commands.command import DONE, Command, per
from gpr20_analysis.errors import AnalysisError, ExportError, check_ending, not_there
from gpr20_analysis.formats.common import to_frequency
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_analysis.formats.imports import IMPORTS, Band, ImportOptions, import_survey
from gpr20_analysis.sample import real_line, sample_survey
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say

MCAP = ".mcap"


def _add_export(parser: argparse.ArgumentParser) -> None:
    from gpr20_analysis.formats.exports import ENDINGS

    arguments.add_survey(parser)
    endings = ", ".join(f"{ending} ({name})" for name, ending in ENDINGS.items() if ending)
    parser.add_argument(
        "output",
        type=Path,
        nargs="?",
        help=f"file, ending in {endings}; a new folder for the others; without it, a bag is made "
        "in the folder of the survey",
    )
    parser.add_argument("--format", choices=ENDINGS, required=True, help="what to write")
    arguments.add_overwrite(parser)


def _export(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    from gpr20_analysis.formats import exports

    form, output = chosen.format, chosen.output
    if output is None:
        if form != "bag":
            raise ExportError(
                Message(
                    "the format {format} needs an output: give a file or folder behind the survey",
                    format=form,
                ),
                fault=errors.INPUT,
            )
        return _say(exports.make_survey_bag(chosen.survey), chosen.survey, catalogue)
    exports.check_format(output, form)
    arguments.check_outputs([output], [chosen.survey], chosen.overwrite)
    progress = arguments.progress_bar("writing")
    if form in exports.OF_RECORDINGS:
        written = exports.export_recording(chosen.survey, output, form, progress)
        return _say(written, output, catalogue)
    survey = arguments.load(chosen, catalogue)
    say(f"{output}: {exports.export_survey(survey, output, form, progress)}")
    return arguments.status_of(survey)


def _say(written: Tuple[Message, Dict[str, Any]], path: Path, catalogue: Catalogue) -> int:
    """Print what was written, and on stderr what is left out or doubted; return the status."""
    content, said = written
    survey = xr.Dataset(attrs=said)
    arguments.print_warnings(survey, catalogue)
    say(f"{path}: {content}")
    return arguments.status_of(survey)


def _add_import(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("input", type=Path, help="file, or folder of files")
    add("output", type=Path,
        help="Dataset to write, .nc; or the folder of the surveys, into which a survey's folder is "
        "written")  # fmt: skip
    add("--format", choices=IMPORTS.names(), required=True, help="format of the input")
    add("--band", nargs=3, type=float, metavar=("START_HZ", "STOP_HZ", "POINTS"),
        help="frequencies of the spectra of simulations and of A-scans over time; default: of "
        "simulations 600e6 6e9 501, of others as found in the data")  # fmt: skip
    add("--height", dest="height_m", type=float, metavar="M",
        help="antenna height [m], if it is not recorded")  # fmt: skip
    add("--source", metavar="SIGNAL",
        help="simulations: signal of the source, by which spectra are divided, if the files do not "
        "contain it: a waveform with its frequency in Hz, such as ricker:1.5e9")  # fmt: skip
    add("--real-ground", action="store_true",
        help="the data show real ground, if the input does not say it; the window marks data of "
        "which that is not known SIMULATED")  # fmt: skip
    # What the files of other instruments may lack; a format refuses what it cannot use.
    add("--time-zero", dest="time_zero_s", type=per(1e9), metavar="NS",
        help="time in the record at which the pulse leaves the antennas, from the first sample "
        "[ns]; default: as recorded, else 0")  # fmt: skip
    add("--separation", dest="separation_m", type=float, metavar="M",
        help="distance between the antennas [m]; default: as recorded")  # fmt: skip
    add("--spacing", dest="spacing_m", type=per(dataset.MM_PER_M), metavar="MM",
        help="distance between traces along a line [mm]; default: as recorded")  # fmt: skip
    add("--channel", type=int, metavar="N", help="dzt: channel, from 1")
    add("--interval", dest="interval_s", type=per(1e12), metavar="PS",
        help="segy: time between samples [ps]; default: the number in the header")  # fmt: skip
    arguments.add_overwrite(parser)


def _import(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    output = chosen.output
    into_folder = not output.suffix or (output.is_dir() and output.suffix != NETCDF)
    if not into_folder:
        check_ending(output, (NETCDF,))
    # The survey's folder gets its name when it is written.
    written = output / "survey" if into_folder else output
    arguments.check_outputs([written], [chosen.input], chosen.overwrite)
    if not chosen.input.exists():
        raise AnalysisError(not_there(chosen.input), fault=errors.INPUT)
    options = {one.name: getattr(chosen, one.name) for one in fields(ImportOptions)}
    band = options["band"] = _band(*chosen.band) if chosen.band else None
    progress = arguments.progress_bar("reading")
    survey = import_survey(chosen.input, chosen.format, progress, **options)
    if dataset.A_SCAN in survey:
        survey = to_frequency(survey, *(astuple(band) if band else ()))
    if chosen.real_ground and dataset.is_simulated(survey):
        raise AnalysisError(
            Message("{path} holds simulated data; leave out --real-ground", path=chosen.input)
        )
    if chosen.real_ground:
        survey = survey.assign_attrs({dataset.SIMULATED: 0})
    arguments.print_warnings(survey, catalogue)
    if into_folder:
        source = ImportSource.of(chosen.input, chosen.format)
        progress = arguments.progress_bar("writing traces")
        output = write_imported_folder(survey, output, source, progress)
    else:
        write_dataset(survey, output)
    sizes = ", ".join(f"{name} {size}" for name, size in survey.sizes.items())
    say(f"{output}: {sizes}")
    return arguments.status_of(survey)


def _band(start_hz: float, stop_hz: float, points: float) -> Band:
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


def _add_sample(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("output", type=Path, help="copy to write: .mcap; of the real line .nc")
    parser.add_argument(
        "--real",
        action="store_true",
        help="a line over real ground instead: 14 reinforcing bars in concrete, measured by a GSSI "
        "radar (CHARISMA, CC0)",
    )
    arguments.add_overwrite(parser)


def _sample(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    output = chosen.output
    check_ending(output, (NETCDF if chosen.real else MCAP,))
    arguments.check_outputs([output], [sample_survey()], chosen.overwrite)
    if chosen.real:
        write_dataset(real_line(), output)
    else:
        with atomic_output(output) as place:
            shutil.copyfile(str(sample_survey()), str(place))
    say(output)
    return DONE


EXPORT = Command("Write a survey in another format.", _add_export, _export)
IMPORT = Command(
    "Read measurements and simulations of other programs, to process them like surveys.",
    _add_import,
    _import,
)
SAMPLE = Command(
    "Write a copy of the sample survey: the traces that the simulated robot recorded over three "
    "buried targets. All data of it are SIMULATED. With --real, a line over real ground.",
    _add_sample,
    _sample,
)
