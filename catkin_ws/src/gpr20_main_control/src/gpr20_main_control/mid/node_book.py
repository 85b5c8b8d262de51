"""Which nodes of the robot are there."""

from __future__ import annotations

import threading
from typing import Callable, Dict, Iterable, List, Optional

from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import NodeLostError

# Nodes that were launched together are all there after so long [s].
START_LIMIT_S = 15.0


class NodeBook:
    """Keeps what is known of each node. Its methods may be called from any thread."""

    def __init__(
        self,
        names: Iterable[str],
        clock: Clock,
        on_change: Callable[[str], None],
        refresh: Callable[[], None],
    ) -> None:
        """Begin with nodes of which nothing is known.

        Args:
            names: The nodes that a survey needs.
            clock: Decides how long nodes are given to appear.
            on_change: Told which nodes are missing, in a sentence that is empty if none is.
            refresh: Asks every node again and returns when all have answered or are silent.
        """
        self._clock = clock
        self._on_change = on_change
        self._refresh = refresh
        self._lock = threading.RLock()
        self._processes: Dict[str, Optional[int]] = dict.fromkeys(names)
        self._accepted: Dict[str, Optional[int]] = dict(self._processes)
        self._seen: Dict[str, bool] = dict.fromkeys(self._processes, False)
        self._told = ""
        self._patient_until_s = clock.now_s() + START_LIMIT_S

    def note_alive(self, name: str, process: int) -> None:
        """Note that a node has answered, and the number of its process."""
        with self._lock:
            self._processes[name] = process
            self._seen[name] = True
            self._tell()

    def note_silent(self, name: str) -> None:
        """Note that a node did not answer."""
        with self._lock:
            self._processes[name] = None
            self._tell()

    def refresh(self) -> None:
        """Ask every node now; returns within a few seconds."""
        self._refresh()

    def missing(self) -> List[str]:
        """Return the nodes that do not answer."""
        with self._lock:
            return [name for name, process in self._processes.items() if process is None]

    def accept(self) -> None:
        """Take the nodes as they are now for those with which the survey goes on."""
        with self._lock:
            self._accepted = dict(self._processes)

    def lost(self) -> str:
        """Say which nodes went silent or are others than accepted; empty if none."""
        with self._lock:
            missing = self.missing()
            others = [
                name
                for name, process in self._processes.items()
                if process is not None and process != self._accepted[name]
            ]
        sentences = [f"{' and '.join(missing)} went silent"] if missing else []
        if others:
            sentences.append(f"{' and '.join(others)} started anew")
        return ", ".join(sentences)

    def check(self) -> None:
        """Refuse to go on with nodes that are missing or others than accepted.

        Raises:
            NodeLostError: Names them.
        """
        lost = self.lost()
        if lost:
            raise NodeLostError(lost)

    def _tell(self) -> None:
        patient = self._clock.now_s() < self._patient_until_s
        missing = [name for name in self.missing() if self._seen[name] or not patient]
        sentence = _missing_sentence(missing) if missing else ""
        if sentence != self._told:
            self._told = sentence
            self._on_change(sentence)


def _missing_sentence(missing: List[str]) -> str:
    return f"{' and '.join(missing)} {'do' if len(missing) > 1 else 'does'} not answer"
