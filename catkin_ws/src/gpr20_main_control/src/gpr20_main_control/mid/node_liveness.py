"""Which nodes of the robot are there."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Mapping, Optional

from gpr20_common.errors import NodeSilentError
from gpr20_common.low.clock import Clock
from gpr20_main_control.errors import NodeLostError

# Nodes that were launched together are all there after so long [s].
START_LIMIT_S = 15.0
# A node that dies is noticed after one period, one that hangs after the answer's limit too.
PERIOD_S = 0.4
ANSWER_LIMIT_S = 1.2
REFRESH_LIMIT_S = 2.0 * ANSWER_LIMIT_S

# Returns the number of a node's process, or raises NodeSilentError.
Probe = Callable[[], int]


class NodeLiveness:
    """Asks the nodes again and again and keeps what is known of each.

    Each node is asked in a thread of its own, so that one that hangs delays no other. Every
    method may be called from any thread.
    """

    def __init__(
        self,
        probes: Mapping[str, Probe],
        clock: Clock,
        on_change: Callable[[str], None],
        period_s: float = PERIOD_S,
    ) -> None:
        """Begin with nodes of which nothing is known; `start` begins to ask.

        Args:
            probes: The nodes that a survey needs.
            clock: Decides how long nodes are given to appear.
            on_change: Called with the nodes that are missing, in a sentence that is empty if
                none is.
            period_s: How often each node is asked [s].
        """
        self._probes = probes
        self._clock = clock
        self._on_change = on_change
        self._period_s = period_s
        self._changed = threading.Condition()
        self._processes: Dict[str, Optional[int]] = dict.fromkeys(probes)
        self._accepted: Dict[str, Optional[int]] = dict(self._processes)
        self._seen: Dict[str, bool] = dict.fromkeys(probes, False)
        self._reported = ""
        self._patient_until_s = clock.now_s() + START_LIMIT_S
        self._asked: Dict[str, int] = dict.fromkeys(probes, 0)
        self._answered: Dict[str, int] = dict.fromkeys(probes, 0)
        self._refreshes = 0
        self._ended = False

    def start(self) -> None:
        """Begin to ask."""
        for name in self._probes:
            threading.Thread(
                target=self._watch, args=(name,), name=f"watch {name}", daemon=True
            ).start()

    def stop(self) -> None:
        """Ask no more."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def refresh(self) -> None:
        """Return when every node was asked after now, at the latest after REFRESH_LIMIT_S."""
        with self._changed:
            wanted = {name: asked + 1 for name, asked in self._asked.items()}
            self._refreshes += 1
            self._changed.notify_all()
            self._changed.wait_for(
                lambda: all(self._answered[name] >= wanted[name] for name in wanted),
                REFRESH_LIMIT_S,
            )

    def note_alive(self, name: str, process: int) -> None:
        """Note that a node has answered, and the number of its process."""
        with self._changed:
            self._processes[name] = process
            self._seen[name] = True
            self._report_missing()

    def note_silent(self, name: str) -> None:
        """Note that a node did not answer."""
        with self._changed:
            self._processes[name] = None
            self._report_missing()

    def missing(self) -> List[str]:
        """Return the nodes that do not answer."""
        with self._changed:
            return [name for name, process in self._processes.items() if process is None]

    def accept(self) -> None:
        """Take the nodes as they are now for those with which the survey continues."""
        with self._changed:
            self._accepted = dict(self._processes)

    def lost(self) -> str:
        """Say which nodes went silent or are others than accepted; empty if none."""
        with self._changed:
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
        """Refuse to continue with nodes that are missing or others than accepted.

        Raises:
            NodeLostError: Names them.
        """
        lost = self.lost()
        if lost:
            raise NodeLostError(lost)

    def _report_missing(self) -> None:
        patient = self._clock.now_s() < self._patient_until_s
        missing = [name for name in self.missing() if self._seen[name] or not patient]
        sentence = _missing_sentence(missing) if missing else ""
        if sentence != self._reported:
            self._reported = sentence
            self._on_change(sentence)

    def _watch(self, name: str) -> None:
        while True:
            with self._changed:
                if self._ended:
                    return
                self._asked[name] += 1
                refreshes = self._refreshes
            try:
                self.note_alive(name, self._probes[name]())
            except NodeSilentError:
                self.note_silent(name)
            with self._changed:
                self._answered[name] = self._asked[name]
                self._changed.notify_all()
                self._changed.wait_for(
                    lambda before=refreshes: self._ended or self._refreshes != before,  # type: ignore[misc]
                    self._period_s,
                )


def _missing_sentence(missing: List[str]) -> str:
    return f"{' and '.join(missing)} {'do' if len(missing) > 1 else 'does'} not answer"
