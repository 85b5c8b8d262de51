"""Loads a survey, whatever holds it, as one Dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Union

import dask.array
import xarray as xr

from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.low.spool import Spool, flush
from gpr20_analysis.mid import dataset, dataset_files
from gpr20_analysis.mid.assembly import assemble
from gpr20_analysis.mid.dataset_check import checked
from gpr20_analysis.mid.sources import open_source
from gpr20_analysis.mid.survey_source import Progress, silent

LAZY_BYTES = 1 << 30
"""Above this size of the numbers [bytes] a survey is lazy."""


def load_survey(
    path: Union[str, Path],
    accept_damaged: bool = False,
    progress: Progress = silent,
    lazy_bytes: int = LAZY_BYTES,
) -> xr.Dataset:
    """Load a survey; `gpr20_analysis.mid.dataset` describes what comes out.

    Args:
        path: Folder of a survey, folder of its trace files, bag, MCAP, or a Dataset written by
            `gpr20` as .nc or .zarr.
        accept_damaged: Leave damaged samples out, marked in `quality` and named in attribute
            `faults`, instead of refusing the survey. Samples that are merely missing are never
            refused: they are NaN, marked, and named in attribute `missing`.
        progress: Shows how far it has come.
        lazy_bytes: If the numbers are larger than this [bytes], they are checked once and then
            kept in a temporary file, and `s21` is a dask array in chunks of whole rows. A .nc or
            .zarr is read where it is.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted.
        AnalysisError: It is no survey.
        OSError: It cannot be read.
    """
    found = Path(path)
    if found.exists() and not (found.is_file() or found.is_dir()):
        raise AnalysisError(f"{found} is neither a file nor a folder, so there is no survey in it")
    if dataset_files.is_dataset(found):
        return checked(dataset_files.read_dataset(found, lazy_bytes), found.name, accept_damaged)
    spool = Spool(lazy_bytes)
    survey = assemble(open_source(found), accept_damaged, progress, spool.allocate)
    return _lazy(survey, spool)


def _lazy(survey: xr.Dataset, spool: Spool) -> xr.Dataset:
    s21 = survey[dataset.S21]
    stored = spool.stored(s21.shape)
    if stored is None:
        return survey
    flush(s21.values)
    row_bytes = s21.nbytes // (s21.shape[0] * s21.shape[1])
    rows = max(1, dataset_files.CHUNK_BYTES // row_bytes)
    array = dask.array.from_array(stored, chunks=(1, rows, -1, -1), name=False)
    return survey.assign({dataset.S21: (s21.dims, array, s21.attrs)})
