"""Summaries of surveys that have not changed since they were made."""

from __future__ import annotations

import os
import time
from collections import OrderedDict
from pathlib import Path
from typing import Callable, Generic, Optional, Tuple, TypeVar

from gpr20_survey.folder import survey_folder

Summary = TypeVar("Summary")
MOST_KEPT = 1000
# The system marks changes only every few milliseconds, some file systems every two seconds: of a
# folder that changed less than this ago another change may not show.
SETTLED_NS = 3 * 10**9

Version = Tuple[Tuple[int, int, int], ...]


class RecentSummaries(Generic[Summary]):
    """Makes a summary only if the survey's folder differs from when it was made last.

    Args:
        make: Makes the summary of a folder.
        now_ns: Time of day [ns].
    """

    def __init__(
        self, make: Callable[[Path], Summary], now_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._make = make
        self._now_ns = now_ns
        self._kept: OrderedDict[str, Tuple[Version, Summary]] = OrderedDict()

    def of(self, folder: Path) -> Summary:
        """Return the summary of a survey."""
        version = _version(folder)
        kept = self._kept.get(folder.name)
        if kept is not None and kept[0] == version:
            return kept[1]
        summary = self._make(folder)
        self._kept.pop(folder.name, None)
        if version is not None and self._now_ns() - max(one[0] for one in version) > SETTLED_NS:
            self._kept[folder.name] = version, summary
            if len(self._kept) > MOST_KEPT:
                self._kept.popitem(last=False)
        return summary


def _version(folder: Path) -> Optional[Version]:
    """Return what changes with a survey; None if part of it is missing."""
    try:
        found = [
            os.lstat(str(one))
            for one in (
                folder,
                folder / survey_folder.TRACES_FOLDER,
                folder / survey_folder.LOG_FILE,
            )
        ]
    except OSError:
        return None  # the summary says what is missing
    return tuple((one.st_mtime_ns, one.st_size, one.st_ino) for one in found)
