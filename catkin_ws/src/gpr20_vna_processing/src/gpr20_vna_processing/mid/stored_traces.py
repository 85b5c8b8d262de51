"""Which indices and samples of a survey are stored, in little memory."""

from __future__ import annotations

import hashlib
from typing import List

import numpy as np


class StoredTraces:
    """Keeps eight bytes per trace: a survey has up to a million of them."""

    def __init__(self) -> None:
        self._digests = np.zeros(1024, np.uint64)  # of the sample at each index; 0: none
        self._count = 0

    def __len__(self) -> int:
        """Return how many traces are stored."""
        return self._count

    def __contains__(self, index: int) -> bool:
        """Say whether the trace of an index is stored."""
        return index < len(self._digests) and bool(self._digests[index])

    def add(self, index: int, sample_id: str) -> None:
        """Note that a trace is stored."""
        if index >= len(self._digests):
            grown = np.zeros(max(index + 1, 2 * len(self._digests)), np.uint64)
            grown[: len(self._digests)] = self._digests
            self._digests = grown
        self._count += not self._digests[index]
        self._digests[index] = _digest(sample_id)

    def indices(self) -> List[int]:
        """Return the indices that are stored, ascending."""
        return [int(index) for index in np.flatnonzero(self._digests)]

    def candidates(self, sample_id: str) -> List[int]:
        """Return the indices that may hold a sample; nearly always that is none or one."""
        return [int(index) for index in np.flatnonzero(self._digests == _digest(sample_id))]


def _digest(sample_id: str) -> np.uint64:
    digest = hashlib.blake2b(sample_id.encode(), digest_size=8).digest()
    return np.uint64(int.from_bytes(digest, "little") or 1)
