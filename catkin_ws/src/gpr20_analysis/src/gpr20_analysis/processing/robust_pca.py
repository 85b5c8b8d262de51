"""Robust principal components: clutter is of low rank, targets are sparse in time and place."""

from __future__ import annotations

from typing import Tuple

import numpy as np
import scipy.fft
import xarray as xr

from gpr20_analysis.dataset import S21, S21_DIMS, require, require_complete
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.work import require_bytes
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message

MOST_ITERATIONS = 200
# Relative to the data: where the decomposition has converged.
TOLERANCE = 1e-7
# As in Lin, Chen and Ma, "The augmented Lagrange multiplier method for exact recovery of corrupted
# low-rank matrices", 2010: first penalty, its growth, and its largest value.
FIRST_PENALTY, GROWTH, LARGEST_PENALTY = 1.25, 1.5, 1e7
# Copies of one polarization that the iteration holds.
COPIES = 8.0


def remove_low_rank(survey: xr.Dataset, sparsity: float = 1.0) -> xr.Dataset:
    """Remove clutter by robust principal component analysis of each polarization.

    The matrix of traces over time is split into one of low rank, the clutter, and one that is
    sparse, by principal component pursuit. It is solved by inexact augmented Lagrange
    multipliers on complex A-scans; the result is spectra again.

    Args:
        survey: Dataset with `s21`, without missing samples.
        sparsity: Weight of the sparse part relative to 1 / sqrt(larger side of the matrix); less
            leaves more in the data, more removes more.

    Raises:
        WrongDatasetError: The weight is not positive, or the data have a single trace.
        DamagedSurveyError: A sample is missing.
        TooLargeError: The survey does not fit into the memory.
    """
    if not sparsity > 0.0:
        raise WrongDatasetError(
            Message(
                "the sparsity of the step rpca is {sparsity:g}; it must be more than 0",
                sparsity=sparsity,
            ),
            fault=NOT_ALLOWED,
        )
    measured = require(survey, S21, S21_DIMS)
    require_complete(survey, Message("robust PCA"))
    if measured.sizes["y"] * measured.sizes["x"] < 2:
        raise WrongDatasetError(Message("robust PCA needs two or more traces"))
    require_bytes(COPIES * measured[0].nbytes, Message("robust PCA"))
    values = measured.values.copy()
    for turn in range(len(values)):
        traces = values[turn].reshape(-1, values.shape[-1])
        # A unitary transform: the rank is that of the spectra.
        in_time = scipy.fft.ifft(traces, axis=-1, norm="ortho")
        low_rank, _ = principal_component_pursuit(in_time, sparsity / np.sqrt(max(traces.shape)))
        traces -= scipy.fft.fft(low_rank, axis=-1, norm="ortho")
    return survey.assign({S21: measured.copy(data=values)})


def principal_component_pursuit(matrix: np.ndarray, weight: float) -> Tuple[np.ndarray, np.ndarray]:
    """Return a matrix of low rank and a sparse one whose sum is the given matrix.

    Args:
        matrix: Complex matrix.
        weight: Weight of the sum of magnitudes relative to the sum of singular values.

    Raises:
        WrongDatasetError: The iteration does not converge.
    """
    size = float(np.linalg.norm(matrix))
    if size == 0.0:
        return matrix.copy(), matrix.copy()
    largest = float(np.linalg.norm(matrix, 2))
    multiplier = matrix / max(largest, float(np.abs(matrix).max()) / weight)
    penalty = FIRST_PENALTY / largest
    most = penalty * LARGEST_PENALTY
    sparse = np.zeros_like(matrix)
    for _ in range(MOST_ITERATIONS):
        low_rank = _shrunk_rank(matrix - sparse + multiplier / penalty, 1.0 / penalty)
        sparse = _shrunk(matrix - low_rank + multiplier / penalty, weight / penalty)
        left = matrix - low_rank - sparse
        multiplier += penalty * left
        penalty = min(GROWTH * penalty, most)
        if np.linalg.norm(left) < TOLERANCE * size:
            return low_rank, sparse
    raise WrongDatasetError(
        Message(
            "robust PCA did not converge in {count} iterations; use another sparsity",
            count=MOST_ITERATIONS,
        )
    )


def _shrunk(values: np.ndarray, by: float) -> np.ndarray:
    """Return values whose magnitude is less by a number, 0 where it was smaller."""
    magnitude = np.abs(values)
    shrunk: np.ndarray = values * (np.maximum(magnitude - by, 0.0) / np.maximum(magnitude, 1e-300))
    return shrunk


def _shrunk_rank(matrix: np.ndarray, by: float) -> np.ndarray:
    """Return a matrix whose singular values are less by a number, 0 where they were smaller."""
    if matrix.shape[0] < matrix.shape[1]:
        return _shrunk_rank(matrix.conj().T, by).conj().T
    # Of a tall matrix only the few components that are left are needed.
    products = matrix.conj().T @ matrix
    from scipy.linalg import eigh  # its import takes 0.1 s

    squares, components = eigh(products, subset_by_value=(by**2, np.inf))
    shrunk: np.ndarray = ((matrix @ components) * (1.0 - by / np.sqrt(squares))) @ (
        components.conj().T
    )
    return shrunk
