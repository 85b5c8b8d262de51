"""gpr20 process, image and candidates: steps, the image of the ground, and the places to check."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import List, Tuple

from gpr20_analysis.candidates.answer import Answer, answer
from gpr20_analysis.candidates.files import ENDINGS, output_paths, write_candidates
from gpr20_analysis.candidates.table import candidate_lines
from gpr20_analysis.commands import image_options, inputs, outputs
from gpr20_analysis.commands.command import Command
from gpr20_analysis.errors import StepError
from gpr20_analysis.formats.dataset_files import NETCDF, write_dataset
from gpr20_analysis.imaging.permittivity import permittivity_line
from gpr20_analysis.processing.chain import STEPS, recorded_steps, text_of
from gpr20_analysis.sentences import DOUBTS, NOTES, labelled, shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.results.candidates import json_text


def _add_process(parser: argparse.ArgumentParser) -> None:
    inputs.add_survey(parser)
    image_options.add_steps(parser)
    outputs.add_output(parser, [NETCDF], "result: .nc", required=True)


def _process(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    wanted = image_options.chosen_steps(chosen)
    if not wanted:
        names = ", ".join(STEPS.names())
        raise StepError(Message("no step was given; use --step with one of: {steps}", steps=names))
    outputs.check([chosen.output], image_options.inputs_of(chosen, wanted), chosen.overwrite)
    result, status = image_options.process(inputs.load(chosen, catalogue), wanted, catalogue)
    write_dataset(result, chosen.output)
    say(f"{chosen.output}, made by the steps:", *map(text_of, recorded_steps(result)))
    return status


def _add_image(parser: argparse.ArgumentParser) -> None:
    _add_answer(parser)
    meaning = "image as .nc; may be given more than once"
    outputs.add_output(parser, [NETCDF], meaning, action="append", default=[])


def _image(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    found, status = _answer(chosen, chosen.output, catalogue)
    for path in chosen.output:
        write_dataset(found.image, path)
    _print(found, chosen, catalogue)
    return status


def _add_candidates(parser: argparse.ArgumentParser) -> None:
    _add_answer(parser)
    meaning = "list as .csv, .json or .geojson, with all weaker echoes; may be given more than once"
    outputs.add_output(parser, ENDINGS, meaning, action="append", default=[])


def _candidates(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    written = [one for path in chosen.output for one in output_paths(path)]
    found, status = _answer(chosen, written, catalogue)
    for path in chosen.output:
        write_candidates(found.found, path)
    _print(found, chosen, catalogue)
    return status


def _add_answer(parser: argparse.ArgumentParser) -> None:
    image_options.add_options(parser)
    add = parser.add_argument
    add("--weaker", action="store_true", help="print the weaker echoes too, below the cut")
    add("--json", action="store_true", help="print the list as JSON, for programs")


def _answer(
    chosen: argparse.Namespace, written: List[Path], catalogue: Catalogue
) -> Tuple[Answer, int]:
    options = image_options.options_of(chosen)
    wanted = image_options.steps_of(chosen)
    outputs.check(written, image_options.inputs_of(chosen, wanted), chosen.overwrite)
    survey, status = image_options.processed(chosen, options, wanted, catalogue)
    return answer(survey, options, inputs.progress_bar("imaging")), status


def _print(found: Answer, chosen: argparse.Namespace, catalogue: Catalogue) -> None:
    if chosen.json:
        print(json.dumps(json.loads(json_text(found.found)), indent=2))  # noqa: T201
        return
    notes = [labelled(DOUBTS if one.fault_code else NOTES, one) for one in found.found.notes]
    for line in [*notes, permittivity_line(found.image)]:
        say(shown(line, catalogue))
    say(*candidate_lines(found.found, catalogue, chosen.weaker))


PROCESS = Command(
    "Apply a chain of processing steps to a survey. The result records them.",
    _add_process,
    _process,
)
IMAGE = Command(
    "Image the ground below a survey and list the candidates in it. Without steps coupling "
    "and surface echo are subtracted first (background:method=surface).",
    _add_image,
    _image,
)
CANDIDATES = Command(
    "List the candidates in the ground below a survey: places where its image is brighter than "
    "clutter. It is a list, no clearance. Without steps coupling and surface echo are subtracted.",
    _add_candidates,
    _candidates,
)
