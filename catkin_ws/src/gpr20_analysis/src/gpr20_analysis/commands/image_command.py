"""gpr20 image: the image of the ground, and the echoes in it."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Dict, List, Optional

import numpy as np
import xarray as xr

from gpr20_analysis import cluster
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.commands.outputs import Output, save_figure
from gpr20_analysis.dataset import DEPTH, POLARIZATION
from gpr20_analysis.errors import ExportError, WrongDatasetError, wrong_ending
from gpr20_analysis.formats.dataset_files import NETCDF, ZARR, write_dataset
from gpr20_analysis.imaging.echoes import FAINTEST_DB, Echo, find_echoes
from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions, Method
from gpr20_analysis.imaging.image_output import SUFFIX as VTK
from gpr20_analysis.imaging.image_output import (
    echo_lines,
    permittivity_line,
    rotation_word,
    write_volume,
)
from gpr20_analysis.imaging.records import Ground
from gpr20_analysis.processing.chain import PROCESSING, recipe_of
from gpr20_analysis.processing.sweep import Window
from gpr20_analysis.sentences import sentences_of, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message

DEFAULT_STEPS = ("background:method=mean",)
MOST_DEPTHS = 5000
FAINTEST_LIMIT_DB = 200.0
FIGURES = ("projections_*.png", "slice_*mm.png")
ESTIMATE = ("permittivity_lowest", "permittivity_highest", "depth_uncertainty")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    inputs.add_survey(parser)
    inputs.add_steps(parser)
    add_image_options(parser)
    inputs.add_scheduler(parser)
    add = parser.add_argument
    add("--output", "-o", type=Path, action="append", default=[],
        help="image as .nc, .zarr or .vtr (VTK); may be given more than once")  # fmt: skip
    add(
        "--figures",
        type=Path,
        metavar="FOLDER",
        help="folder for PNG figures: maximum projections, a slice at each echo",
    )
    outputs.add_overwrite(parser)
    add("--faintest", type=float, default=FAINTEST_DB, metavar="DB",
        help="faintest echo to list, relative to the brightest")  # fmt: skip
    add("--json", action="store_true", help="print the echoes as JSON, for programs")


def add_image_options(parser: argparse.ArgumentParser) -> None:
    """Declare how an image is made."""
    add = parser.add_argument
    add("--method", choices=[one.value for one in Method], default=Method.PHASE_SHIFT.value)
    add("--permittivity", type=float,
        help="relative permittivity; estimated from echoes if not given")  # fmt: skip
    add("--depth", type=float, nargs=3, default=(0.0, 0.3, 0.003),
        metavar=("FIRST", "LAST", "STEP"),
        help="depths of the image [m]; default 0 0.3 0.003")  # fmt: skip
    add(
        "--height",
        type=float,
        metavar="M",
        help="one antenna height for all samples instead of the recorded ones",
    )
    add(
        "--leave-out-missing",
        action="store_true",
        help="make the image without the missing samples",
    )
    add("--window", choices=[one.value for one in Window], default=Window.HANN.value)
    add("--widest-angle", type=float, default=70.0, metavar="DEG", help="to the vertical in air")
    add("--separation", type=float, default=0.0, metavar="M",
        help="distance between the antennas; used by back-projection and by the estimate of the "
        "permittivity")  # fmt: skip
    add("--ground", choices=[one.value for one in Ground], default=Ground.LEVEL.value,
        help="uneven: the recorded heights differ because of the ground, not because of the "
        "antennas; only back-projection supports it")  # fmt: skip


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Make the image and return the exit status."""
    options = options_of(chosen)
    if not -FAINTEST_LIMIT_DB <= chosen.faintest < 0.0:
        raise WrongDatasetError(
            Message(
                "--faintest is {faintest_db:g} dB; it must be at least {lowest_db:g} dB and less "
                "than 0",
                faintest_db=chosen.faintest,
                lowest_db=-FAINTEST_LIMIT_DB,
            )
        )
    steps = inputs.steps_of(chosen)
    outputs.check(_outputs(chosen), inputs.inputs_of(chosen, steps), chosen.overwrite)
    survey = inputs.load(chosen, catalogue)
    default = () if recipe_of(survey) else DEFAULT_STEPS
    with cluster.connected(chosen.scheduler):
        steps = inputs.steps_of(chosen, default)
        processed, status = inputs.process(cluster.persist(survey), steps, catalogue)
        progress = inputs.progress_bar(catalogue.tr("imaging polarizations"))
        image = image_survey(processed, options, progress)
    _write(image, chosen, catalogue)
    _print(image, chosen, catalogue)
    return status


def options_of(chosen: argparse.Namespace) -> ImageOptions:
    """Return the options of the image.

    Raises:
        WrongDatasetError: An argument is not allowed.
    """
    first, last, step = chosen.depth
    count = np.floor((last - first) / step + 1e-9) + 1.0 if step else np.nan
    # Written so that NaN is refused too.
    if not 2.0 <= count <= MOST_DEPTHS:
        raise WrongDatasetError(
            Message(
                "--depth {first_m:g} {last_m:g} {step_m:g} gives {count:.0f} depths; use 2 to "
                "{most}",
                first_m=first,
                last_m=last,
                step_m=step,
                count=max(count, 0.0),
                most=MOST_DEPTHS,
            )
        )
    return ImageOptions(
        method=Method(chosen.method),
        permittivity=chosen.permittivity,
        depth_m=tuple(first + step * np.arange(int(count))),
        height_m=chosen.height,
        leave_out_missing=chosen.leave_out_missing,
        window=Window(chosen.window),
        widest_angle_deg=chosen.widest_angle,
        separation_m=chosen.separation,
        ground=Ground(chosen.ground),
    )


def _outputs(chosen: argparse.Namespace) -> List[Output]:
    found = [Output(chosen.figures, FIGURES)] if chosen.figures else []
    for path in chosen.output:
        if path.suffix not in (NETCDF, ZARR, VTK):
            raise ExportError(wrong_ending(path, (NETCDF, ZARR, VTK)))
        found.append(Output(path) if path.suffix == VTK else outputs.dataset_output(path))
    return found


def _write(image: xr.Dataset, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    for path in chosen.output:
        if path.suffix in (NETCDF, ZARR):
            write_dataset(image, path)
        else:
            with atomic_output(path) as place:
                write_volume(image, place)
    if chosen.figures:
        with atomic_output(chosen.figures) as folder:
            _draw(image, folder, chosen.faintest, catalogue)


def _draw(image: xr.Dataset, folder: Path, faintest_db: float, catalogue: Catalogue) -> None:
    from gpr20_analysis.plotting.scans import c_scan_figure, projection_figure

    folder.mkdir()
    for turn, degrees in enumerate(image[POLARIZATION].values):
        figure = projection_figure(image, turn, catalogue)
        save_figure(figure, folder / f"projections_{rotation_word(degrees)}.png")
    for echo in find_echoes(image, faintest_db):
        depth_mm = round(float(image[DEPTH].sel(depth=echo.depth_m, method="nearest")) * 1000.0)
        figure = c_scan_figure(image, echo.depth_m, catalogue)
        save_figure(figure, folder / f"slice_{depth_mm:04d}mm.png")


def _print(image: xr.Dataset, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    echoes = find_echoes(image, chosen.faintest)
    if chosen.json:
        answer = {
            "permittivity": image.attrs["permittivity"],
            "permittivity_source": image.attrs["permittivity_source"],
            **{key: image.attrs[key] for key in ESTIMATE if key in image.attrs},
            "method": image.attrs["method"],
            "processing": json.loads(image.attrs.get(PROCESSING, "[]")),
            "notes": image.attrs["notes"],
            "echoes": [_plain(echo) for echo in echoes],
        }
        print(json.dumps(answer, indent=2))
        return
    notes = [Message("note: {sentence}", sentence=one) for one in sentences_of(image, "notes")]
    for line in [*notes, permittivity_line(image)]:
        print(shown(line, catalogue))
    lines = echo_lines(echoes, catalogue) if echoes else [catalogue.tr("No echo was found.")]
    print("\n".join(lines))


def _plain(echo: Echo) -> Dict[str, Optional[float]]:
    """Return an echo for JSON, which has no NaN."""
    values = dataclasses.asdict(echo)
    return {key: value if np.isfinite(value) else None for key, value in values.items()}


COMMAND = Command(
    "Image the ground below a survey and list the echoes in it. Without steps the mean of all "
    "traces is subtracted first.",
    add_arguments,
    run,
)
