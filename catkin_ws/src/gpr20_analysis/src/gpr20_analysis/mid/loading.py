"""Loads a survey, whatever holds it, as one Dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Union

import xarray as xr

from gpr20_analysis.mid import dataset_files
from gpr20_analysis.mid.assembly import assemble
from gpr20_analysis.mid.sources import open_source
from gpr20_analysis.mid.survey_source import Progress, silent


def load_survey(
    path: Union[str, Path], accept_damaged: bool = False, progress: Progress = silent
) -> xr.Dataset:
    """Load a survey; `gpr20_analysis.mid.dataset` describes what comes out.

    Args:
        path: Folder of a survey, folder of its trace files, bag, MCAP, or a Dataset written by
            `gpr20` as .nc or .zarr.
        accept_damaged: Leave damaged samples out, marked in `quality` and named in attribute
            `faults`, instead of refusing the survey. Samples that are merely missing are never
            refused: they are NaN, marked, and named in attribute `missing`.
        progress: Shows how far it has come.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted.
        AnalysisError: It is no survey.
        OSError: It cannot be read.
    """
    found = Path(path)
    if dataset_files.is_dataset(found):
        return dataset_files.read_dataset(found)
    return assemble(open_source(found), accept_damaged, progress)
