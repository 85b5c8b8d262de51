"""Asking all nodes of the robot again and again whether they are there."""

from __future__ import annotations

import threading
from typing import Callable, Dict, List, Mapping, Protocol

from gpr20_common.errors import NodeSilentError

# A node that dies is noticed after one period, one that hangs after the answer's limit too.
PERIOD_S = 0.4
ANSWER_LIMIT_S = 1.2
REFRESH_LIMIT_S = 2.0 * ANSWER_LIMIT_S


class Probe(Protocol):
    """Asks one node."""

    def process(self) -> int:
        """Return the number of its process, or raise NodeSilentError."""


class NodeWatcher:
    """Asks each node in a thread of its own, so that one that hangs delays no other."""

    def __init__(self, probes: Mapping[str, Probe], period_s: float = PERIOD_S) -> None:
        self._probes = probes
        self._period_s = period_s
        self._ended = False
        self._changed = threading.Condition()
        self._begun: Dict[str, int] = dict.fromkeys(probes, 0)
        self._answered: Dict[str, int] = dict.fromkeys(probes, 0)
        self._wanted = 0

    @property
    def names(self) -> List[str]:
        """The nodes that are asked."""
        return list(self._probes)

    def start(
        self, note_alive: Callable[[str, int], None], note_silent: Callable[[str], None]
    ) -> None:
        """Begin to ask, and tell of every answer and every silence."""
        for name, probe in self._probes.items():
            threading.Thread(
                target=self._watch,
                args=(name, probe, note_alive, note_silent),
                name=f"watch {name}",
                daemon=True,
            ).start()

    def refresh(self) -> None:
        """Return when every node was asked after now, at the latest after REFRESH_LIMIT_S."""
        with self._changed:
            asked_after = {name: begun + 1 for name, begun in self._begun.items()}
            self._wanted += 1
            self._changed.notify_all()
            self._changed.wait_for(
                lambda: all(self._answered[name] >= asked_after[name] for name in asked_after),
                REFRESH_LIMIT_S,
            )

    def stop(self) -> None:
        """Ask no more."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _watch(
        self,
        name: str,
        probe: Probe,
        note_alive: Callable[[str, int], None],
        note_silent: Callable[[str], None],
    ) -> None:
        while True:
            with self._changed:
                if self._ended:
                    return
                self._begun[name] += 1
                wanted = self._wanted
            try:
                note_alive(name, probe.process())
            except NodeSilentError:
                note_silent(name)
            with self._changed:
                self._answered[name] = self._begun[name]
                self._changed.notify_all()
                self._changed.wait_for(
                    lambda wanted=wanted: self._ended or self._wanted != wanted,  # type: ignore[misc]
                    self._period_s,
                )
