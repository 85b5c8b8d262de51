"""The arguments by which a subcommand takes a survey, and how it tells of what is wrong in it."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any, Iterable, Optional

import xarray as xr
from tqdm import tqdm

from gpr20_analysis.commands.command import DAMAGED, DONE, NOT_COMPLETE
from gpr20_analysis.mid.loading import load_survey

TOLD = 8


def add_survey(parser: argparse.ArgumentParser) -> None:
    """Declare the survey and what may be wrong in it."""
    parser.add_argument(
        "survey",
        type=Path,
        help="folder of a survey, folder of its JSON files, .bag, .mcap, or a .nc or .zarr",
    )
    parser.add_argument(
        "--accept-damaged",
        action="store_true",
        help="leave damaged samples out, marked, instead of refusing the survey",
    )


def load(chosen: argparse.Namespace) -> xr.Dataset:
    """Load the survey that was named, and say on stderr what is missing or damaged in it.

    Raises:
        AnalysisError: It cannot be loaded.
    """
    survey = load_survey(chosen.survey, chosen.accept_damaged, progress_bar("reading traces"))
    tell(survey)
    return survey


def status_of(survey: xr.Dataset) -> int:
    """Return the exit status that says how whole a survey is, or was before steps filled it."""
    if survey.attrs.get("faults"):
        return DAMAGED
    return NOT_COMPLETE if survey.attrs.get("missing") else DONE


def tell(survey: xr.Dataset, where: str = "") -> None:
    """Say on stderr what is missing or damaged in a survey."""
    for key, word in (("faults", "DAMAGED"), ("missing", "NO NUMBERS"), ("notes", "note")):
        sentences = survey.attrs.get(key, [])
        for sentence in sentences[:TOLD]:
            print(f"{word}{where}: {sentence}", file=sys.stderr)
        if len(sentences) > TOLD:
            print(f"{word}{where}: and {len(sentences) - TOLD} more", file=sys.stderr)


def progress_bar(what: str) -> Any:
    """Return a `Progress` that draws a bar on a terminal and is silent elsewhere."""

    def shown(items: Iterable[Any], total: Optional[int]) -> Iterable[Any]:
        return tqdm(items, total=total, desc=what, disable=None, leave=False)

    return shown
