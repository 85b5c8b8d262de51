"""Child processes of the lowest priority that make the bags of surveys that have ended."""

from __future__ import annotations

import subprocess
import sys
import threading
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Callable, Dict, Optional, Tuple

from gpr20_common.errors import os_reason
from gpr20_common.faults import DISK_FULL
from gpr20_common.low.thread_fault import log_fault
from gpr20_common.message import Message, verbatim
from gpr20_common.sent_message import received_message
from gpr20_common.terminal_text import printable
from gpr20_survey.faults import BAG_MISSING
from gpr20_survey.folder.survey_folder import BAG_FILE, MCAP_FILE
from gpr20_survey.recording.mcap_reader import StoredMcap

PROGRAM = ("nice", "-n", "19", sys.executable, "-m", "gpr20_survey.recording.bag")
END_LIMIT_S = 3.0


def bag_bytes(folder: Path) -> int:
    """Return how much the bag of a survey takes at most [bytes]; 0: nothing can be read."""
    try:
        return StoredMcap(folder / MCAP_FILE).bag_bytes()
    except OSError:
        return 0


class BagProcesses:
    """Makes one bag after the other, beside the next survey; any thread may call it.

    A bag is whole or not there, and the survey is complete without it.
    """

    def __init__(self, free_bytes: Callable[[Path], int], disk_reserve_bytes: int) -> None:
        """Begin with none; each must leave a reserve of the bytes that are free below a folder."""
        self._free_bytes = free_bytes
        self._disk_reserve_bytes = disk_reserve_bytes
        self._pool = ThreadPoolExecutor(1, "bags")
        self._lock = threading.Lock()  # guards all below
        # Those that are not made yet, each with what says that it was cancelled.
        self._bags: Dict[Path, Tuple[Future, threading.Event]] = {}
        self._child: Optional[Tuple[Path, subprocess.Popen]] = None
        self._failed: Optional[Tuple[Path, Message]] = None  # a survey, and why it has no bag

    def make(self, folder: Path) -> None:
        """Make the bag of a survey that has ended, soon; do not wait."""
        with self._lock:
            cancelled = threading.Event()
            self._bags[folder] = self._pool.submit(self._make, folder, cancelled), cancelled

    def cancel(self, folder: Path) -> None:
        """Make no bag of a survey that is resumed."""
        with self._lock:
            bag, cancelled = self._bags.pop(folder, (None, threading.Event()))
            cancelled.set()
            if self._failed is not None and self._failed[0] == folder:
                self._failed = None
            if self._child is not None and self._child[0] == folder:
                self._child[1].terminate()
        if bag is not None and not bag.cancel():
            wait([bag], END_LIMIT_S)

    def outstanding_bytes(self) -> int:
        """Return how much the bags that are not made yet will take on the disk [bytes]."""
        with self._lock:
            return sum(map(bag_bytes, self._bags))

    def problem(self) -> Optional[Message]:
        """Return which bag could not be made, and why; None once it is there."""
        with self._lock:
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
        with self._lock:
            bags = {folder: bag for folder, (bag, _cancelled) in self._bags.items()}
        wait(bags.values(), limit_s)
        for folder in bags:
            self.cancel(folder)
        self._pool.shutdown(wait=False)

    def _make(self, folder: Path, cancelled: threading.Event) -> None:
        try:
            failure = self._failure(folder, cancelled)
        except Exception as error:  # which the pool would keep
            log_fault("bags")
            failure = verbatim(str(error))
        with self._lock:
            self._child = None
            if not cancelled.is_set():
                self._bags.pop(folder, None)
                self._failed = self._failed if failure is None else (folder, failure)

    def _failure(self, folder: Path, cancelled: threading.Event) -> Optional[Message]:
        """Make a bag; return why that failed."""
        try:
            if self._free_bytes(folder) < bag_bytes(folder) + self._disk_reserve_bytes:
                return Message("the disk has too little space").with_fault(DISK_FULL)
            with self._lock:
                if cancelled.is_set():
                    return None
                # In a session of its own: Ctrl-C is for the node, which waits.
                child = subprocess.Popen(
                    [*PROGRAM, str(folder)], stdout=subprocess.PIPE, start_new_session=True
                )
                self._child = folder, child
        except OSError as error:
            return os_reason(error)
        said = child.communicate()[0].decode("utf-8", "replace")
        if child.returncode == 0:
            return None
        if not said:
            return Message("its process ended with status {status}", status=child.returncode)
        return received_message(said, said)
