"""Loads a survey of any form as one Dataset."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any, List, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import dataset
from gpr20_analysis.formats.dataset_check import checked
from gpr20_analysis.formats.dataset_files import CHUNK_BYTES, is_dataset, read_dataset
from gpr20_analysis.formats.recognition import refuse_device, refuse_importable
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read.assembly import assemble
from gpr20_analysis.read.recordings import is_recording
from gpr20_analysis.read.sources import open_source
from gpr20_analysis.read.trace_table import EMPTY, in_memory
from gpr20_survey.folder.survey_folder import LOG_FILE

LAZY_BYTES = 1 << 30
"""A survey with more data than this [bytes] is lazy."""
COMPLEX = np.dtype(np.complex128)


def load_survey(
    path: Union[str, Path],
    accept_damaged: bool = False,
    progress: Progress = no_progress,
    lazy_bytes: int = LAZY_BYTES,
) -> xr.Dataset:
    """Load a survey as a Dataset, as `gpr20_analysis.dataset` describes it.

    Args:
        path: Folder of a survey, folder of its trace files, bag, MCAP, or a Dataset written by
            `gpr20` as .nc or .zarr.
        accept_damaged: Leave damaged samples out, marked in `quality` and named in attribute
            `faults`, instead of refusing the survey. Samples that are merely missing are never
            refused: they are NaN, marked, and named in attribute `missing`.
        progress: Shows the progress.
        lazy_bytes: If the data are larger than this [bytes], they are checked once and stored
            in a temporary file, and `s21` is a dask array in chunks of whole rows. A .nc or
            .zarr is read in place.

    Returns:
        The Dataset; attribute `doubts` says what of it may not be believed.

    Raises:
        DamagedSurveyError: Something is damaged and that was not accepted.
        AnalysisError: It is not a survey.
        OSError: It cannot be read.
    """
    found = Path(path).expanduser()
    refuse_device(found)
    if is_dataset(found):
        return checked(read_dataset(found, lazy_bytes), found.name, accept_damaged)
    # What is ours is not shown to the formats of other packages.
    if not (is_recording(found) or (found / LOG_FILE).exists()):
        refuse_importable(found)
    made: List[_TemporaryArray] = []

    def allocate(shape: Tuple[int, int]) -> np.ndarray:
        if shape[0] * shape[1] * COMPLEX.itemsize <= lazy_bytes:
            return in_memory(shape)
        made.append(_TemporaryArray(shape))
        return made[-1].filled_with_nan()

    survey = assemble(open_source(found), accept_damaged, progress, allocate)
    s21 = survey[dataset.S21]
    if s21.nbytes <= lazy_bytes:
        return survey
    import dask.array  # its import takes 0.3 s

    row_bytes = s21.nbytes // (s21.shape[0] * s21.shape[1])
    chunks = (1, max(1, CHUNK_BYTES // row_bytes), -1, -1)
    lazy = dask.array.from_array(made[-1].finished(s21.shape), chunks=chunks, name=False)
    return survey.assign({dataset.S21: (s21.dims, lazy, s21.attrs)})


class _TemporaryArray:
    """Data in a temporary file, which is deleted with the last array that reads it.

    A memory map writes each trace to its place in the grid.
    """

    dtype = COMPLEX

    def __init__(self, shape: Tuple[int, ...]) -> None:
        self.shape, self.ndim = shape, len(shape)
        self._folder: Any = tempfile.TemporaryDirectory(prefix="gpr20_")
        self._path = Path(self._folder.name) / "numbers"
        self._written: Any = None

    def filled_with_nan(self) -> np.ndarray:
        """Return the file's content for writing, filled with NaN.

        Raises:
            OSError: There is no space for it.
        """
        with self._path.open("wb") as stream:
            # Without it a full disk would cause a crash later instead of an error here.
            os.posix_fallocate(stream.fileno(), 0, int(np.prod(self.shape)) * COMPLEX.itemsize)
        self._written = np.memmap(str(self._path), COMPLEX, "r+", shape=self.shape)
        self._written[:] = EMPTY
        return self._written

    def finished(self, shape: Tuple[int, ...]) -> _TemporaryArray:
        """Return the array in another shape, from now on for reading only."""
        self._written.flush()
        self._written, self.shape, self.ndim = None, shape, len(shape)
        return self

    def __getitem__(self, place: Any) -> np.ndarray:
        return np.array(np.memmap(str(self._path), COMPLEX, "r", shape=self.shape)[place])
