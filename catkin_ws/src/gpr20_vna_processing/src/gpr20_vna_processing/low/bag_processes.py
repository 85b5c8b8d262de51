"""Child processes of the lowest priority that make the bags of surveys that have ended."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections import deque
from pathlib import Path
from typing import Callable, Deque, Optional, Tuple

from gpr20_common.faults import DISK_FULL
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.sent_message import received_message
from gpr20_common.terminal_text import printable
from gpr20_survey.folder.survey_folder import BAG_FILE, MCAP_FILE
from gpr20_vna_processing.faults import BAG_MISSING

PROGRAM = ("nice", "-n", "19", sys.executable, "-m", "gpr20_survey.recording.bag")
END_LIMIT_S = 3.0
BAG_TO_MCAP = 2
"""How much larger a bag is than its MCAP, at most: lz4 packs less than zstd."""


def bag_bytes(folder: Path) -> int:
    """Return how much the bag of a survey takes at most [bytes]; 0 without a recording."""
    path = folder / MCAP_FILE
    return BAG_TO_MCAP * path.lstat().st_size if path.is_file() else 0


class BagProcesses:
    """Makes one bag after the other, beside the next survey; any thread may call it.

    A bag is whole or not there, and the survey is complete without it.
    """

    def __init__(self, free_bytes: Callable[[Path], int], disk_reserve_bytes: int) -> None:
        """Start the thread that waits for the processes.

        Args:
            free_bytes: What may still be written below a folder [bytes].
            disk_reserve_bytes: What a bag must leave free [bytes].
        """
        self._free_bytes = free_bytes
        self._disk_reserve_bytes = disk_reserve_bytes
        self._changed = threading.Condition()  # guards all below
        self._folders: Deque[Path] = deque()  # the bag of the first one is being made
        self._child: Optional[subprocess.Popen] = None
        self._stopping = False
        self._failed: Optional[Tuple[Path, Message]] = None  # a survey, and why it has no bag
        threading.Thread(target=self._run, name="bags", daemon=True).start()

    def make(self, folder: Path) -> None:
        """Make the bag of a survey that has ended, soon; do not wait."""
        with self._changed:
            self._folders.append(folder)
            self._changed.notify_all()

    def cancel(self, folder: Path) -> None:
        """Make no bag of a survey that is resumed."""
        with self._changed:
            is_first = folder in list(self._folders)[:1]
            self._folders = deque(one for one in self._folders if one != folder)
            if self._failed is not None and self._failed[0] == folder:
                self._failed = None
            if is_first:
                self._end_child()

    def outstanding_bytes(self) -> int:
        """Return how much the bags that are not made yet will take on the disk [bytes]."""
        with self._changed:
            return sum(map(bag_bytes, self._folders))

    def problem(self) -> Optional[Message]:
        """Return which bag could not be made, and why; None once it is there."""
        with self._changed:
            failed = self._failed
        if failed is None or (failed[0] / BAG_FILE).exists():
            return None
        problem = Message(
            "{file} of the survey in {folder} could not be made: {reason}; the survey is complete "
            "without it, and `gpr20 export --format bag {folder}` makes it",
            file=BAG_FILE,
            folder=printable(failed[0]),
            reason=failed[1],
        )
        return problem.with_fault(BAG_MISSING).as_warning()

    def stop(self, limit_s: float) -> None:
        """Wait for the bags that are not made yet [s], and end what makes one then."""
        with self._changed:
            self._changed.wait_for(lambda: not self._folders, limit_s)
            self._stopping = True
            self._folders.clear()
            self._changed.notify_all()
            self._end_child()

    def _end_child(self) -> None:
        if self._child is not None:
            self._child.terminate()
            self._changed.wait_for(lambda: self._child is None, END_LIMIT_S)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._folders or self._stopping)
                if self._stopping:
                    return
                folder = self._folders[0]
            reason = self._make(folder)
            with self._changed:
                self._child = None
                if self._folders and self._folders[0] is folder:  # it was not cancelled
                    self._folders.popleft()
                    self._failed = self._failed if reason is None else (folder, reason)
                self._changed.notify_all()

    def _make(self, folder: Path) -> Optional[Message]:
        """Make a bag; return why that failed."""
        try:
            if self._free_bytes(folder) < bag_bytes(folder) + self._disk_reserve_bytes:
                return Message("the disk has too little space").with_fault(DISK_FULL)
            with self._changed:
                if not (self._folders and self._folders[0] is folder):
                    return None
                # In a session of its own: Ctrl-C is for the node, which waits.
                child = self._child = subprocess.Popen(
                    [*PROGRAM, str(folder)], stdout=subprocess.PIPE, start_new_session=True
                )
        except OSError as error:
            return os_reason(error)
        said = child.communicate()[0].decode("utf-8", "replace")
        if child.returncode == 0:
            return None
        if not said:
            return Message("its process ended with status {status}", status=child.returncode)
        return received_message(said, said)
