"""The survey that a subcommand is given, and the warnings about it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Iterable, Optional

import xarray as xr
from tqdm import tqdm

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE
from gpr20_analysis.dataset import ANTENNA
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import (
    DOUBTS,
    LIST_ATTRIBUTES,
    labelled,
    limited,
    sentences_of,
    shown,
)
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable, say

MOST_REMARKS = 8
"""Number of sentences of a list that are shown with a survey."""


def add_survey(parser: argparse.ArgumentParser) -> None:
    """Declare the survey, and whether it may be damaged."""
    parser.add_argument(
        "survey",
        type=Path,
        help="folder of a survey, folder of its JSON files, .bag, .bag.active, .mcap, or .nc",
    )
    parser.add_argument(
        "--accept-damaged",
        action="store_true",
        help="mark damaged samples and leave them out, instead of refusing the survey",
    )


def load(chosen: argparse.Namespace, catalogue: Catalogue) -> xr.Dataset:
    """Load the survey and print on stderr what is missing or damaged in it.

    Raises:
        AnalysisError: It cannot be loaded.
    """
    progress = progress_bar("reading traces")
    survey = load_survey(chosen.survey, chosen.accept_damaged, progress)
    if ANTENNA in survey:
        raise WrongDatasetError(
            Message(
                "{path} is a model of antennas and no survey; use it with --antenna",
                path=chosen.survey,
            ),
            fault=faults.INPUT,
        )
    print_warnings(survey, catalogue)
    return survey


def status_of(survey: xr.Dataset) -> int:
    """Return the exit status for a survey."""
    if survey.attrs.get("faults"):
        return DAMAGED
    return NOT_COMPLETE if survey.attrs.get("missing") else DONE


def print_warnings(survey: xr.Dataset, catalogue: Catalogue, path: str = "") -> None:
    """Print on stderr what is damaged, missing, doubted or noted in a survey.

    All doubts, and of other lists the first sentences.

    Args:
        survey: The survey.
        catalogue: Language of the output.
        path: Where it was read from, if it is not the survey of the command.
    """
    for name in LIST_ATTRIBUTES:
        found = sentences_of(survey, name)
        for one in found if name == DOUBTS else limited(found, MOST_REMARKS):
            sentence = Message("{file}: {reason}", file=path, reason=one) if path else one
            say(shown(labelled(name, sentence), catalogue), file=sys.stderr)


def progress_bar(what: str) -> Any:
    """Return a `Progress` that draws a bar on a terminal and nothing elsewhere."""

    def drawn(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
        return tqdm(items, total=total, desc=printable(what), disable=None, leave=False)

    return drawn
